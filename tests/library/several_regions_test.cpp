// SPDX-License-Identifier: MIT
// Worlds of a ground with several regions: two that lie a node apart and one far from them and higher, each
// with a cave. Whatever is missing there is no hole, queries meet all, and each looks as it does alone.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "karst/edit.h"
#include "terrain/file/world_reader.h"
#include "tests/library/ground_file.h"
#include "tests/library/region_frames.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kSamples[2] = {401, 301};

// Voxels are a metre, nodes of size 0 two.
struct Cave {
  int first[2];        // node
  glm::ivec3 extent;   // voxels
  int height;          // of its corner
  glm::dvec3 chamber;  // from its corner
  double radius;
  double shaft;  // from the chamber along x, up into the open
};
constexpr int kCaves = 3;
const Cave kCave[kCaves] = {{{12, 9}, {41, 24, 37}, 0, {20, 6, 18}, 4.5, 3},
                            {{33, 9}, {21, 24, 21}, 0, {9, 6, 10}, 3, 2},
                            {{60, 44}, {25, 18, 23}, 4, {12, 6, 11}, 3.5, 2.5}};

glm::dvec3 corner_of(int n) {
  return {2 * (kCave[n].first[0] - kCave[0].first[0]), kCave[n].height,
          2 * (kCave[n].first[1] - kCave[0].first[1])};
}

double ground_height(double x, double z) {
  return 15 + 3 * test::value_noise(5, glm::dvec3(x, 0, z) / 9.0);
}

std::unique_ptr<test::TestWorld> voxels_of(int n) {
  const Cave cave = kCave[n];
  const glm::dvec3 corner = corner_of(n);
  auto world = std::make_unique<test::TestWorld>(
      cave.extent,
      [=](glm::ivec3 v) {
        const glm::dvec3 local = glm::dvec3(v) + 0.5;
        const glm::dvec3 from = local - cave.chamber;
        const bool hollow =
            glm::length(from) < cave.radius || (std::hypot(from.x - cave.shaft, from.z) < 1.8 && from.y > 0);
        return !hollow && local.y + corner.y < ground_height(local.x + corner.x, local.z + corner.z);
      },
      true);
  world->set_heights(3, [](glm::dvec3) { return 0.0; });
  return world;
}

// Of the caves first .. end - 1, the ground's heights as they are with all.
std::vector<std::byte> file_of(int first, int end) {
  std::vector<std::unique_ptr<test::TestWorld>> worlds;
  std::vector<const test::TestWorld*> regions;
  std::vector<test::MemoryRegion> places;
  const glm::dvec3 origin = end - first == 1 ? corner_of(first) : glm::dvec3(0);
  for (int n = first; n < end; ++n) {
    const Cave& cave = kCave[n];
    worlds.push_back(voxels_of(n));
    regions.push_back(worlds.back().get());
    const double reach = core::kStepsPerVoxel * glm::length(glm::dvec3(cave.extent));
    places.push_back({cave.extent.x,
                      cave.extent.z,
                      cave.first[0],
                      cave.first[1],
                      {16.0 * core::kStepsPerVoxel, reach},
                      cave.extent.y,
                      cave.height - static_cast<int>(origin.y)});
  }
  const test::MemoryGround ground(
      kSamples[0], kSamples[1], 4096, 4096,
      [=](std::int64_t i, std::int64_t k) {
        const double x = 0.5 + 0.5 * double(i) - 2 * kCave[0].first[0];
        const double z = 0.5 + 0.5 * double(k) - 2 * kCave[0].first[1];
        return static_cast<std::int32_t>((ground_height(x, z) - origin.y) * core::kStepsPerVoxel /
                                         core::kVertexStep);
      },
      places);
  return test::ground_file(ground, regions);
}

Vec3 vec(glm::dvec3 v) {
  return {v.x, v.y, v.z};
}

class SeveralRegions : public test::RegionHostTest {
 protected:
  static const std::vector<std::byte>& file() {
    static const std::vector<std::byte> bytes = file_of(0, kCaves);
    return bytes;
  }
};

