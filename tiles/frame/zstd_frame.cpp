// SPDX-License-Identifier: MIT
#include "tiles/frame/zstd_frame.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "terrain/base/check.h"
#include "tiles/frame/huffman_lengths.h"

namespace karst::tiles {
namespace {

constexpr int kSymbols = 256;
constexpr int kMostLength = 11;            // bits of a code
constexpr std::size_t kOneStream = 1'023;  // bytes, at most
enum BlockType : std::uint32_t { kRaw, kSame, kCompressed };

struct Code {
  std::array<std::uint8_t, kSymbols> length{};  // 0: the symbol does not occur
  std::array<std::uint16_t, kSymbols> bits{};
  int last = 0;  // symbol that occurs
  int most_length = 0;
};

void put(std::byte*& out, std::uint64_t value, int bytes) {
  for (int n = 0; n < bytes; ++n) *out++ = static_cast<std::byte>(value >> (8 * n));
}

// D. A. Huffman's, by two queues, with counts halved until no code is too long. Precondition: two symbols
// occur.
void find_lengths(std::array<std::uint32_t, kSymbols> counts, Code& code) {
  std::array<std::uint8_t, kSymbols> order;
  for (;;) {
    int leaves = 0;
    for (int symbol = 0; symbol < kSymbols; ++symbol) {
      if (counts[static_cast<std::size_t>(symbol)] != 0)
        order[static_cast<std::size_t>(leaves++)] = static_cast<std::uint8_t>(symbol);
    }
    KARST_ASSERT(leaves >= 2);
    std::sort(order.begin(), order.begin() + leaves, [&](std::uint8_t a, std::uint8_t b) {
      return counts[a] != counts[b] ? counts[a] < counts[b] : a < b;
    });
    std::array<std::uint32_t, 2 * kSymbols> weight;
    std::array<std::uint16_t, 2 * kSymbols> parent;
    const int nodes = 2 * leaves - 1;
    for (int n = 0; n < leaves; ++n)
      weight[static_cast<std::size_t>(n)] = counts[order[static_cast<std::size_t>(n)]];
    int leaf = 0, inner = leaves;
    for (int made = leaves; made < nodes; ++made) {
      weight[static_cast<std::size_t>(made)] = 0;
      for (int child = 0; child < 2; ++child) {
        const bool takes_leaf =
            leaf < leaves && (inner == made || weight[static_cast<std::size_t>(leaf)] <=
                                                   weight[static_cast<std::size_t>(inner)]);
        const auto taken = static_cast<std::size_t>(takes_leaf ? leaf++ : inner++);
        weight[static_cast<std::size_t>(made)] += weight[taken];
        parent[taken] = static_cast<std::uint16_t>(made);
      }
    }
    std::array<std::uint8_t, 2 * kSymbols> depth;
    depth[static_cast<std::size_t>(nodes - 1)] = 0;
    code.most_length = 0;
    for (int n = nodes - 2; n >= 0; --n) {
      const auto at = static_cast<std::size_t>(n);
      depth[at] = static_cast<std::uint8_t>(depth[parent[at]] + 1);
      code.most_length = std::max<int>(code.most_length, depth[at]);
    }
    if (code.most_length <= kMostLength) {
      for (int n = 0; n < leaves; ++n)
        code.length[order[static_cast<std::size_t>(n)]] = depth[static_cast<std::size_t>(n)];
      return;
    }
    for (std::uint32_t& count : counts) count = (count + 1) / 2;
  }
}

// Codes of a length ascend with their symbols; longer ones are before shorter ones.
void find_bits(Code& code) {
  std::uint32_t next = 0;
  for (int length = code.most_length; length > 0; --length) {
    for (std::size_t symbol = 0; symbol <= static_cast<std::size_t>(code.last); ++symbol) {
      if (code.length[symbol] == length) code.bits[symbol] = static_cast<std::uint16_t>(next++);
    }
    next >>= 1;
  }
}

// Of all symbols but the last; as put_weights().
std::size_t put_lengths(const Code& code, std::span<std::byte, kMostLengthsBytes> out) {
  std::array<std::uint8_t, kSymbols> weights;
  const auto count = static_cast<std::size_t>(code.last);
  for (std::size_t n = 0; n < count; ++n) {
    const int weight = code.length[n] == 0 ? 0 : code.most_length + 1 - code.length[n];
    weights[n] = static_cast<std::uint8_t>(weight);
  }
  return put_weights(std::span(weights).first(count), out);
}

// Read from its end, so that the last symbol is the first. Returns its bytes.
std::size_t put_stream(const Code& code, std::span<const std::byte> symbols, std::byte*& out) {
  const std::byte* const begin = out;
  std::uint64_t bits = 0;
  int count = 0;
  for (std::size_t n = symbols.size(); n-- > 0;) {
    const auto symbol = std::to_integer<std::size_t>(symbols[n]);
    bits |= std::uint64_t{code.bits[symbol]} << count;
    count += code.length[symbol];
    if (count < 32) continue;
    put(out, bits, 4);
    bits >>= 32;
    count -= 32;
  }
  bits |= std::uint64_t{1} << count;
  put(out, bits, count / 8 + 1);
  return static_cast<std::size_t>(out - begin);
}

// At most, with all heads.
std::size_t compressed_bytes(const std::array<std::uint32_t, kSymbols>& counts, const Code& code,
                             std::size_t lengths) {
  std::size_t bits = 0;
  for (std::size_t n = 0; n < kSymbols; ++n) bits += std::size_t{counts[n]} * code.length[n];
  return bits / 8 + 4 + 4 + 6 + 1 + lengths;
}

// What a compressed block holds: literals, and no sequences.
void put_compressed(const Code& code, std::span<const std::byte> lengths, std::span<const std::byte> piece,
                    std::byte*& out) {
  const bool is_one = piece.size() <= kOneStream;
  std::byte* head = out;
  out += is_one ? 3 : 4;
  const std::byte* const begin = out;
  out = std::copy(lengths.begin(), lengths.end(), out);
  if (is_one) {
    put_stream(code, piece, out);
  } else {
    std::byte* jumps = out;
    out += 6;
    const std::size_t part = (piece.size() + 3) / 4;
    for (std::size_t n = 0; n < 4; ++n) {
      const std::size_t first = n * part;
      const std::size_t bytes =
          put_stream(code, piece.subspan(first, std::min(part, piece.size() - first)), out);
      if (n < 3) put(jumps, bytes, 2);
    }
  }
  const auto bytes = static_cast<std::uint64_t>(out - begin);
  if (is_one) {
    put(head, 2 | piece.size() << 4 | bytes << 14, 3);
  } else {
    put(head, 2 | 2 << 2 | piece.size() << 4 | bytes << 18, 4);
  }
  put(out, 0, 1);
}

}  // namespace

FrameWriter::FrameWriter(std::span<std::byte> out, std::size_t contents) : out_(out) {
  KARST_ASSERT(contents >= 256 && contents < 65'792);
  std::byte* at = out.data();
  put(at, 0xFD2FB528, 4);
  put(at, 0x60, 1);  // one segment, its length in two bytes
  put(at, contents - 256, 2);
  used_ = 7;
}

void FrameWriter::add(std::span<const std::byte> piece, bool last) {
  KARST_ASSERT(!piece.empty() && piece.size() <= kMostPiece && out_.size() - used_ >= piece.size() + 3);
  std::array<std::uint32_t, kSymbols> counts{};
  for (const std::byte symbol : piece) ++counts[std::to_integer<std::size_t>(symbol)];
  Code code;
  int symbols = 0;
  for (int n = 0; n < kSymbols; ++n) {
    if (counts[static_cast<std::size_t>(n)] == 0) continue;
    ++symbols;
    code.last = n;
  }
  BlockType type = symbols == 1 ? kSame : kRaw;
  std::byte* const head = out_.data() + used_;
  std::byte* at = head + 3;
  std::size_t stated = piece.size();
  if (symbols > 1) {
    find_lengths(counts, code);
    std::array<std::byte, kMostLengthsBytes> lengths;
    const std::size_t of_lengths = put_lengths(code, lengths);
    if (of_lengths != 0 && compressed_bytes(counts, code, of_lengths) < piece.size()) {
      type = kCompressed;
      find_bits(code);
      put_compressed(code, std::span(lengths).first(of_lengths), piece, at);
      stated = static_cast<std::size_t>(at - head) - 3;
    }
  }
  if (type == kSame) *at++ = piece[0];
  if (type == kRaw) {
    std::memcpy(at, piece.data(), piece.size());
    at += piece.size();
  }
  std::byte* of_block = head;
  put(of_block, (last ? 1u : 0u) | static_cast<std::uint32_t>(type) << 1 | stated << 3, 3);
  used_ += static_cast<std::size_t>(at - head);
}

}  // namespace karst::tiles
