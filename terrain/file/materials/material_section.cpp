// SPDX-License-Identifier: MIT
#include "terrain/file/materials/material_section.h"

#include "terrain/base/checksum.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

namespace karst::core::material_section {
namespace {

struct Range {
  const char* what;
  std::size_t offset;  // of a float in the record
  float low, high;
};

// Far outside of these, the shader's smoothstep has no meaning in 32-bit floats. Slopes are within -1..1 and
// heights within 0..512; limits beyond those say "no limit".
constexpr float kMostHeight = 1e6f;
constexpr Range kMaterialRanges[] = {
    {"slope_low is outside -4..4", offsetof(Material, slope_low), -4, 4},
    {"slope_high is outside -4..4", offsetof(Material, slope_high), -4, 4},
    {"slope_soft is outside 0.0001..4", offsetof(Material, slope_soft), 1e-4f, 4},
    {"height_low is outside +-10^6", offsetof(Material, height_low), -kMostHeight, kMostHeight},
    {"height_high is outside +-10^6", offsetof(Material, height_high), -kMostHeight, kMostHeight},
    {"height_soft is outside 0.0001..10^6", offsetof(Material, height_soft), 1e-4f, kMostHeight},
    {"cave is outside 0..1", offsetof(Material, cave), 0, 1},
    {"fray is outside 0..1", offsetof(Material, fray), 0, 1},
    // Colours are divided by it.
    {"average is outside 0.0001..1", offsetof(Material, average), 1e-4f, 1},
    {"average is outside 0.0001..1", offsetof(Material, average) + 4, 1e-4f, 1},
    {"average is outside 0.0001..1", offsetof(Material, average) + 8, 1e-4f, 1},
    {"roughness is outside 0..1", offsetof(Material, roughness), 0, 1},
    {"tint is outside 0..16", offsetof(Material, tint), 0, 16},
    {"tint is outside 0..16", offsetof(Material, tint) + 4, 0, 16},
    {"tint is outside 0..16", offsetof(Material, tint) + 8, 0, 16},
    {"brightness_span is outside 0..16", offsetof(Material, brightness_span), 0, 16},
    {"slope_span is outside 0..64", offsetof(Material, slope_span), 0, 64},
};
constexpr Range kLightRanges[] = {
    {"position of a light is outside +-10^6", 0, -kMostHeight, kMostHeight},
    {"position of a light is outside +-10^6", 4, -kMostHeight, kMostHeight},
    {"position of a light is outside +-10^6", 8, -kMostHeight, kMostHeight},
    {"radius of a light is outside 0.0001..10^6", 12, 1e-4f, kMostHeight},
    {"colour of a light is outside 0..10^6", 16, 0, kMostHeight},
    {"colour of a light is outside 0..10^6", 20, 0, kMostHeight},
    {"colour of a light is outside 0..10^6", 24, 0, kMostHeight},
};

template <class T>
Fault check_ranges(const T& record, std::span<const Range> ranges) {
  std::byte bytes[sizeof(T)];
  std::memcpy(bytes, &record, sizeof record);
  for (const Range& range : ranges) {
    float value;
    std::memcpy(&value, bytes + range.offset, sizeof value);
    // Written so that NaN fails.
    if (!(value >= range.low && value <= range.high)) return {range.what, range.offset};
  }
  return {};
}

Fault check_name(const Material& material) {
  std::size_t length = 0;
  while (length < sizeof material.name && material.name[length] != '\0') {
    if (material.name[length] < 0x20 || material.name[length] > 0x7e)
      return {"name is not printable ASCII", length};
    ++length;
  }
  if (length == 0) return {"name is empty", 0};
  if (length == sizeof material.name) return {"name is not terminated", 0};
  for (std::size_t k = length; k < sizeof material.name; ++k) {
    if (material.name[k] != '\0') return {"name has bytes after its end", k};
  }
  return {};
}

Fault check_material(const Material& material) {
  if (const Fault fault = check_name(material); fault.what != nullptr) return fault;
  if (const Fault fault = check_ranges(material, kMaterialRanges); fault.what != nullptr) return fault;
  if (material.slope_low > material.slope_high)
    return {"slope_low is above slope_high", offsetof(Material, slope_low)};
  if (material.height_low > material.height_high)
    return {"height_low is above height_high", offsetof(Material, height_low)};
  return {};
}

Fault check_sizes(std::uint32_t count, std::uint32_t side, std::uint32_t format, std::int32_t repeat_log2) {
  if (count < 1 || count > kMostMaterials) return {"count is outside 1..8", 0};
  if (side < kLeastTextureSide || side > kMostTextureSide || !std::has_single_bit(side))
    return {"side is not a power of two within 16..1024", 4};
  if (format > static_cast<std::uint32_t>(TextureFormat::etc2))
    return {"format is neither rgba8 nor etc2", 8};
  if (repeat_log2 < kLeastRepeatLog2 || repeat_log2 > kMostRepeatLog2)
    return {"repeat_log2 is outside -16..5", 12};
  return {};
}

}  // namespace

std::size_t image_count(const MaterialSet& set) {
  return image_index(set, TextureArray::near, texture_levels(set.side, TextureArray::near), 0);
}

std::size_t image_index(const MaterialSet& set, TextureArray array, int level, std::uint32_t layer) {
  const int before = array == TextureArray::far ? 0 : texture_levels(set.side, TextureArray::far);
  return static_cast<std::size_t>(before + level) * set.count + layer;
}

std::size_t section_bytes(const MaterialSet& set) {
  return kHeaderBytes + set.count * sizeof(Material) + image_count(set) * sizeof(std::uint32_t);
}

Fault check_set(const MaterialSet& set) {
  if (set.count == 0) return {};
  if (const Fault fault =
          check_sizes(set.count, set.side, static_cast<std::uint32_t>(set.format), set.repeat_log2);
      fault.what != nullptr)
    return fault;
  for (std::uint32_t i = 0; i < set.count; ++i) {
    const Fault fault = check_material(set.materials[i]);
    if (fault.what != nullptr) return {fault.what, kHeaderBytes + i * sizeof(Material) + fault.offset};
  }
  return {};
}

Fault check_lights(std::span<const PointLight> lights) {
  if (lights.size() > kMostLights) return {"more than 16 lights", 0};
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Fault fault = check_ranges(lights[i], kLightRanges);
    if (fault.what != nullptr) return {fault.what, i * sizeof(PointLight) + fault.offset};
    std::uint32_t bits;
    std::memcpy(&bits, &lights[i].reserved, sizeof bits);
    if (bits != 0)
      return {"a reserved field is not 0", i * sizeof(PointLight) + offsetof(PointLight, reserved)};
  }
  return {};
}