TEST_F(SeveralRegions, TheWorldSaysWhereTheyAreAndTakesThePlannedBytes) {
  open({}, {}, {}, file());
  const WorldInfo& info = host_->world->info();
  ASSERT_EQ(info.regions, 3u);
  for (int n = 0; n < kCaves; ++n) {
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_EQ(info.region_first[n][axis], kCave[n].first[axis]);
      EXPECT_EQ(info.region_nodes[n][axis], (kCave[n].extent[2 * axis] - 1) / 2);
    }
  }
  const DeviceInfo device = device_info(*renderer_);
  EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
  EXPECT_EQ(device.gpu_bytes, host_->plan.gpu_bytes);
}

TEST_F(SeveralRegions, QueriesMeetEachCaveAndTheGroundBetween) {
  Needs needs;
  needs.queries = 1;
  open(needs, {}, {}, file());
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_query(query).ok());
  const auto place = [&](glm::dvec3 p) { return host_->world->from_world(vec(p)); };
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 chamber = corner_of(n) + kCave[n].chamber;
    Hit hits[8];
    // Beside the shaft: the ground, the ceiling and the floor. Through it: the floor alone.
    const glm::dvec3 beside = chamber - glm::dvec3(1, 0, 0);
    ASSERT_EQ(query->column(place(beside), Wait::for_file, hits), 3u) << n;
    EXPECT_NEAR(host_->world->to_world(hits[0].place).y, ground_height(beside.x, beside.z), 1) << n;
    EXPECT_NEAR(host_->world->to_world(hits[2].place).y, chamber.y - kCave[n].radius, 1.2) << n;
    const glm::dvec3 shaft = chamber + glm::dvec3(kCave[n].shaft, 0, 0);
    EXPECT_EQ(query->column(place(shaft), Wait::for_file, hits), 1u) << n;
    EXPECT_LT(host_->world->to_world(hits[0].place).y, chamber.y) << n;
    // Who walks there stands on the chamber's floor.
    Hit stands;
    ASSERT_TRUE(query->ground(place(chamber), 0.5, Wait::for_file, stands)) << n;
    EXPECT_NEAR(host_->world->to_world(stands.place).y, chamber.y - kCave[n].radius, 1.2) << n;
    Hit met;
    ASSERT_TRUE(query->ray(place(chamber), place(chamber - glm::dvec3(30, 0, 0)), Wait::for_file, met)) << n;
    EXPECT_NEAR(met.distance, kCave[n].radius, 1.2) << n;
    EXPECT_TRUE(query->inside(place(chamber - glm::dvec3(0, kCave[n].radius + 2, 0)), Wait::for_file)) << n;
    EXPECT_FALSE(query->inside(place(chamber), Wait::for_file)) << n;
    Voxel voxel;
    ASSERT_TRUE(query->pick(place(chamber), place(chamber - glm::dvec3(0, 9, 0)), 6, voxel)) << n;
    EXPECT_NEAR(host_->world->to_world(voxel.centre).x, chamber.x, 1) << n;
  }
  // Between the two that lie a node apart, and far from all: one surface.
  for (const auto& [x, z] : {std::pair(41.5, 12.0), std::pair(41.5, 30.0), std::pair(80.0, 60.0)}) {
    Hit hits[8];
    ASSERT_EQ(query->column(place({x, 0, z}), Wait::for_file, hits), 1u) << x << ' ' << z;
    EXPECT_NEAR(host_->world->to_world(hits[0].place).y, ground_height(x, z), 1) << x << ' ' << z;
  }
  host_->world->release(query);
}

// The sites as frames are taken of them.
std::vector<test::RegionSite> sites() {
  std::vector<test::RegionSite> all;
  for (int n = 0; n < kCaves; ++n)
    all.push_back({corner_of(n), glm::dvec3(kCave[n].extent), corner_of(n) + kCave[n].chamber});
  return all;
}

