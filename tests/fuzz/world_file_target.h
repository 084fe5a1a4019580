// SPDX-License-Identifier: MIT
// Reads any bytes as a world file, all the way down, and traps where an accepted file breaks a promise of
// terrain/world/world_file.h. Used by world_file_test.cpp and by libFuzzer (world_file_target.cpp).
#pragma once

#include "terrain/base/arena.h"
#include "terrain/patch/heights.h"
#include "terrain/world/world_file.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace karst {

enum class Reached { rejected, header, octree };

inline void promise(bool kept) {
  if (!kept) __builtin_trap();
}

// A failure says what failed, and where inside the file (or, for a file cut short, at its end).
inline void promise_stated(const Status& status, std::size_t file_bytes) {
  promise(std::strlen(status.what()) > 0 && std::strlen(status.field()) > 0);
  const bool at_offset = status.code() == StatusCode::corrupt || status.code() == StatusCode::unsupported;
  promise(!at_offset || status.value() <= file_bytes);
}

inline Reached fuzz_world_file(std::span<const std::byte> input) {
  constexpr std::uint32_t kPool =
      2048;  // octets; larger trees are refused, as on a board with a small budget
  alignas(Arena::kAlignment) static std::byte memory[kPool * sizeof(Octree::Octet)];
  const std::vector<std::byte> file(input.begin(),
                                    input.end());  // exactly as long, so that overreads are seen
  WorldInfo info;
  Status status = read_world_info(file, info);
  if (!status.ok()) {
    promise_stated(status, file.size());
    return Reached::rejected;
  }
  promise(validate_world_info(info).ok());

  const WorldHeights heights = read_heights(file, info);
  std::uint64_t set = 0;
  for (std::uint32_t p = 0; p < info.patches; ++p) {
    set += std::to_integer<unsigned>(heights.mask[p / 8]) >> p % 8 & 1u;
  }
  promise(set == info.height_blocks);
  promise(heights.samples.size() == set * static_cast<std::uint64_t>(patch_vertices(info.level)));
  for (const std::int16_t s : heights.samples) promise(s >= -kMaxHeight && s <= kMaxHeight);
  promise(heights.level_errors.size() == info.patches * level_error_values(info.level));
  promise(find_level_error_fault(info.level, heights.level_errors) == heights.level_errors.size());

  Arena arena{std::span<std::byte>(memory)};
  Octree tree;
  promise(tree.create(arena, 1, kPool).ok());
  status = read_octree(file, info, tree);
  promise(tree.octets_used() == (status.ok() ? info.octets : 0));
  if (!status.ok()) {
    promise_stated(status, file.size());
    promise(tree.root() == Octree::kEmpty);
    return Reached::header;
  }
  promise(tree.depth() == info.depth);
  promise(tree.count_filled() <= static_cast<std::uint64_t>(info.extent.x) *
                                     static_cast<std::uint64_t>(info.extent.y) *
                                     static_cast<std::uint64_t>(info.extent.z));

  // What was accepted can be written, and read again.
  std::vector<std::byte> copy(world_file_bytes(info));
  std::size_t written = 0;
  promise(write_world(info, tree, heights, copy, written).ok() && written == copy.size());
  WorldInfo again;
  promise(read_world_info(copy, again).ok());
  promise(again.octets == info.octets && again.patches == info.patches && again.extent == info.extent);
  return Reached::octree;
}

}  // namespace karst
