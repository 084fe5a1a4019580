// SPDX-License-Identifier: MIT
// A small world in a file, opened as karst view --edit opens one, without OpenGL.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/editor/edit_session.h"
#include "app/files/file_source.h"
#include "karst/karst.h"
#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::app {

// 40 x 24 x 36 voxels of 1 m, hills some 10 voxels high with a cave through them.
inline std::span<const std::byte> hand_world_file() {
  static const std::vector<std::byte> kFile = [] {
    test::TestWorld world({40, 24, 36}, [](glm::ivec3 v) {
      const glm::dvec3 p(v);
      const double ground = 10 + 4 * test::value_noise(5, glm::dvec3(p.x, 0, p.z) / 11.0);
      const bool cave = std::hypot(p.y - 6.5, p.z - 18.0) < 3.2;
      return p.y + 0.5 < ground && !cave;
    });
    world.roughen(2, 3, 300);
    return world.file();
  }();
  return kFile;
}

class HandWorld {
 public:
  // digs: its ground, where it can be dug.
  explicit HandWorld(const std::string& path, std::uint32_t edit_patches = 4096, bool digs = false) {
    EXPECT_EQ(file_.open(path).text(), "");
    source_ = file_.source();
    plan_.placement.axes = Axes::east_up_south;
    plan_.needs.shadow_maps = 0;
    plan_.needs.queries = 1;
    plan_.needs.edit_patches = edit_patches;
    plan_.needs.field_sample_blocks = 64;
    plan_.needs.undo_bytes = 4 << 20;
    plan_.needs.dig_regions = digs ? 2 : 0;
    plan_.needs.edit_tiles = digs ? 400 : 0;
    Status status = make_plan(source_, plan_);
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
    memory_.reset(std::aligned_alloc(kMemoryAlignment, (plan_.cpu_bytes + 63) / 64 * 64));
    status = World::create(plan_, source_, {static_cast<std::byte*>(memory_.get()), plan_.cpu_bytes}, world);
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
    EXPECT_TRUE(world->take_query(query).ok());
  }
  HandWorld(const HandWorld&) = delete;
  HandWorld& operator=(const HandWorld&) = delete;
  ~HandWorld() {
    world->release(query);
    world->destroy();
  }

  World* world = nullptr;
  Query* query = nullptr;

 private:
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  FileSource file_;
  Source source_;
  Plan plan_;
  std::unique_ptr<void, Free> memory_;
};

// A sphere that digs, or fills.
inline Edit ball(double x, double y, double z, double radius_m = 3, EditTool tool = EditTool::clear) {
  Edit edit;
  edit.tool = tool;
  edit.place = edit.to = {x, y, z};
  edit.radius_m = radius_m;
  return edit;
}

}  // namespace karst::app