Fault check_surroundings(const Surroundings& surroundings, glm::ivec3 extent) {
  if ((surroundings.flags & ~kHasWater) != 0) return {"a flag is not known", 0};
  for (const float level : {surroundings.water_level, surroundings.plain_level}) {
    if (!(std::abs(level) <= kMostHeight)) return {"a level is outside +-10^6", 4};
  }
  if (surroundings.rim_points > most_rim_points(extent)) return {"more than eight rim points a voxel", 12};
  return {};
}

Fault check_rim(std::span<const std::byte> rim) {
  for (std::size_t at = 0; at < rim.size(); at += sizeof(std::int32_t)) {
    std::int32_t value;
    std::memcpy(&value, rim.data() + at, sizeof value);
    if (value < -kMostRimSteps || value > kMostRimSteps)
      return {"a rim point is outside +-2^23 lattice steps", sizeof(Surroundings) + at};
  }
  return {};
}

std::size_t blend_section_bytes(const BlendMap& map) {
  return kBlendHeaderBytes + map.depth * (sizeof(std::uint32_t) + map.width * kBlendTexelBytes);
}

Fault check_blend_map(const BlendMap& map, std::uint32_t materials) {
  if (map.width == 0 && map.depth == 0) return {};
  if (map.width < 1 || map.width > kMostBlendSide) return {"width is outside 1..1024", 0};
  if (map.depth < 1 || map.depth > kMostBlendSide) return {"depth is outside 1..1024", 4};
  for (std::size_t channel = 0; channel < std::size(map.materials); ++channel) {
    const std::uint8_t material = map.materials[channel];
    if (material > materials) return {"a channel has a material that is not there", 8 + channel};
    for (std::size_t other = 0; other < channel; ++other) {
      if (material != 0 && map.materials[other] == material) {
        return {"two channels have the same material", 8 + channel};
      }
    }
  }
  return {};
}

