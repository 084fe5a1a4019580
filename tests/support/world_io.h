// SPDX-License-Identifier: MIT
// World files in memory, for tests: written by WorldWriter, checked whole by WorldReader, and looked at where
// docs/formats.md says things lie, without the reader.
#pragma once

#include "terrain/file/world_reader.h"
#include "terrain/file/world_writer.h"
#include "tests/support/world_damage.h"

#include <cstddef>
#include <span>
#include <vector>

namespace karst::core {

// Checks the whole file. info is untouched on failure.
inline Status read_world_info(std::span<const std::byte> file, WorldInfo& info) {
  WorldReader reader;
  Status status = reader.open(ByteSource::of(file));
  if (status.ok()) status = reader.verify();
  if (status.ok()) info = reader.info();
  return status;
}

inline Status read_octree(std::span<const std::byte> file, Octree& tree) {
  WorldReader reader;
  if (const Status status = reader.open(ByteSource::of(file)); !status.ok()) return status;
  std::vector<std::byte> room(WorldReader::octree_room(reader.info().octets));
  return reader.read_octree(room, tree);
}

// Views into the file's section of a kind; empty where it has none.
template <class T>
std::span<const T> section_as(std::span<const std::byte> file, const char* letters) {
  const std::span<const std::byte> bytes = section_of(file, letters);
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

inline WorldPatches read_patches(std::span<const std::byte> file) {
  return {section_as<PatchKey>(file, "PKEY"),     section_of(file, "HMSK"),
          section_as<std::int16_t>(file, "HGTS"), section_as<std::uint16_t>(file, "LERR"),
          section_as<PatchBounds>(file, "PBND"),  section_as<NormalCone>(file, "CONE"),
          section_as<NormalCone>(file, "SCON")};
}

inline std::span<const glm::ivec3> rim_of(std::span<const std::byte> file) {
  const std::span<const glm::ivec3> all = section_as<glm::ivec3>(file, "SURR");
  if (all.empty()) return {};
  const std::byte* const first = section_of(file, "SURR").data() + sizeof(Surroundings);
  return {reinterpret_cast<const glm::ivec3*>(first), all.size() - 1};  // 16 bytes are before them
}

// The texels, behind the header and the checksums of rows.
inline std::span<const std::byte> blend_map_of(std::span<const std::byte> file) {
  const std::span<const std::byte> section = section_of(file, "BMAP");
  if (section.empty()) return {};
  std::uint32_t depth = 0;
  std::memcpy(&depth, section.data() + sizeof depth, sizeof depth);
  return section.subspan(material_section::kBlendHeaderBytes + depth * sizeof(std::uint32_t));
}

inline WorldMaterials read_materials(std::span<const std::byte> file) {
  WorldReader reader;
  if (!reader.open(ByteSource::of(file)).ok()) return WorldMaterials();
  return {reader.materials(),
          section_of(file, "MTEX"),
          section_as<std::uint8_t>(file, "MOVR"),
          section_as<PointLight>(file, "LGTS"),
          reader.surroundings(),
          rim_of(file),
          blend_map_of(file)};
}

// out: the file, or what was written of it before a failure.
inline Status write_world(const WorldWriter& writer, std::vector<std::byte>& out) {
  out.clear();
  const auto append = [&](std::span<const std::byte> bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
    return true;
  };
  return writer.run(ByteSink::to(append));
}

}  // namespace karst::core
