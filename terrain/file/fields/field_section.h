// SPDX-License-Identifier: MIT
// The field of an isosurface as bytes of the world file (docs/formats.md): a header, one byte a block, then
// the samples of the blocks that take some; the same of its materials, where it has some. In pieces both
// ways, so that no second copy is needed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core::field_section {

inline constexpr std::size_t kHeaderBytes = 64;

// With info.stored blocks of samples, up to their end.
inline std::uint64_t samples_end(const FieldInfo& info) {
  const std::uint64_t block = FieldBlocks::kBlockBytes * static_cast<std::uint64_t>(info.sample_bits / 8);
  return kHeaderBytes + info.table_blocks() + info.stored * block;
}
// With info.material_blocks blocks of materials.
inline std::uint64_t section_bytes(const FieldInfo& info) {
  if (!info.has_materials) return samples_end(info);
  return samples_end(info) + info.table_blocks() +
         FieldBlocks::kBlockBytes * std::uint64_t{info.material_blocks};
}

// field.info(), with the blocks that take samples and materials now, but for those that are all alike.
FieldInfo info_of(const FieldBlocks& field);

// Writes section_bytes(info_of(field)) bytes, piece by piece. write: of a ByteSink (byte_source.h), handed
// its context. limit_reached ("sink") where it does not take them.
using Write = bool (*)(const void* context, std::span<const std::byte> bytes);
Status encode(const FieldBlocks& field, const void* context, Write write);

struct Fault {
  const char* what = nullptr;  // null: none
  std::uint64_t offset = 0;    // bytes from the section's start
};

// bytes: the first kHeaderBytes, untrusted.
Fault decode_header(std::span<const std::byte> bytes, FieldInfo& info);

// Takes what follows the header.
class Decode {
 public:
  // out: reset to info, or null: bytes are checked alone. materials: that the world has.
  Decode(const FieldInfo& info, std::uint32_t materials, FieldBlocks* out)
      : info_(info), materials_(materials), out_(out) {}

  // The next bytes, of any number.
  Fault feed(std::span<const std::byte> bytes);
  // After the last ones.
  Fault finish() const;

 private:
  Fault take_kind(unsigned kind);
  template <class Sample>
  Fault take_block(ScalarField<Sample>* out);
  Fault take_filling(unsigned code);
  Fault take_codes();
  bool is_known(unsigned code) const;
  glm::ivec3 place(std::size_t block) const;

  static constexpr std::size_t kMostBlockBytes = 2 * FieldBlocks::kBlockBytes;

  FieldInfo info_;
  std::uint32_t materials_;
  FieldBlocks* out_;
  std::uint64_t at_ = kHeaderBytes;
  std::uint32_t stored_ = 0;  // blocks of samples that the kinds have
  std::uint32_t coded_ = 0;   // blocks of materials that the fillings have
  bool any_code_ = false;     // beside by rules
  std::size_t block_ = 0;     // where to look for the one whose samples, or materials, come next
  std::array<std::byte, kMostBlockBytes> samples_{};
  std::size_t used_ = 0;  // bytes of samples_
};

}  // namespace karst::core::field_section
