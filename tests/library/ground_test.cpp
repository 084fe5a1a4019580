// SPDX-License-Identifier: MIT
// Worlds that are a ground: closed in every frame, whatever is missing; never waited for; asked and drawn
// alike.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "tests/library/ground_file.h"
#include "tests/library/host.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

class GroundWorlds : public test::HostTest {
 protected:
  GroundWorlds() : HostTest(kWidth, kHeight) {}

  static const std::vector<std::byte>& file() {
    static const std::vector<std::byte> bytes =
        test::ground_file(test::rough_ground(), test::kRoughSpacing_m);
    return bytes;
  }
  void open_ground(Needs needs = {}, GlOptions options = {}) { open(needs, {}, options, file()); }

  ViewState view(Vec3 eye, Vec3 target) const {
    return test::looking(*host_->world, eye, target, kWidth, kHeight);
  }
  double height(double x, double z) {
    Query* query = nullptr;
    EXPECT_TRUE(host_->world->take_query(query).ok());
    Hit hit;
    EXPECT_TRUE(query->ground(host_->world->from_world({x, 1000, z}), 0, Wait::for_file, hit));
    host_->world->release(query);
    return host_->world->to_world(hit.place).y;
  }
};

TEST_F(GroundWorlds, ThePlanIsWhatIsTaken) {
  open_ground();
  const DeviceInfo device = device_info(*renderer_);
  EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
  EXPECT_EQ(device.gpu_bytes, host_->plan.gpu_bytes);
  std::uint64_t cpu = 0;
  for (std::uint32_t n = 0; n < host_->plan.term_count; ++n) {
    if (!host_->plan.terms[n].gpu) cpu += host_->plan.terms[n].bytes;
  }
  EXPECT_EQ(cpu, host_->plan.cpu_bytes);
  const WorldInfo& info = host_->world->info();
  EXPECT_EQ(info.patches, 0u);
  EXPECT_EQ(info.ground_samples[0], 600);
  EXPECT_EQ(info.ground_samples[1], 480);
  EXPECT_DOUBLE_EQ(info.ground_spacing_m[0], 10);
  EXPECT_NEAR(info.high_m.x, 5990, 0.01);
  EXPECT_NEAR(info.high_m.z, 4790, 0.01);
  EXPECT_LT(info.high_m.y, 62);
}

TEST_F(GroundWorlds, QueriesMeetTheSamples) {
  Needs needs;
  needs.queries = 1;
  open_ground(needs);
  const auto heights = test::rough_heights();
  const double unit = test::kRoughSpacing_m / 1024;
  for (int n = 0; n < 50; ++n) {
    const int i = 1 + n * 11 % 590, k = 1 + n * 37 % 470;
    EXPECT_NEAR(height(10 * i, 10 * k), heights(i, k) * unit, 1e-6);
  }
}

// Cameras that see nothing but ground, over a file that answers late, with pools that are too small.
TEST_F(GroundWorlds, NoPixelLooksThroughWhateverIsMissing) {
  const char* const wanted = std::getenv("KARST_FRAMES");
  const int frames = wanted != nullptr ? std::atoi(wanted) / 4 : 120;
  for (const bool deferred : {false, true}) {
    for (const std::uint64_t vertex_bytes : {std::uint64_t{0}, std::uint64_t{200} << 10}) {
      Needs needs;
      needs.vertex_bytes = vertex_bytes;
      if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
      needs.max_cpu_bytes = vertex_bytes == 0 ? needs.max_cpu_bytes : 6u << 20;
      GlOptions options;
      options.shading = deferred ? Shading::deferred : Shading::forward;
      open_ground(needs, options);
      std::mt19937 random(7);
      const auto between = [&](double a, double b) {
        return std::uniform_real_distribution<double>(a, b)(random);
      };
      int incomplete = 0;
      for (int frame = 0; frame < frames; ++frame) {
        const double x = between(1500, 4500), z = between(1500, 3300);
        // Above all of it: coarse ground may be higher than what it stands for.
        const Vec3 eye{x, 63 + std::exp2(between(0, 8)), z};
        const double turn = between(0, 6.28);
        const double down = between(1.0, 2.0);
        const Vec3 target{eye.x + std::cos(turn), eye.y - down, eye.z + std::sin(turn)};
        ViewState shown = view(eye, target);
        shown.error_px = std::exp2(between(-1, 4));
        FrameResult result;
        const double work_ms = frame % 3 == 0 ? 0 : 0.01;
        ASSERT_EQ(holes(shown, work_ms, result), 0u) << frame << ' ' << deferred << ' ' << vertex_bytes;
        incomplete += result.lacking > 0 ? 1 : 0;
      }
      EXPECT_GT(incomplete, 5);
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
      close();
    }
  }
}