TEST_F(SeveralRegions, NoPixelLooksThroughWhateverIsMissing) {
  const std::vector<test::RegionSite> all = sites();
  test::RegionScene scene = {all, ground_height, 12, 19};
  for (int axis = 0; axis < 2; ++axis) {
    scene.low[axis] = 1 - 2 * kCave[0].first[axis];
    scene.high[axis] = 0.5 * kSamples[axis] - 1 - 2 * kCave[0].first[axis];
  }
  // With the least, a page for each patch, the last two of 8 frames have none in detail.
  look_for_holes(file(), scene, std::array<std::uint64_t, 3>{0, std::uint64_t{7} << 19, 1}, 17, 240);
}

// What an eye above it has not seen is there when the eye is in the cave, whatever time a frame has and
// without shadows, for which it would be made.
TEST_F(SeveralRegions, ACaveIsWholeWhenItIsFirstSeen) {
  Needs needs;
  needs.shadow_maps = 0;
  open(needs, {}, {}, file());
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 chamber = corner_of(n) + kCave[n].chamber;
    FrameResult result;
    // All tiles of the ground around are there then.
    holes(view(chamber + glm::dvec3(-3, 60, 1), chamber), 0, result);
    EXPECT_TRUE(result.complete);
    for (const glm::dvec3 way : {glm::dvec3(-4, -1, 1), glm::dvec3(1, -4, 2)})
      EXPECT_EQ(holes(view(chamber, chamber + way), 1e-3, result), 0u) << n;
  }
}

// A fold of less than a subpixel between two vertices that all but met: its neighbours do not cover the pixel
// below it, by rounded corners it faces the eye, and by those before that it does not.
TEST_F(SeveralRegions, AFoldOfLessThanASubpixelIsNoHole) {
  open({}, {}, {}, file());
  ViewState shown = view({41.365786745870736, 17.947136925979478, 5.2486984992829671},
                         {41.666011397677053, 15.947136925979478, 5.8954278249989081});
  shown.error_px = 16.4472766;
  FrameResult result;
  EXPECT_EQ(holes(shown, 0, result), 0u);
  EXPECT_TRUE(result.complete);
}

// In each cave, and from above, a world with all three shows what one with that region alone does: light from
// the sky to the bit; shadows but for the grid of their texels, which counts from the world's corner.
TEST_F(SeveralRegions, EachLooksAsItDoesAlone) {
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 chamber = corner_of(n) + kCave[n].chamber;
    const auto picture = [&](const std::vector<std::byte>& bytes, glm::dvec3 origin, bool above,
                             bool shadows) {
      Needs needs;
      needs.shadow_maps = shadows ? 1 : 0;
      needs.shadow_size = 2048;
      needs.shadow_reach_m = 40;
      open(needs, {}, {}, bytes);
      const glm::dvec3 eye = chamber - origin + (above ? glm::dvec3(4, 24, 0) : glm::dvec3(-1.2, -0.5, 0.3));
      ViewState shown = view(eye, chamber - origin + glm::dvec3(kCave[n].shaft, -3, 0));
      shown.error_px = 0.5;
      FrameInput input;
      input.views = {&shown, 1};
      input.work_ms = 0;
      input.sun.towards = {0.4, 0.8, 0.2};
      input.sun.visibility_m = 1e5;
      FrameResult result;
      EXPECT_TRUE(renderer_->begin_frame(input, result).ok());
      EXPECT_TRUE(result.complete);
      picture_.clear();
      Target target;
      target.viewport = {0, 0, kWidth, kHeight};
      target.framebuffer = picture_.name();
      picture_.bind();
      EXPECT_TRUE(renderer_->draw(0, target).ok());
      EXPECT_TRUE(renderer_->end_frame().ok());
      close();
      return picture_.read();
    };
    const std::vector<std::byte> own = file_of(n, n + 1);
    for (const bool above : {false, true}) {
      for (const bool shadows : {false, true}) {
        const Pixels all = picture(file(), glm::dvec3(0), above, shadows);
        const Pixels alone = picture(own, corner_of(n), above, shadows);
        const double share = test::share_beyond(all, alone, shadows ? 3 : 0);
        EXPECT_LE(share, shadows ? 0.05 : 0.0) << n << ' ' << above << ' ' << shadows;
      }
    }
  }
}

