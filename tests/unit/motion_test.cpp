// SPDX-License-Identifier: MIT
// Eyes that move: how, how long reads take, what is read ahead and what is left out.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "terrain/imagery/image_view.h"
#include "terrain/imagery/look_ahead.h"
#include "terrain/motion/eye_motion.h"
#include "terrain/motion/read_pace.h"
#include "terrain/nodes/ground_view.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::MemoryGround;

TEST(EyeMotion, IsThatOfSteadyFlightAndOfNothingElse) {
  EyeMotion motion;
  const glm::dvec3 step(3, -1, 0);
  glm::dvec3 eye(100, 50, 7);
  for (std::size_t n = 0; n < EyeMotion::kFrames; ++n) {
    motion.add(eye += step);
    EXPECT_EQ(motion.a_frame(), glm::dvec3(0)) << n;
  }
  motion.add(eye += step);
  EXPECT_EQ(motion.a_frame(), step);
  // A jump is no motion, in whichever of the frames it was.
  eye += glm::dvec3(1e6, 1e6, -1e6);
  for (std::size_t n = 0; n <= EyeMotion::kFrames; ++n) {
    motion.add(eye += step);
    EXPECT_EQ(motion.a_frame().x, step.x) << n;
    EXPECT_LE(std::abs(motion.a_frame().y), 1) << n;
    EXPECT_EQ(motion.a_frame().z, 0) << n;
  }
  // Slower at once, faster when it lasts.
  for (int n = 0; n < 4; ++n) motion.add(eye);
  EXPECT_EQ(motion.a_frame(), glm::dvec3(0));
  // Trembling.
  for (int n = 0; n < 20; ++n) {
    motion.add(eye + glm::dvec3(n % 2 == 0 ? 5 : -5, 0, 0));
    if (n > 9) {
      EXPECT_EQ(motion.a_frame(), glm::dvec3(0));
    }
  }
}

// A reader that takes so many frames a read, or does so many reads a frame.
double pace_of(int frames_a_read, int reads_a_frame, ReadPace& pace) {
  std::uint32_t under_way = 0;
  int busy = 0;
  for (int frame = 0; frame < 400; ++frame) {
    pace.begin_frame();
    if (under_way > 0 && ++busy >= frames_a_read) {
      for (int n = 0; n < reads_a_frame && under_way > 0; ++n, --under_way) pace.answer();
      busy = 0;
    }
    while (under_way < pace.depth(32)) pace.ask(under_way++);
  }
  return pace.frames_to_come(0);
}

TEST(ReadPace, FollowsTheReader) {
  ReadPace slow, even, fast;
  EXPECT_NEAR(pace_of(60, 1, slow), 61, 1);
  EXPECT_EQ(slow.depth(32), 3u);
  EXPECT_NEAR(pace_of(1, 1, even), 2, 0.1);
  EXPECT_NEAR(pace_of(1, 8, fast), 1.0 + 1.0 / 8, 0.05);
  EXPECT_EQ(fast.depth(32), 18u);
  // What is in hand for long tells before it comes.
  ReadPace waiting;
  waiting.ask(0);
  for (int n = 0; n < 100; ++n) waiting.begin_frame();
  EXPECT_NEAR(waiting.frames_to_come(1), 201, 1);
}

// A rough ground of 513 x 513 samples, with a cache, a pool and a view.
struct Flight {
  explicit Flight(std::size_t tile_count)
      : tiles(tile_count),
        entries(tile_count),
        chains(tile_count),
        families(kFamilies),
        family_chains(kFamilies),
        texels(kFamilies * 4),
        nodes(4 * kFamilies + 1),
        items(nodes.size()),
        item_nodes(nodes.size()),
        rows((kFamilies + 1) * kMorphRow) {
    cache.create({tiles, {entries, chains}});
    pool.create({families, family_chains, texels});
    view.create({nodes, items, item_nodes, rows});
    source.most_under_way = 16;
    cache.reset(source.source(), ground().root(), ground().tile(ground().root()));
    pool.reset();
    view.reset();
  }
  static const MemoryGround& ground() {
    static const MemoryGround made(513, 513, 1024, 1024, [](std::int64_t i, std::int64_t k) {
      const double x = static_cast<double>(i), z = static_cast<double>(k);
      return static_cast<std::int32_t>(400 * std::sin(x / 9) * std::cos(z / 7) + 40 * std::sin(x * z));
    });
    return made;
  }
  // Looks to the east; voxels.
  void look(glm::dvec3 eye) {
    CameraSettings settings;
    settings.position = eye;
    settings.yaw_deg = -90;
    settings.pitch_deg = -20;
    settings.near_voxels = 0.01;
    ASSERT_TRUE(make_camera(settings, camera).ok());
    request.camera = &camera;
    request.error_px = 2;
    request.scale = make_error_scale(camera, 640, 360, 2);
  }
  void frame() {
    cache.begin_frame();
    pool.begin_frame();
    cache.poll();
    view.select(ground().info(), request, cache, pool);
    cache.ask(false);
  }
  LookAhead::Result look_ahead(const glm::dvec3& way) {
    const Forecast forecast(ground().info(), request, way);
    LookAhead look;
    look.forecast = &forecast;
    look.tiles = &cache;
    look.most_visits = static_cast<std::uint32_t>(nodes.size());
    const LookAhead::Result result = look.run();
    cache.ask_ahead(cache.room_ahead());
    return result;
  }

