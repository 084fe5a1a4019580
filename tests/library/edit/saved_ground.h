// SPDX-License-Identifier: MIT
// A ground that is edited, saved and loaded again, through the public headers, and all its tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/library/ground_file.h"
#include "tests/library/host.h"

#include "karst/edit.h"
#include "scene/world/world_object.h"

namespace karst::test {

// All tiles that hang from a root, as reading them gives them, and what their places take.
struct FileGround {
  explicit FileGround(std::vector<std::byte> file);
  // Where all tiles are whole.
  void for_each(const std::function<void(core::NodeKey, const core::TilePlace&, const core::Tile&)>& visit);

  std::vector<std::byte> bytes;
  core::WorldReader reader;
};

// Whether the file has the tiles that are live: heights and measures, to the bit. original: what the world
// was loaded from.
void expect_live_tiles(const core::WorldObject& world, const std::vector<std::byte>& saved,
                       const std::vector<std::byte>& original);

class EditedWorldFile {
 public:
  explicit EditedWorldFile(std::vector<std::byte> file, std::uint32_t tiles = 400);
  ~EditedWorldFile();
  EditedWorldFile(const EditedWorldFile&) = delete;
  EditedWorldFile& operator=(const EditedWorldFile&) = delete;

  EditResult apply(const karst::Edit& edit);
  std::vector<std::byte> save();
  core::WorldObject& object() { return static_cast<core::WorldObject&>(*host.world); }
  void expect_live_tiles(const std::vector<std::byte>& saved, const std::vector<std::byte>& original) {
    test::expect_live_tiles(object(), saved, original);
  }

  HostWorld host;
  Editor* editor = nullptr;
};

// Brushes of all tools, up to so many metres wide, over a ground of so many.
karst::Edit random_ground_edit(std::mt19937& random, const karst::World& world, double wide_m, double deep_m);

}  // namespace karst::test