// Regions are drawn or not, each by itself: from near one the other that is far is the ground's.
TEST_F(SeveralRegions, EachIsDrawnByItself) {
  open({}, {}, {}, file());
  const auto patches = [&](glm::dvec3 eye, glm::dvec3 target, double fov) {
    ViewState shown = view(eye, target, fov);
    set_perspective(shown, fov, 0.1, 1e5);
    const FrameResult result = test::draw_frame(*renderer_, picture_, {shown}, 0);
    EXPECT_TRUE(result.complete);
    EXPECT_LE(result.error_px[0], shown.error_px);
    return costs(*renderer_).patches_drawn;
  };
  const glm::dvec3 last = corner_of(2) + kCave[2].chamber;
  const std::uint32_t near_last = patches(last + glm::dvec3(0, 40, 30), last, 40);
  const std::uint32_t near_first = patches({20, 40, 50}, {20, 10, 18}, 40);
  const std::uint32_t all = patches({60, 160, 60}, {60.1, 0, 60}, 80);
  const std::uint32_t none = patches({60, 20000, 60}, {60.1, 0, 60}, 60);
  std::printf("%u patches from the third, %u from the first, %u from above, %u from far\n", near_last,
              near_first, all, none);
  EXPECT_GT(near_last, 0u);
  EXPECT_GT(near_first, near_last);
  EXPECT_GT(all, near_first);
  EXPECT_EQ(none, 0u);
}

// Digging in all of them while frames are drawn, whatever time those have: from above no pixel looks through.
TEST_F(SeveralRegions, NoPixelLooksThroughWhileTheyAreEdited) {
  const std::vector<test::RegionSite> all = sites();
  test::RegionScene scene = {all, ground_height, 12, 19};
  for (int axis = 0; axis < 2; ++axis) {
    scene.low[axis] = 1 - 2 * kCave[0].first[axis];
    scene.high[axis] = 0.5 * kSamples[axis] - 1 - 2 * kCave[0].first[axis];
  }
  std::mt19937 random(23);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  for (const std::uint64_t bytes : {std::uint64_t{0}, std::uint64_t{1}}) {
    Needs needs;
    needs.vertex_bytes = bytes;
    needs.edit_patches = 4'000;
    needs.edit_tiles = 200;
    open(needs, {}, {}, file());
    Editor* editor = nullptr;
    ASSERT_TRUE(host_->world->take_editor(editor).ok());
    int changed = 0, with_patches = 0;
    for (int frame = 0; frame < 60; ++frame) {
      const auto n = static_cast<std::size_t>(random() % kCaves);
      Edit edit;
      edit.radius_m = between(0.8, 4);
      const glm::dvec3 at = all[n].corner + glm::dvec3(between(0, 1), 0, between(0, 1)) * all[n].size;
      // What is filled lies below the ground, so that no eye above is in it.
      edit.tool = random() % 3 == 0 ? EditTool::fill : EditTool::clear;
      const double top = ground_height(at.x, at.z) - (edit.tool == EditTool::fill ? 3 + edit.radius_m : 0);
      edit.place = host_->world->from_world(vec({at.x, top - between(0, 5), at.z}));
      EditResult result;
      const Status status = editor->apply(edit, result);
      if (!status.ok()) {
        EXPECT_STREQ(status.field(), "place") << status.what() << ' ' << status.value();
      }
      changed += result.changed ? 1 : 0;
      const test::Look look = random_look(scene, 1 + frame % 2, random);
      ViewState shown = view(look.eye, look.target, look.fov);
      shown.error_px = std::exp2(between(-1, 5));
      FrameResult drawn;
      ASSERT_EQ(holes(shown, frame % 3 == 0 ? 0 : 0.01, drawn), 0u)
          << frame << ' ' << bytes << ": " << look.eye.x << ' ' << look.eye.y << ' ' << look.eye.z << " to "
          << look.target.x << ' ' << look.target.y << ' ' << look.target.z << " error " << shown.error_px;
      with_patches += costs(*renderer_).patches_drawn > 0 ? 1 : 0;
    }
    EXPECT_GT(changed, 30);
    EXPECT_GT(with_patches, 30);
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    host_->world->release(editor);
    close();
  }
}

