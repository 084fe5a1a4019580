// SPDX-License-Identifier: MIT
// Where the bytes of a world come from and where they go: the core does no I/O, its caller reads and writes.
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

struct ByteSink {
  const void* context = nullptr;  // borrowed, handed to write
  // Appends the bytes to what was written before; false where it cannot.
  bool (*write)(const void* context, std::span<const std::byte> bytes) = nullptr;

  // Calls out(bytes), which returns whether it could. Borrowed.
  template <class Write>
  static ByteSink to(const Write& out) {
    return {&out, [](const void* to_write, std::span<const std::byte> bytes) -> bool {
              return (*static_cast<const Write*>(to_write))(bytes);
            }};
  }
};

}  // namespace karst::core