  static constexpr std::size_t kFamilies = 3000;
  std::vector<Tile> tiles;
  std::vector<TileSlot> entries;
  std::vector<std::int32_t> chains;
  std::vector<FamilyPool::Family> families;
  std::vector<std::uint32_t> family_chains;
  std::vector<PageTexel> texels;
  std::vector<GroundView::Node> nodes;
  std::vector<DrawItem> items;
  std::vector<std::int32_t> item_nodes;
  std::vector<std::uint16_t> rows;
  TileCache cache;
  FamilyPool pool;
  GroundView view;
  MemoryGround::Source source{ground()};
  Camera camera;
  GroundRequest request;
};

TEST(LookAhead, NothingLacksWhereTheEyeCameTo) {
  Flight flight(120);
  const glm::dvec3 start(8, 1, 32), end(34, 1, 32);
  flight.look(start);
  for (int n = 0; n < 60; ++n) flight.frame();
  ASSERT_EQ(flight.view.result().lacks_tile, 0u);
  const std::uint64_t before = flight.cache.counts().came;
  const glm::dvec3 way = (end - start) * double{kStepsPerVoxel};
  int looks = 0;
  for (; looks < 60; ++looks) {
    flight.frame();
    if (looks > 0 && flight.look_ahead(way).lacks_tile == 0) break;
  }
  EXPECT_LT(looks, 60);
  const AheadCounts ahead = flight.cache.counts().ahead;
  EXPECT_GT(ahead.asked, 3u);
  EXPECT_EQ(ahead.used, 0u);
  EXPECT_EQ(flight.cache.counts().came - before, ahead.asked);
  flight.look(end);
  flight.frame();
  EXPECT_EQ(flight.view.result().lacks_tile, 0u);
  EXPECT_GT(flight.view.result().split, 20u);
  // Balls see a little more than boxes.
  EXPECT_GT(flight.cache.counts().ahead.used, ahead.asked / 2);
  EXPECT_EQ(flight.cache.counts().ahead.wasted, 0u);
}

// Image tiles of all sizes everywhere, each come in the frame after it was asked for.
struct Images {
  static constexpr std::size_t kLayers = 256;
  Images() : children(kLayers), slots(kLayers), chains(kLayers), table(kImageSizes * kImageWindowTiles) {
    cache.create({children, {slots, chains}});
    ImageSource source;
    source.context = this;
    source.ask = [](void* self, NodeKey key, const TilePlace&) {
      static_cast<Images*>(self)->asked.push_back(key);
      return true;
    };
    source.poll = [](void* self, ImageArrival& out) {
      auto& own = *static_cast<Images*>(self);
      if (own.asked.empty()) return TileSource::Answer::none;
      out = {};
      out.key = own.asked.back();
      for (TilePlace& place : out.children.places) place = {1, 1, 0};
      own.asked.pop_back();
      return TileSource::Answer::ready;
    };
    cache.reset(source, Flight::ground().root(), {1, 1, 0});
    view.create({table});
    view.reset();
  }
  void frame() {
    cache.begin_frame();
    std::int32_t layer = 0;
    for (ImageArrival arrival; cache.poll(layer, arrival);) continue;
  }
  std::vector<ImageChildren> children;
  std::vector<TileSlot> slots;
  std::vector<std::int32_t> chains;
  std::vector<std::uint16_t> table;
  std::vector<NodeKey> asked;
  ImageCache cache;
  ImageView view;
};

