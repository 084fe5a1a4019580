// SPDX-License-Identifier: MIT
// What the contents of a section must be like, the same for reading it whole, for checking it through a small
// buffer and for writing it. For world_reader.cpp and world_writer.cpp alone.
#pragma once

#include "terrain/file/world_file.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

// Of the sections that hold one entry a patch or block: keys, mask, samples, level errors, bounds, overrides.
// Others pass.
class SectionCheck {
 public:
  // Bytes that hold whole entries of every kind: pieces of a section are multiples of it, but the last.
  static constexpr std::size_t kPiece = 24;

  struct Fault {
    const char* what = nullptr;  // null: none
    std::uint64_t offset = 0;    // bytes from the section's start
  };

  // materials: of the world, for overrides.
  SectionCheck(WorldSection section, const WorldInfo& info, std::uint32_t materials);

  // The next bytes of the section, any alignment.
  Fault feed(std::span<const std::byte> bytes);
  // After the last ones: what the whole of them must add up to.
  Fault finish() const;

 private:
  Fault feed_keys(std::span<const std::byte> bytes);
  Fault feed_mask(std::span<const std::byte> bytes);
  Fault feed_level_errors(std::span<const std::byte> bytes);
  const char* key_fault(PatchKey key) const;

  WorldSection section_;
  const WorldInfo& info_;
  std::uint32_t materials_;
  std::uint64_t at_ = 0;     // bytes fed before
  std::uint64_t count_ = 0;  // volumes of the keys, bits of the mask
  std::uint64_t last_ = 0;   // bits of the last key, the last level error
};

}  // namespace karst::core