TEST_F(GroundWorlds, APictureComesToRestAndIsThatOfAFrameThatWaits) {
  Needs needs;
  needs.queries = 1;
  open_ground(needs);
  const Vec3 eye{3000, height(3000, 2400) + 40, 2400};
  const ViewState shown = view(eye, {3400, 20, 2000});
  FrameResult result;
  int frames = 0;
  do {
    result = test::draw_frame(*renderer_, picture_, {shown}, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  } while (!result.complete && ++frames < 2000);
  ASSERT_TRUE(result.complete);
  EXPECT_LE(result.error_px[0], shown.error_px);
  const Pixels late = picture_.read();
  close();
  open_ground(needs);
  result = test::draw_frame(*renderer_, picture_, {shown}, 0);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(late.rgba, picture_.read().rgba);
}

// A file that takes 30 ms a read: frames read nothing themselves, and are there before it.
TEST_F(GroundWorlds, FramesDoNotWaitForTheFile) {
  test::MemoryFile memory(file());
  struct Slow {
    Source from;
    std::thread::id frames = std::this_thread::get_id();
    std::atomic<bool> drawing = false;
    std::atomic<int> own = 0, reads = 0;
  } slow;
  slow.from = memory.source();
  Source source;
  source.bytes = slow.from.bytes;
  source.user = &slow;
  source.read = [](void* user, std::uint64_t offset, std::byte* out, std::size_t bytes) {
    auto& own = *static_cast<Slow*>(user);
    ++own.reads;
    if (own.drawing && std::this_thread::get_id() == own.frames) ++own.own;
    if (own.drawing) std::this_thread::sleep_for(std::chrono::milliseconds(30));
    return own.from.read(own.from.user, offset, out, bytes);
  };
  Plan plan;
  ASSERT_TRUE(make_plan(source, plan).ok());
  test::AlignedBytes room(plan.cpu_bytes);
  World* world = nullptr;
  ASSERT_TRUE(World::create(plan, source, room.bytes(), world).ok());
  Renderer* renderer = nullptr;
  ASSERT_TRUE(Renderer::create(*world, picture_.loader(), {}, renderer).ok());
  const ViewState shown = test::looking(*world, {3000, 90, 2400}, {3400, 20, 2000}, kWidth, kHeight);
  // The first frame is whole.
  test::draw_frame(*renderer, picture_, {shown}, 1);
  slow.drawing = true;
  const ViewState elsewhere = test::looking(*world, {500, 90, 400}, {900, 20, 1000}, kWidth, kHeight);
  const int before = slow.reads;
  int frames = 0;
  FrameResult result;
  double worst_px = 0;
  do {
    result = test::draw_frame(*renderer, picture_, {elsewhere}, 1);
    worst_px = std::max(worst_px, result.error_px[0]);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } while (!result.complete && ++frames < 5000);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(slow.own, 0) << "reads by the thread that draws";
  EXPECT_GT(slow.reads, before);
  EXPECT_GT(frames, slow.reads - before) << "more frames than reads";
  EXPECT_GT(worst_px, elsewhere.error_px);
  slow.drawing = false;
  renderer->destroy();
  world->destroy();
}

// What a moving view will lack is asked for before, whether the host tells how it moves or not; and no more
// than that where it is told not to.
TEST_F(GroundWorlds, MovingViewsAreReadAhead) {
  enum class Way { none, seen, told };
  for (const Way way : {Way::none, Way::seen, Way::told}) {
    open_ground();
    Inspection inspection;
    inspection.read_ahead = way != Way::none;
    set_inspection(*renderer_, inspection);
    std::uint32_t asked = 0, used = 0, first = 0;
    FrameResult result;
    for (int frame = 0; frame < 80; ++frame) {
      const double x = 800 + 30.0 * frame;
      ViewState shown = view({x, 90, 2400}, {x + 400, 40, 2400});
      shown.has_motion = way == Way::told;
      shown.motion = host_->world->from_world({30, 0, 0});
      const Vec3 zero = host_->world->from_world({0, 0, 0});
      shown.motion = {shown.motion.x - zero.x, shown.motion.y - zero.y, shown.motion.z - zero.z};
      result = test::draw_frame(*renderer_, picture_, {shown}, 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      asked += costs(*renderer_).ahead_asked;
      used += costs(*renderer_).ahead_used;
      if (frame < 8) first += costs(*renderer_).ahead_asked;
    }
    if (way == Way::none) {
      EXPECT_EQ(asked, 0u);
      continue;
    }
    EXPECT_GT(asked, 0u);
    EXPECT_GT(used, 0u);
    EXPECT_LE(used, asked);
    // Nobody but the host knows before nine frames.
    if (way == Way::seen) {
      EXPECT_EQ(first, 0u);
    }
  }
  // Of an eye that stands the host's word counts.
  ViewState shown = view({800, 90, 2400}, {1200, 40, 2400});
  for (const bool told : {false, true}) {
    open_ground();
    const Vec3 there = host_->world->from_world({30, 0, 0}), here = host_->world->from_world({0, 0, 0});
    shown.has_motion = told;
    shown.motion = {there.x - here.x, there.y - here.y, there.z - here.z};
    std::uint32_t asked = 0;
    for (int frame = 0; frame < 80; ++frame) {
      test::draw_frame(*renderer_, picture_, {shown}, 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      asked += costs(*renderer_).ahead_asked;
    }
    EXPECT_EQ(asked > 0, told);
  }
  shown.motion.x = std::numeric_limits<double>::quiet_NaN();
  FrameInput input;
  input.views = {&shown, 1};
  FrameResult result;
  const Status refused = renderer_->begin_frame(input, result);
  EXPECT_EQ(refused.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(refused.field(), "motion");
}

// With the fewest tiles, a picture that wants more comes to rest, coarser, and says why.
TEST_F(GroundWorlds, TooFewTilesAreSaid) {
  Needs needs;
  needs.vertex_bytes = 64u << 20;
  needs.max_gpu_bytes = 256u << 20;
  Plan plan;
  plan.needs = needs;
  plan.needs.max_cpu_bytes = 0;
  test::MemoryFile memory(file());
  needs.max_cpu_bytes = make_plan(memory.source(), plan).value();
  open_ground(needs);
  ViewState shown = view({600, 400, 500}, {5000, 20, 4200});
  set_perspective(shown, 80, 1, 20000);
  shown.error_px = 0.02;
  FrameResult result;
  std::uint32_t limits = 0;
  for (int frame = 0; frame < 300; ++frame) {
    result = test::draw_frame(*renderer_, picture_, {shown}, 5);
    limits |= result.limits;
    if (result.complete) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_NE(limits & kLimitTiles, 0u);
  EXPECT_TRUE(result.complete);
  EXPECT_GT(result.lacking, 0u);
}

TEST_F(GroundWorlds, ATileThatCannotBeReadIsDrawnCoarserAndSaid) {
  Needs needs;
  needs.queries = 1;
  open_ground(needs);
  const ViewState shown = view({3000, 90, 2400}, {3400, 20, 2000});
  host_->file.fails = true;
  FrameResult result;
  ASSERT_EQ(holes(view({3000, 90, 2400}, {3001, 88, 2401}), 1, result), 0u);
  do {
    result = test::draw_frame(*renderer_, picture_, {shown}, 1);
  } while ((result.limits & kLimitFile) == 0);
  EXPECT_FALSE(result.complete);
  FrameInput input;
  input.views = {&shown, 1};
  input.work_ms = 0;
  EXPECT_EQ(renderer_->begin_frame(input, result).code(), StatusCode::io);
  EXPECT_TRUE(renderer_->end_frame().ok());
  host_->file.fails = false;
  result = test::draw_frame(*renderer_, picture_, {shown}, 0);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.limits & kLimitFile, 0u);
}

}  // namespace
}  // namespace karst