Fault decode_blend_map(std::span<const std::byte, kBlendHeaderBytes> header, std::uint32_t materials,
                       BlendMap& map) {
  BlendMap read;
  std::uint32_t reserved = 0;
  std::memcpy(&read.width, header.data(), sizeof read.width);
  std::memcpy(&read.depth, header.data() + 4, sizeof read.depth);
  std::memcpy(read.materials, header.data() + 8, sizeof read.materials);
  std::memcpy(&reserved, header.data() + 12, sizeof reserved);
  if (!read.exists()) return {"width is outside 1..1024", 0};
  if (const Fault fault = check_blend_map(read, materials); fault.what != nullptr) return fault;
  if (reserved != 0) return {"a reserved field is not 0", 12};
  map = read;
  return {};
}

void encode_blend_header(const BlendMap& map, std::span<std::byte, kBlendHeaderBytes> out) {
  std::fill(out.begin(), out.end(), std::byte{0});
  std::memcpy(out.data(), &map.width, sizeof map.width);
  std::memcpy(out.data() + 4, &map.depth, sizeof map.depth);
  std::memcpy(out.data() + 8, map.materials, sizeof map.materials);
}

Fault decode(std::span<const std::byte> section, MaterialSet& set, std::span<std::uint32_t> crcs) {
  if (section.size() < kHeaderBytes) return {"the section is shorter than its header", 0};
  std::uint32_t header[kHeaderBytes / sizeof(std::uint32_t)];
  std::memcpy(header, section.data(), sizeof header);
  MaterialSet read;
  read.repeat_log2 = static_cast<std::int32_t>(header[3]);
  if (const Fault fault = check_sizes(header[0], header[1], header[2], read.repeat_log2);
      fault.what != nullptr)
    return fault;
  read.count = header[0];
  read.side = header[1];
  read.format = static_cast<TextureFormat>(header[2]);
  if (section.size() != section_bytes(read)) return {"count and side do not fit the section's length", 0};
  const std::size_t records = read.count * sizeof(Material);
  std::memcpy(&read.materials, section.data() + kHeaderBytes, records);
  if (const Fault fault = check_set(read); fault.what != nullptr) return fault;
  std::memcpy(crcs.data(), section.data() + kHeaderBytes + records,
              image_count(read) * sizeof(std::uint32_t));
  set = read;
  return {};
}

void encode(const MaterialSet& set, std::span<const std::byte> textures, std::span<std::byte> out) {
  const std::uint32_t header[] = {set.count, set.side, static_cast<std::uint32_t>(set.format),
                                  static_cast<std::uint32_t>(set.repeat_log2)};
  std::memcpy(out.data(), header, sizeof header);
  const std::size_t records = set.count * sizeof(Material);
  std::memcpy(out.data() + kHeaderBytes, &set.materials, records);
  for (std::size_t k = 0; k < image_count(set); ++k) {
    const std::size_t first = image_offset(set, k);
    const std::uint32_t crc = crc32c(textures.subspan(first, image_offset(set, k + 1) - first));
    std::memcpy(out.data() + kHeaderBytes + records + k * sizeof crc, &crc, sizeof crc);
  }
}

std::size_t image_offset(const MaterialSet& set, std::size_t index) {
  if (index >= image_count(set)) return texture_bytes(set);
  const std::size_t first_near = image_index(set, TextureArray::near, 0, 0);
  const auto array = index < first_near ? TextureArray::far : TextureArray::near;
  const std::size_t within = index < first_near ? index : index - first_near;
  return texture_offset(set, array, static_cast<int>(within / set.count),
                        static_cast<std::uint32_t>(within % set.count));
}

}  // namespace karst::core::material_section
