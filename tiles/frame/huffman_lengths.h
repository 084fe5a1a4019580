// SPDX-License-Identifier: MIT
// Lengths of Huffman codes as zstd has them in a block (RFC 8878, 4.2.1), four bits each or by FSE codes of
// their own, whichever is shorter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::tiles {

inline constexpr std::size_t kMostLengthsBytes = 128;

// weights: of all symbols but the last that occurs, 1 .. 255 of 0 .. 11. Returns bytes of out, or 0 where
// they cannot be told.
std::size_t put_weights(std::span<const std::uint8_t> weights, std::span<std::byte, kMostLengthsBytes> out);

}  // namespace karst::tiles
