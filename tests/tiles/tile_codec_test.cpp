// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "terrain/base/checksum.h"
#include "terrain/lod/morph.h"
#include "tiles/decode_tile.h"
#include "tiles/encode_tile.h"
#include "tiles/tile_bytes.h"
#include "tiles/write_tile.h"

namespace karst {
namespace {

using namespace core;
using namespace tiles;

struct Case {
  GroundInfo info;
  NodeKey key;
  Tile tile{};
};

// Any heights, measures and children that the format can hold.
Case any_case(std::mt19937& random, int size, double quantum) {
  Case made;
  made.info.samples[0] = 300;
  made.info.samples[1] = 270;
  made.info.steps[0] = made.info.steps[1] = 2048;
  made.key = {size, 1 >> size, 1 >> size};
  std::uniform_int_distribution<std::int32_t> step(-40, 40);
  std::int32_t count = 1000;
  made.info.low = INT32_MAX;
  made.info.high = INT32_MIN;
  for (std::int32_t& height : made.tile.heights) {
    count += step(random);
    height = static_cast<std::int32_t>(height_of(count, quantum));
    made.info.low = std::min(made.info.low, height);
    made.info.high = std::max(made.info.high, height);
  }
  for (int n = 0; n < kTileMeasures; ++n) {
    if (!node_exists(made.info, node_of_tile(made.key, n))) continue;
    const Range own = range_of_node(made.tile.heights, n);
    NodeMeasure& measure = made.tile.nodes[n];
    measure.low = own.low;
    measure.high = own.high;
    if (size == 0) continue;
    measure.low = made.info.low;
    if (n % 3 != 0) measure.high = made.info.high;
    std::uint32_t threshold = kLeastThreshold + static_cast<std::uint32_t>(random() % 5000);
    for (std::uint16_t& at_demand : measure.thresholds) {
      at_demand = static_cast<std::uint16_t>(threshold);
      threshold += static_cast<std::uint32_t>(random() % 2000);
    }
  }
  for (int quadrant = 0; quadrant < 4 && size > 0; ++quadrant) {
    if (tile_exists(made.info, made.key.child(quadrant)))
      made.tile.children[quadrant] = {100u * static_cast<unsigned>(quadrant), 100,
                                      static_cast<std::uint32_t>(random())};
  }
  return made;
}

struct Decoded {
  Status status;
  Tile tile{};
};
Decoded decode(const Case& of, std::vector<std::byte> bytes, bool right_crc = true) {
  std::vector<std::byte> room(decode_tile_room());
  const TilePlace place{1'000, static_cast<std::uint32_t>(bytes.size()),
                        crc32c(bytes) + (right_crc ? 0u : 1u)};
  Decoded decoded;
  decoded.status = decode_tile(of.info, of.key, place, bytes, room, decoded.tile);
  return decoded;
}

TEST(TileCodec, WhatIsDecodedIsWhatWasEncoded) {
  std::mt19937 random(1);
  TileEncoder encoder;
  for (const double quantum : {1.0, 34.133333, 3.7, 200.0}) {
    for (const int size : {0, 1, 2, 5}) {
      const Case made = any_case(random, size, quantum);
      std::vector<std::byte> bytes;
      std::vector<std::byte> plain;
      encoder.run(made.key, made.info, made.tile, quantum, bytes);
      encoder.run(made.key, made.info, made.tile, 0, plain);
      EXPECT_LE(bytes.size(), plain.size() + 8);
      std::vector<std::uint64_t> room(kWriteTileRoom / 8);
      const auto part = write_tile(made.key, made.info, made.tile, made.tile.children,
                                   std::as_writable_bytes(std::span(room)));
      const std::vector<std::byte> written(part.begin(), part.end());
      // Repeats, which there are here, are not looked for.
      EXPECT_LE(written.size(), plain.size() + plain.size() / 3);
      for (const auto& encoded : {bytes, plain, written}) {
        const Decoded decoded = decode(made, encoded);
        ASSERT_TRUE(decoded.status.ok()) << decoded.status.what() << ", size " << size;
        EXPECT_EQ(std::memcmp(&decoded.tile, &made.tile, sizeof(Tile)), 0) << "size " << size;
      }
    }
  }
}

// Heights that are no counts of the quantum are kept as they are.
TEST(TileCodec, AQuantumThatDoesNotHoldIsLeftOut) {
  std::mt19937 random(2);
  Case made = any_case(random, 1, 34.133333);
  made.tile.heights[4000] += 1;
  std::vector<std::byte> bytes;
  TileEncoder().run(made.key, made.info, made.tile, 34.133333, bytes);
  const Decoded decoded = decode(made, bytes);
  ASSERT_TRUE(decoded.status.ok()) << decoded.status.what();
  EXPECT_EQ(std::memcmp(&decoded.tile, &made.tile, sizeof(Tile)), 0);
}

TEST(TileCodec, RangesAreChecked) {
  struct Spoil {
    const char* what;
    void (*spoil)(Case&);
  };
  const Spoil spoils[] = {
      {"a height is outside of the ground's", [](Case& c) { c.info.high -= 1; }},
      {"a height is outside of the ground's", [](Case& c) { c.info.low += 1; }},
      {"a threshold is out of range", [](Case& c) { c.tile.nodes[0].thresholds[0] = kLeastThreshold - 1; }},
      {"a threshold is out of range", [](Case& c) { c.tile.nodes[0].thresholds[11] = kNeverMorphs + 1; }},
      {"a threshold is out of range", [](Case& c) { c.tile.nodes[0].thresholds[5] = 0; }},
      {"a node's heights are outside of the ground's", [](Case& c) { c.tile.nodes[0].low -= 100; }},
      {"a child is missing", [](Case& c) { c.tile.children[0] = {}; }},
      {"a child does not end before its parent", [](Case& c) { c.tile.children[1].offset = 901; }},
      {"a child does not end before its parent", [](Case& c) { c.tile.children[1].offset = ~0ull; }},
      {"a child is too long", [](Case& c) { c.tile.children[2].bytes = kMostTileBytes + 1; }},
  };
  for (const Spoil& spoil : spoils) {
    std::mt19937 random(3);
    Case made = any_case(random, 1, 1);
    spoil.spoil(made);
    std::vector<std::byte> bytes;
    TileEncoder().run(made.key, made.info, made.tile, 1, bytes);
    const Decoded decoded = decode(made, bytes);
    EXPECT_EQ(decoded.status.code(), StatusCode::corrupt);
    EXPECT_STREQ(decoded.status.what(), spoil.what);
    EXPECT_EQ(decoded.status.value(), 1'000u);
  }
  std::mt19937 random(4);
  Case leaf = any_case(random, 0, 1);
  leaf.tile.children[0] = {0, 100, 0};
  std::vector<std::byte> bytes;
  TileEncoder().run(leaf.key, leaf.info, leaf.tile, 1, bytes);
  EXPECT_STREQ(decode(leaf, bytes).status.what(), "a child lies outside of the ground");
}

TEST(TileCodec, DamageIsCorrupt) {
  std::mt19937 random(5);
  const Case made = any_case(random, 1, 3.7);
  std::vector<std::byte> bytes;
  TileEncoder().run(made.key, made.info, made.tile, 3.7, bytes);
  EXPECT_STREQ(decode(made, bytes, false).status.what(), "a tile does not match its checksum");
  for (int n = 0; n < 2'000; ++n) {
    std::vector<std::byte> damaged = bytes;
    if (n % 4 == 0) damaged.resize(random() % damaged.size());
    for (int k = 0; k < n % 3 + 1 && !damaged.empty(); ++k)
      damaged[random() % damaged.size()] ^= static_cast<std::byte>(1 + random() % 255);
    const Decoded decoded = decode(made, damaged);
    if (!decoded.status.ok()) {
      EXPECT_EQ(decoded.status.code(), StatusCode::corrupt);
      continue;
    }
    for (const std::int32_t height : decoded.tile.heights)
      ASSERT_TRUE(height >= made.info.low && height <= made.info.high);
    for (const TilePlace& child : decoded.tile.children)
      ASSERT_TRUE(child.offset + child.bytes <= 1'000 && child.bytes <= 1'000);
  }
}

}  // namespace
}  // namespace karst
