// SPDX-License-Identifier: MIT
// Writes a zstd frame (RFC 8878) piece by piece, without memory of its own: each piece is a block, as it is,
// as one byte again and again, or by a Huffman code of its own. Repeats are not looked for. Any zstd reads
// it.
#pragma once

#include <cstddef>
#include <span>

namespace karst::tiles {

class FrameWriter {
 public:
  static constexpr std::size_t kMostPiece = 16'383;
  static constexpr std::size_t most_bytes(std::size_t contents, std::size_t pieces) {
    return 7 + 3 * pieces + contents;
  }

  // contents: bytes of all pieces, 256 .. 65,791. out: of most_bytes() at least, borrowed.
  FrameWriter(std::span<std::byte> out, std::size_t contents);
  // 1 .. kMostPiece bytes.
  void add(std::span<const std::byte> piece, bool last);
  std::size_t bytes() const { return used_; }

 private:
  std::span<std::byte> out_;
  std::size_t used_ = 0;
};

}  // namespace karst::tiles
