// SPDX-License-Identifier: MIT
// The field of an isosurface as bytes of the world file (docs/formats.md): a header, one byte a block, then
// the samples of the blocks that take some. In pieces both ways, so that no second copy is needed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/file/byte_source.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core::field_section {

inline constexpr std::size_t kHeaderBytes = 64;

// With info.stored blocks of samples.
inline std::uint64_t section_bytes(const FieldInfo& info) {
  const std::uint64_t block = FieldBlocks::kBlockBytes * static_cast<std::uint64_t>(info.sample_bits / 8);
  return kHeaderBytes + info.table_blocks() + info.stored * block;
}

// field.info(), with the blocks that take samples now, but for those that are all alike.
FieldInfo info_of(const FieldBlocks& field);

// Writes section_bytes(info_of(field)) bytes. limit_reached ("sink") where the sink does not take them.
Status encode(const FieldBlocks& field, const ByteSink& sink);

struct Fault {
  const char* what = nullptr;  // null: none
  std::uint64_t offset = 0;    // bytes from the section's start
};

// bytes: the first kHeaderBytes, untrusted.
Fault decode_header(std::span<const std::byte> bytes, FieldInfo& info);

// Takes what follows the header.
class Decode {
 public:
  // out: reset to info, or null: bytes are checked alone.
  Decode(const FieldInfo& info, FieldBlocks* out) : info_(info), out_(out) {}

  // The next bytes, of any number.
  Fault feed(std::span<const std::byte> bytes);
  // After the last ones.
  Fault finish() const;

 private:
  Fault take_kind(unsigned kind);
  template <class Sample>
  Fault take_block(ScalarField<Sample>* out);
  glm::ivec3 place(std::size_t block) const;

  static constexpr std::size_t kMostBlockBytes = 2 * FieldBlocks::kBlockBytes;

  FieldInfo info_;
  FieldBlocks* out_;
  std::uint64_t at_ = kHeaderBytes;
  std::uint32_t stored_ = 0;  // blocks of samples that the kinds have
  std::size_t block_ = 0;     // where to look for the one whose samples come next
  std::array<std::byte, kMostBlockBytes> samples_{};
  std::size_t used_ = 0;  // bytes of samples_
};

}  // namespace karst::core::field_section
