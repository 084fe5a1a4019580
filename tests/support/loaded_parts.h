// SPDX-License-Identifier: MIT
// World, residency, casters and views of a made-up world with memory of their own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "terrain/world/terrain_parts.h"
#include "tests/support/test_world.h"

namespace karst::test {
using namespace core;

class LoadedParts : public TerrainParts {
 public:
  explicit LoadedParts(const Config& config);
  // The least that holds a world, with so many pages for detail; loads it.
  explicit LoadedParts(const TestWorld& shape, std::uint32_t detail_pages = World::kDetailPages,
                       std::uint32_t max_views = 1);

  ViewState& view() { return views[0]; }
  // One view alone.
  Status select(const ViewRequest& request) { return residency.select(views_of(1), std::span(&request, 1)); }
  // Makes what the last select() lacked, or so many patches of it; how many that were.
  int generate(bool ahead = false, int most = 1 << 30);

 private:
  AlignedBytes memory_;
  std::vector<std::byte> file_;
};

}  // namespace karst::test