TEST(LookAhead, NothingLacksOfImageryEither) {
  Flight flight(120);
  Images images;
  const ImageryInfo imagery{ImageFormat::rgba8, 1};
  const glm::dvec3 end(34, 1, 32);
  ImageRequest request;
  request.camera = &flight.camera;
  request.pixel = 2.0 / 360;
  flight.look({8, 1, 32});
  int looks = 0;
  for (bool lacks = true; lacks && looks < 100; ++looks) {
    flight.frame();
    images.frame();
    const Forecast forecast(Flight::ground().info(), flight.request,
                            glm::dvec3(26, 0, 0) * double{kStepsPerVoxel});
    LookAhead look;
    look.forecast = &forecast;
    look.tiles = &flight.cache;
    look.images = &images.cache;
    look.imagery = imagery;
    look.pixel = request.pixel;
    look.most_visits = 10000;
    const LookAhead::Result result = look.run();
    lacks = result.lacks_tile + result.lacks_image > 0;
    flight.cache.ask_ahead(8);
    images.cache.ask_ahead(8);
  }
  EXPECT_LT(looks, 100);
  EXPECT_GT(images.cache.counts().ahead.asked, 8u);
  flight.look(end);
  flight.frame();
  images.frame();
  images.view.select(Flight::ground().info(), imagery, flight.view, request, images.cache);
  EXPECT_GT(images.view.result().visited, 8u);
  EXPECT_EQ(images.view.result().lacking, 0u);
  EXPECT_GT(images.cache.counts().ahead.used, 8u);
  // In fast flight the finest are left out, and the root never.
  Images others;
  const Forecast gone(Flight::ground().info(), flight.request, glm::dvec3(26, 0, 0) * 1e4);
  request.forecast = &gone;
  for (int n = 0; n < 20; ++n) {
    flight.frame();
    others.frame();
    others.view.select(Flight::ground().info(), imagery, flight.view, request, others.cache);
    others.cache.ask(false);
  }
  EXPECT_EQ(others.cache.counts().came, 1u);
  EXPECT_EQ(others.view.result().left_out, others.view.result().lacking);
  EXPECT_GT(others.view.result().left_out, 0u);
}

TEST(LookAhead, TakesNoRoomFromWhatIsSeen) {
  Flight flight(120);
  flight.look({8, 1, 32});
  for (int n = 0; n < 60; ++n) flight.frame();
  ASSERT_EQ(flight.view.result().lacks_tile, 0u);
  Flight tight(flight.cache.counts().came + 1);
  tight.look({8, 1, 32});
  for (int n = 0; n < 60; ++n) tight.frame();
  ASSERT_EQ(tight.view.result().lacks_tile, 0u);
  for (int n = 0; n < 60; ++n) {
    tight.look_ahead(glm::dvec3(26, 0, 0) * double{kStepsPerVoxel});
    tight.frame();
    ASSERT_EQ(tight.view.result().lacks_tile, 0u) << n;
  }
  EXPECT_GT(tight.cache.counts().ahead.wasted, 0u);
  EXPECT_EQ(tight.cache.counts().ahead.used, 0u);
}

// What is gone before it comes is not asked for, and is counted; what stays in view is.
TEST(LookAhead, FastFlightLeavesTheFinestOut) {
  std::uint32_t left_out[3] = {};
  std::uint64_t came[3] = {};
  std::int32_t below[3] = {};
  for (int n = 0; n < 3; ++n) {
    Flight flight(120);
    flight.look({8, 1, 32});
    const double voxels_a_frame[] = {0, 3, 40};
    flight.request.motion = glm::dvec3(voxels_a_frame[n] * kStepsPerVoxel, 0, 0);
    for (int k = 0; k < 60; ++k) flight.frame();
    left_out[n] = flight.view.result().left_out;
    below[n] = flight.view.result().left_out_below;
    came[n] = flight.cache.counts().came;
    EXPECT_EQ(flight.view.result().lacks_tile, left_out[n]);
  }
  EXPECT_EQ(left_out[0], 0u);
  EXPECT_EQ(below[0], 0);
  EXPECT_GT(left_out[1], 0u);
  EXPECT_LT(came[1], came[0]);
  EXPECT_GT(came[1], came[2]);
  EXPECT_GE(below[2], below[1]);
  EXPECT_GT(below[2], 0);
}

}  // namespace
}  // namespace karst::core