// A pit is there at once, for queries too, and the region stays drawn where a frame has no time.
TEST_F(SeveralRegions, APitIsDrawnAndAskedAtOnce) {
  Needs needs;
  needs.edit_patches = 4'000;
  needs.edit_tiles = 100;
  needs.queries = 1;
  open(needs, {}, {}, file());
  EXPECT_EQ(device_info(*renderer_).cpu_bytes, host_->plan.cpu_bytes);
  Editor* editor = nullptr;
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  const std::vector<std::byte> untouched = test::saved_by(*editor);
  ASSERT_TRUE(host_->world->take_query(query).ok());
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 corner = corner_of(n);
    const double x = corner.x + 6, z = corner.z + 6;
    ViewState shown = view({x + 4, 30, z + 3}, {x, 12, z});
    FrameResult result;
    holes(shown, 0, result);
    const Pixels before = picture_.read();
    Hit hit;
    ASSERT_TRUE(query->ground(host_->world->from_world({x, 60, z}), 0, Wait::for_file, hit));
    const double ground = host_->world->to_world(hit.place).y;
    Edit dig;
    dig.place = hit.place;
    dig.radius_m = 2.5;
    EditResult made;
    ASSERT_TRUE(editor->apply(dig, made).ok());
    EXPECT_TRUE(made.changed);
    EXPECT_GT(made.patches, 0u);
    const Vec3 low = host_->world->to_world(made.low), high = host_->world->to_world(made.high);
    EXPECT_LT(low.x, x - 2);
    EXPECT_GT(high.x, x + 2);
    EXPECT_LT(high.x, x + 9);
    EXPECT_LT(low.y, ground - 1.5);
    EXPECT_EQ(holes(shown, 1e-6, result), 0u);
    EXPECT_GT(costs(*renderer_).patches_drawn, 0u);
    EXPECT_GT(test::share_beyond(before, picture_.read(), 8), 0.01) << n;
    ASSERT_TRUE(query->ground(host_->world->from_world({x, 60, z}), 0, Wait::for_file, hit));
    EXPECT_LT(host_->world->to_world(hit.place).y, ground - 1.5) << n;
  }
  // What a region has grown is in thresholds of the ground around it, which are in tiles.
  const auto tile_bytes = [](const std::vector<std::byte>& file) {
    core::WorldReader reader;
    EXPECT_TRUE(reader.open(core::ByteSource::of(file)).ok());
    return reader.tile_bytes();
  };
  EXPECT_GT(tile_bytes(test::saved_by(*editor)), tile_bytes(untouched));
  // Heights of the ground beside a region, and over its side.
  Edit raise;
  raise.tool = EditTool::extrude;
  raise.shape = BrushShape::cylinder;
  raise.radius_m = 3;
  raise.place = host_->world->from_world({80, 15, 60});
  EditResult made;
  ASSERT_TRUE(editor->apply(raise, made).ok());
  EXPECT_TRUE(made.changed);
  EXPECT_EQ(made.patches, 0u);
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 side = corner_of(n) + glm::dvec3(0.5, 12, 9);
    ViewState shown = view(side + glm::dvec3(-5, 16, 3), side);
    raise.place = host_->world->from_world({side.x, side.y, side.z});
    raise.strength_m = 2;
    Status status = editor->apply(raise, made);
    ASSERT_TRUE(status.ok()) << status.what() << status.field();
    EXPECT_GT(made.patches, 0u);
    EXPECT_GT(made.nodes, 0u);
    FrameResult result;
    EXPECT_EQ(holes(shown, 1e-6, result), 0u);
    EXPECT_EQ(holes(shown, 0, result), 0u);
  }
  // Where there is no region nothing can be dug.
  Edit beside;
  beside.place = host_->world->from_world({80, 15, 60});
  Status status = editor->apply(beside, made);
  EXPECT_STREQ(status.field(), "place");
  host_->world->release(query);
  host_->world->release(editor);
  // What a region's edits change of the ground takes tiles.
  needs.edit_tiles = 0;
  open(needs, {}, {}, file());
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  Edit dig;
  dig.place = host_->world->from_world({20, 15, 18});
  status = editor->apply(dig, made);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "edit_tiles");
  host_->world->release(editor);
}

