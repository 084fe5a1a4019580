// SPDX-License-Identifier: MIT
#include "terrain/base/checksum.h"

#include "tests/support/tree_memory.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string_view>
#include <vector>

namespace karst::core {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

// The definition, bit by bit.
std::uint32_t slow_crc32c(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const std::byte b : bytes) {
    crc ^= std::to_integer<std::uint32_t>(b);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1u) * 0x82F63B78u;
  }
  return ~crc;
}

// RFC 3720, appendix B.4, and the usual check value.
TEST(Checksum, KnownVectors) {
  EXPECT_EQ(crc32c({}), 0u);
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283u);
  std::vector<std::byte> bytes(32);
  EXPECT_EQ(crc32c(bytes), 0x8A9136AAu);
  for (std::byte& b : bytes) b = std::byte{0xff};
  EXPECT_EQ(crc32c(bytes), 0x62A8AB43u);
  for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<std::byte>(i);
  EXPECT_EQ(crc32c(bytes), 0x46DD794Eu);
  for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<std::byte>(31 - i);
  EXPECT_EQ(crc32c(bytes), 0x113FDB5Cu);
}

TEST(Checksum, AllLengthsAlignmentsAndCutsEqualTheDefinition) {
  TestRandom random(7);
  std::vector<std::byte> bytes(96);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random.below(256));
  for (std::size_t first = 0; first < 9; ++first) {
    for (std::size_t length = 0; length + first <= bytes.size(); ++length) {
      const std::span<const std::byte> part = std::span(bytes).subspan(first, length);
      const std::uint32_t crc = slow_crc32c(part);
      ASSERT_EQ(crc32c(part), crc) << first << " " << length;
      const std::size_t cut = random.below(static_cast<std::uint32_t>(length + 1));
      ASSERT_EQ(crc32c(part.subspan(cut), crc32c(part.first(cut))), crc);
    }
  }
}

}  // namespace
}  // namespace karst::core
