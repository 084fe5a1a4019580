// SPDX-License-Identifier: MIT
#include "tiles/frame/huffman_lengths.h"

#include <algorithm>
#include <array>
#include <bit>

namespace karst::tiles {
namespace {

constexpr std::size_t kWeights = 12;
constexpr int kTableLog = 6;
constexpr int kTable = 1 << kTableLog;
constexpr std::size_t kMostDirect = 128;  // weights

// Bits from the lowest of a byte on; false where they are more than there is room for.
class Bits {
 public:
  explicit Bits(std::span<std::byte> out) : out_(out) {}

  void add(unsigned value, int count) {
    bits_ |= value << count_;
    for (count_ += count; count_ >= 8; count_ -= 8, bits_ >>= 8) push();
  }
  // What is left of a byte, with zeros. Returns all bytes; 0: too many.
  std::size_t finish() {
    if (count_ > 0) push();
    bits_ = 0;
    count_ = 0;
    return used_ <= out_.size() ? used_ : 0;
  }

 private:
  void push() {
    if (used_ < out_.size()) out_[used_] = static_cast<std::byte>(bits_);
    ++used_;
  }

  std::span<std::byte> out_;
  std::size_t used_ = 0;
  unsigned bits_ = 0;
  int count_ = 0;
};

// How many states of the table each weight gets: all that occur one at least.
std::array<int, kWeights> shares_of(std::span<const std::uint8_t> weights) {
  std::array<int, kWeights> counts{}, shares{};
  for (const std::uint8_t weight : weights) ++counts[weight];
  const int all = static_cast<int>(weights.size());
  int left = kTable;
  for (std::size_t n = 0; n < kWeights; ++n) {
    if (counts[n] != 0) shares[n] = std::max(1, (counts[n] * kTable + all / 2) / all);
    left -= shares[n];
  }
  // What rounding missed, the most frequent ones bear.
  while (left != 0) {
    *std::max_element(shares.begin(), shares.end()) += left > 0 ? 1 : -1;
    left += left > 0 ? -1 : 1;
  }
  return shares;
}

// RFC 8878, 4.1.1: a share and one, in as many bits as what is left allows; runs of zeros by twos of bits.
void put_shares(const std::array<int, kWeights>& shares, Bits& bits) {
  bits.add(kTableLog - 5, 4);
  int left = kTable;
  for (std::size_t n = 0; left > 0; ++n) {
    const int values = left + 2;  // 0 .. left + 1
    const int length = static_cast<int>(std::bit_width(static_cast<unsigned>(values - 1)));
    // The least values take a bit less, as many as there are codes to spare.
    const int spare = (1 << length) - values;
    const int value = shares[n] + 1;
    if (value < spare) {
      bits.add(static_cast<unsigned>(value), length - 1);
    } else {
      const int half = 1 << (length - 1);
      bits.add(static_cast<unsigned>(value < half ? value : value + spare), length);
    }
    left -= shares[n];
    if (shares[n] != 0) continue;
    std::size_t zeros = 0;
    while (shares[n + 1 + zeros] == 0) ++zeros;
    n += zeros;
    for (; zeros >= 3; zeros -= 3) bits.add(3, 2);
    bits.add(static_cast<unsigned>(zeros), 2);
  }
}

// The decoder's table, and which of a weight's states leads to a state.
struct States {
  std::array<std::uint8_t, kTable> bits, base;
  std::array<std::array<std::uint8_t, kTable>, kWeights> before;
  std::array<std::uint8_t, kWeights> first;  // state of a weight
};

void make_states(const std::array<int, kWeights>& shares, States& states) {
  std::array<std::uint8_t, kTable> weight_of;
  int at = 0;
  for (std::size_t n = 0; n < kWeights; ++n) {
    for (int share = 0; share < shares[n]; ++share) {
      weight_of[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(n);
      at = (at + (kTable >> 1) + (kTable >> 3) + 3) % kTable;
    }
  }
  std::array<int, kWeights> next = shares;
  for (std::size_t state = 0; state < kTable; ++state) {
    const std::size_t weight = weight_of[state];
    const int number = next[weight]++;
    if (number == shares[weight]) states.first[weight] = static_cast<std::uint8_t>(state);
    const int bits = kTableLog + 1 - static_cast<int>(std::bit_width(static_cast<unsigned>(number)));
    const int base = (number << bits) - kTable;
    states.bits[state] = static_cast<std::uint8_t>(bits);
    states.base[state] = static_cast<std::uint8_t>(base);
    for (int n = base; n < base + (1 << bits); ++n)
      states.before[weight][static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(state);
  }
}

// Two states in turns, read from the end. A weight's first state takes a bit at least, so that a reader
// notices where the bits end.
std::size_t put_by_states(std::span<const std::uint8_t> weights, std::span<std::byte> out) {
  if (weights.size() < 3 || std::equal(weights.begin() + 1, weights.end(), weights.begin())) return 0;
  const std::array<int, kWeights> shares = shares_of(weights);
  States states;
  make_states(shares, states);
  Bits bits(out.subspan(1));
  put_shares(shares, bits);
  bits.finish();
  std::array<std::size_t, 2> at{};
  for (std::size_t n = weights.size(); n-- > 0;) {
    std::size_t& state = at[n % 2];
    if (n + 2 >= weights.size()) {
      state = states.first[weights[n]];
      continue;
    }
    const std::size_t before = states.before[weights[n]][state];
    bits.add(static_cast<unsigned>(state) - states.base[before], states.bits[before]);
    state = before;
  }
  bits.add(static_cast<unsigned>(at[1]), kTableLog);
  bits.add(static_cast<unsigned>(at[0]), kTableLog);
  bits.add(1, 1);
  const std::size_t bytes = bits.finish();
  if (bytes == 0) return 0;
  out[0] = static_cast<std::byte>(bytes);
  return 1 + bytes;
}

}  // namespace

std::size_t put_weights(std::span<const std::uint8_t> weights, std::span<std::byte, kMostLengthsBytes> out) {
  const std::size_t bytes = put_by_states(weights, out);
  const std::size_t direct = 1 + (weights.size() + 1) / 2;
  if (weights.size() > kMostDirect || (bytes != 0 && bytes <= direct)) return bytes;
  out[0] = static_cast<std::byte>(127 + weights.size());
  for (std::size_t n = 0; n < weights.size(); n += 2) {
    const int other = n + 1 < weights.size() ? weights[n + 1] : 0;
    out[1 + n / 2] = static_cast<std::byte>(weights[n] << 4 | other);
  }
  return direct;
}

}  // namespace karst::tiles