// Digs in all regions and a hill between them: what is saved and loaded is drawn as it was, to the bit, from
// near and from far, and what is taken back is there again.
TEST_F(SeveralRegions, EditsAreSavedAsTheyAreAndTakenBack) {
  Needs needs;
  needs.edit_patches = 4'000;
  needs.edit_tiles = 100;
  needs.queries = 1;
  needs.undo_bytes = 4 << 20;
  Editor* editor = nullptr;
  Query* query = nullptr;
  const auto begin = [&](const std::vector<std::byte>& bytes) {
    open(needs, {}, {}, bytes);
    ASSERT_TRUE(host_->world->take_editor(editor).ok());
    ASSERT_TRUE(host_->world->take_query(query).ok());
  };
  const auto stop = [&] {
    host_->world->release(editor);
    host_->world->release(query);
  };
  const auto height = [&](double x, double z) {
    Hit hit;
    EXPECT_TRUE(query->ground(host_->world->from_world({x, 60, z}), 0, Wait::for_file, hit));
    return hit.found ? host_->world->to_world(hit.place).y : 0;
  };
  const auto pictures = [&] {
    std::vector<Pixels> all;
    for (int n = 0; n < kCaves; ++n) {
      const glm::dvec3 corner = corner_of(n);
      for (const double away : {1.0, 4.0, 30.0}) {
        ViewState shown =
            view(corner + glm::dvec3(6, 14, 6) + away * glm::dvec3(8, 12, 5), corner + glm::dvec3(6, 12, 6));
        shown.error_px = 1;
        test::draw_frame(*renderer_, picture_, {shown}, 0);
        all.push_back(picture_.read());
      }
    }
    return all;
  };
  begin(file());
  std::array<double, kCaves> before{};
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 at = corner_of(n) + glm::dvec3(7, 0, 7);
    before[static_cast<std::size_t>(n)] = height(at.x, at.z);
    for (int dig = 0; dig < 3; ++dig) {
      Edit edit;
      edit.radius_m = 2 + 0.5 * dig;
      edit.place = host_->world->from_world({at.x + dig, height(at.x, at.z), at.z});
      EditResult made;
      ASSERT_TRUE(editor->apply(edit, made).ok());
      EXPECT_TRUE(made.changed && made.can_undo);
    }
  }
  Edit raise;
  raise.tool = EditTool::extrude;
  raise.shape = BrushShape::cylinder;
  raise.radius_m = 3;
  raise.place = host_->world->from_world({80, 15, 60});
  EditResult made;
  ASSERT_TRUE(editor->apply(raise, made).ok());
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 side = corner_of(n) + glm::dvec3(9, 12, 0.5);
    raise.place = host_->world->from_world({side.x, side.y, side.z});
    ASSERT_TRUE(editor->apply(raise, made).ok());
    EXPECT_GT(made.patches, 0u);
  }
  const std::vector<Pixels> live = pictures();
  const std::vector<std::byte> saved = test::saved_by(*editor);
  EXPECT_EQ(editor->undo_state().undo_steps, 4u * kCaves + 1);
  while (editor->undo_state().undo_steps > 0) ASSERT_TRUE(editor->undo(made).ok());
  for (int n = 0; n < kCaves; ++n) {
    const glm::dvec3 at = corner_of(n) + glm::dvec3(7, 0, 7);
    EXPECT_EQ(height(at.x, at.z), before[static_cast<std::size_t>(n)]) << n;
  }
  while (editor->undo_state().redo_steps > 0) ASSERT_TRUE(editor->redo(made).ok());
  std::vector<Pixels> again = pictures();
  for (std::size_t n = 0; n < live.size(); ++n)
    EXPECT_EQ(test::largest_difference(live[n], again[n]), 0) << n;
  stop();
  begin(saved);
  again = pictures();
  for (std::size_t n = 0; n < live.size(); ++n)
    EXPECT_EQ(test::largest_difference(live[n], again[n]), 0) << n;
  EXPECT_TRUE(test::saved_by(*editor) == saved);
  stop();
}

}  // namespace
}  // namespace karst
