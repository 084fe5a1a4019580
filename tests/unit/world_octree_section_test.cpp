// SPDX-License-Identifier: MIT
#include "terrain/file/octree_section.h"

#include "tests/support/tree_memory.h"

#include <gtest/gtest.h>

#include <vector>

namespace karst::core {
namespace {

constexpr unsigned kEmpty = 0;
constexpr unsigned kFilled = 1;
constexpr unsigned kInternal = 2;

// Nodes in pre-order, two bits each; a heap block of exactly their length, so that sanitizers see an
// overread.
std::vector<std::byte> pack(const std::vector<unsigned>& nodes) {
  std::vector<std::byte> bytes((nodes.size() + 3) / 4);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    bytes[i / 4] |= static_cast<std::byte>(nodes[i] << (i % 4 * 2));
  return bytes;
}

TEST(OctreeSection, NodesAreInPreOrder) {
  TreeMemory memory(2);
  // Octant 1 of the root is internal; in it octants 0 and 6 are filled; octant 7 of the root is filled.
  const std::vector<unsigned> nodes = {kInternal, kEmpty, kInternal, kFilled, kEmpty, kEmpty,
                                       kEmpty,    kEmpty, kEmpty,    kFilled, kEmpty, kEmpty,
                                       kEmpty,    kEmpty, kEmpty,    kEmpty,  kFilled};
  const std::vector<std::byte> bytes = pack(nodes);
  ASSERT_EQ(bytes.size(), octree_section_bytes(2));
  ASSERT_TRUE(decode_octree(bytes, 2, glm::ivec3(4), memory.tree).ok());
  EXPECT_EQ(memory.tree.count_filled(), 2u + 8u);
  EXPECT_TRUE(memory.tree.filled({2, 0, 0}));
  EXPECT_TRUE(memory.tree.filled({2, 1, 1}));
  EXPECT_TRUE(memory.tree.filled({3, 2, 2}));
  std::vector<std::byte> again;
  const auto append = [&](std::span<const std::byte> piece) {
    again.insert(again.end(), piece.begin(), piece.end());
    return true;
  };
  ASSERT_TRUE(encode_octree(memory.tree, 2, glm::ivec3(4), ByteSink::to(append)).ok());
  EXPECT_EQ(again, bytes);
}

TEST(OctreeSection, AWalkPastTheLastNodeIsStopped) {
  TreeMemory memory(9);
  // Every node claims eight children: the nodes run out long before the depth does, or the other way round.
  for (const std::uint32_t octets : {0u, 1u, 2u, 8u, 9u, 100u}) {
    const std::vector<std::byte> bytes = pack(std::vector<unsigned>(1 + 8 * octets, kInternal));
    const Status status = decode_octree(bytes, octets, glm::ivec3(512, 511, 512), memory.tree);
    EXPECT_EQ(status.code(), StatusCode::corrupt);
    EXPECT_STREQ(status.what(), octets < 2 ? "the octree has more nodes than its octets hold"
                                           : "the octree is deeper than its depth");
    EXPECT_LT(status.value(), bytes.size());
    EXPECT_EQ(memory.tree.octets_used(), 0u);
  }
  // One octet promised, two used.
  std::vector<unsigned> nodes(9, kEmpty);
  nodes[0] = kInternal;
  nodes[8] = kInternal;
  EXPECT_STREQ(decode_octree(pack(nodes), 1, glm::ivec3(512, 511, 512), memory.tree).what(),
               "the octree has more nodes than its octets hold");
}

TEST(OctreeSection, LengthsMustFit) {
  TreeMemory memory(2, 1);
  const std::vector<std::byte> bytes(5);
  EXPECT_EQ(decode_octree(bytes, 1, glm::ivec3(4), memory.tree).code(), StatusCode::corrupt);
  EXPECT_EQ(decode_octree({}, 0, glm::ivec3(4), memory.tree).code(), StatusCode::corrupt);
  EXPECT_EQ(decode_octree(bytes, 2, glm::ivec3(4), memory.tree).code(), StatusCode::limit_reached);
}

}  // namespace
}  // namespace karst::core
