// SPDX-License-Identifier: MIT
// Where the bytes of a world come from: the core does no I/O, its caller reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace karst::core {

struct ByteSource {
  std::uint64_t bytes = 0;        // length of it all
  const void* context = nullptr;  // borrowed, handed to read
  // Fills out with the bytes from offset on; false where it cannot. Never asked for bytes beyond the end.
  bool (*read)(const void* context, std::uint64_t offset, std::span<std::byte> out) = nullptr;

  // Bytes in memory, borrowed.
  static ByteSource of(std::span<const std::byte> memory) {
    return {memory.size(), memory.data(),
            [](const void* from, std::uint64_t offset, std::span<std::byte> out) {
              if (!out.empty())
                std::memcpy(out.data(), static_cast<const std::byte*>(from) + offset, out.size());
              return true;
            }};
  }
};

}  // namespace karst::core
