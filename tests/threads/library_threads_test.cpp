// SPDX-License-Identifier: MIT
// What the public headers say of threads (karst.h), to be run under ThreadSanitizer: queries are taken, asked
// and given back on two threads beside one that draws.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "karst/karst.h"
#include "tests/gl/noop_gl.h"
#include "tests/library/ground_file.h"
#include "tests/support/test_world.h"

namespace karst {
namespace {

using test::NoopGl;

constexpr int kGroups = 120;

// Hills under rough heights, 24 x 10 x 24 voxels.
std::vector<std::byte> rolling_file() {
  test::TestWorld world({24, 10, 24}, [](glm::ivec3 v) {
    return v.y < 4.0 + 3.0 * test::value_noise(5, glm::dvec3(v.x, 0, v.z) / 6.0) || v.y == 0;
  });
  world.roughen(4, 6, 1500);
  return world.file();
}

// The same size as a ground: 600 x 600 samples.
std::vector<std::byte> ground_file() {
  const test::MemoryGround ground(600, 600, 2048, 2048, [](std::int64_t i, std::int64_t k) {
    const double height =
        3.5 + 2 * std::sin(0.05 * double(i)) + std::cos(0.07 * double(k)) + 0.01 * double(i * k % 7);
    return static_cast<std::int32_t>(height * 1024 / 0.04);
  });
  return test::ground_file(ground, 0.04);
}

// A file whose reads stop while it is shut, on a disk that does not answer. Reads of the thread that made it
// fail then and are counted, so that a frame which would wait does not hang.
class Gate {
 public:
  explicit Gate(const std::vector<std::byte>& bytes) : bytes_(bytes) {}
  Source source() { return {bytes_.size(), read, this}; }
  void shut(bool is_shut) {
    const std::lock_guard lock(mutex_);
    shut_ = is_shut;
    changed_.notify_all();
  }
  int own_reads() const { return own_reads_; }
  int waiting() const { return waiting_; }

 private:
  static bool read(void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
    auto& gate = *static_cast<Gate*>(user);
    std::unique_lock lock(gate.mutex_);
    if (gate.shut_ && std::this_thread::get_id() == gate.made_by_) {
      ++gate.own_reads_;
      return false;
    }
    ++gate.waiting_;
    gate.changed_.wait(lock, [&] { return !gate.shut_; });
    --gate.waiting_;
    std::memcpy(out, gate.bytes_.data() + offset, count);
    return true;
  }

  const std::vector<std::byte>& bytes_;
  const std::thread::id made_by_ = std::this_thread::get_id();
  std::mutex mutex_;
  std::condition_variable changed_;
  bool shut_ = false;
  std::atomic<int> own_reads_ = 0;
  std::atomic<int> waiting_ = 0;
};

// Bytes of a file; any thread reads them.
Source source_of(const std::vector<std::byte>& bytes) {
  const auto read = [](void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
    std::memcpy(out, static_cast<const std::byte*>(user) + offset, count);
    return true;
  };
  return {bytes.size(), read, const_cast<std::byte*>(bytes.data())};
}

// A group of questions of all kinds, told by its number alone.
void ask(Query& query, const World& world, int group, std::vector<Hit>& answers) {
  test::Random random{static_cast<std::uint64_t>(group) * 1000};
  const auto place = [&] {
    const double x = random.unit();
    const double y = random.unit();
    return world.from_world({24 * x, 10 * y, 24 * random.unit()});
  };
  const Wait wait = Wait::for_file;
  const Vec3 a = place();
  const Vec3 b = place();
  Hit hits[8];
  query.ray(a, b, wait, hits[0]);
  query.ground(a, 1, wait, hits[1]);
  query.sphere(a, b, 0.3, wait, hits[2]);
  hits[3].level = query.inside(b, wait) ? 1 : 0;
  query.column(b, wait, std::span(hits).subspan(4));
  Voxel voxel;
  if (query.pick(a, b, 4, voxel)) hits[7].place = voxel.centre;
  answers.insert(answers.end(), std::begin(hits), std::end(hits));
}

bool same_bits(const Hit& a, const Hit& b) {
  const auto same = [](const Vec3& p, const Vec3& q) { return std::memcmp(&p, &q, sizeof p) == 0; };
  return same(a.place, b.place) && same(a.normal, b.normal) &&
         std::memcmp(&a.distance, &b.distance, sizeof a.distance) == 0 && a.patch == b.patch &&
         a.level == b.level && a.found == b.found;
}

// The first answer that differs; a.size() where none does.
std::size_t first_difference(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  std::size_t n = 0;
  while (n < a.size() && n < b.size() && same_bits(a[n], b[n])) ++n;
  return n;
}

class LibraryThreads : public testing::Test {
 protected:
  explicit LibraryThreads(std::vector<std::byte> bytes = rolling_file()) : file(std::move(bytes)) {}

  void SetUp() override {
    // Heights are read from the file by all threads.
    plan.needs.queries = 2;
    plan.needs.query_patches = 32;
    plan.needs.max_cpu_bytes = 0;
    plan.placement = {Axes::north_east_down, {100, -200, 3}, 30};
    const Source source = source_of(file);
    plan.needs.max_cpu_bytes = make_plan(source, plan).value();
    ASSERT_TRUE(make_plan(source, plan).ok());
    memory = std::make_unique<test::AlignedBytes>(plan.cpu_bytes);
    ASSERT_TRUE(World::create(plan, source, memory->bytes(), world).ok());
    static_cast<void>(NoopGl::reset());
    ASSERT_TRUE(Renderer::create(*world, NoopGl::loader(), {}, renderer).ok());
  }
  void TearDown() override {
    if (renderer != nullptr) renderer->destroy();
    if (world != nullptr) world->destroy();
  }

  // Takes a query for each group and gives it back: threads swap queries all the time.
  void ask_all(std::vector<Hit>& answers) const {
    for (int group = 0; group < kGroups; ++group) {
      Query* query = nullptr;
      if (!world->take_query(query).ok()) return;
      ask(*query, *world, group, answers);
      static_cast<void>(query->prepare(answers.back().place, 1));
      world->release(query);
    }
  }

  Status draw(int frame) {
    ViewState view;
    view.width_px = 320;
    view.height_px = 180;
    view.eye = world->from_world({12 + 8 * std::sin(0.2 * frame), 12, 12 + 8 * std::cos(0.2 * frame)});
    view.error_px = 0.5 + frame % 5;
    const Vec3 top = world->from_world({0, 1, 0});
    const Vec3 zero = world->from_world({0, 0, 0});
    if (!look_at(view, world->from_world({12, 4, 12}), {top.x - zero.x, top.y - zero.y, top.z - zero.z}))
      return {StatusCode::invalid_argument, "no direction", "view"};
    set_perspective(view, 60, 0.5, 500);
    FrameInput input;
    input.views = {&view, 1};
    input.sun.towards = {0.1, 0.3, -0.8};
    input.work_ms = 1e4;
    FrameResult result;
    if (const Status status = renderer->begin_frame(input, result); !status.ok()) return status;
    if (const Status status = renderer->draw(0, {.viewport = {0, 0, 320, 180}}); !status.ok()) return status;
    const Status status = renderer->end_frame();
    made += result.made;
    return status;
  }

  // Questions beside each other and beside frames have the answers of one thread.
  void compare();

  std::vector<std::byte> file;
  std::unique_ptr<test::AlignedBytes> memory;
  Plan plan;
  World* world = nullptr;
  Renderer* renderer = nullptr;
  std::uint64_t made = 0;
};

// Its tiles are read by queries, by a thread of the library for frames, and asked for by them.
class GroundThreads : public LibraryThreads {
 protected:
  GroundThreads() : LibraryThreads(ground_file()) {}
};

TEST_F(LibraryThreads, QueriesAnswerTheSameBitsBesideARendererAndEachOther) {
  ASSERT_FALSE(plan.holds_all_heights);
  compare();
}

TEST_F(GroundThreads, QueriesAnswerTheSameBitsBesideARendererAndEachOther) {
  compare();
}

void LibraryThreads::compare() {
  std::vector<Hit> expected;
  ask_all(expected);
  ASSERT_EQ(expected.size(), std::size_t{kGroups} * 8);
  const auto found = [](const Hit& hit) { return hit.found || hit.distance != 0; };
  EXPECT_GT(std::count_if(expected.begin(), expected.end(), found), kGroups);

  std::vector<Hit> of_one, of_two;
  std::atomic<int> asking = 2;
  std::thread first([&] {
    ask_all(of_one);
    --asking;
  });
  std::thread second([&] {
    ask_all(of_two);
    --asking;
  });
  Status status;
  int frame = 0;
  for (; status.ok() && (frame < 20 || asking > 0); ++frame) status = draw(frame);
  first.join();
  second.join();
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  EXPECT_GT(made, 100u);
  EXPECT_EQ(of_one.size(), expected.size());
  EXPECT_EQ(of_two.size(), expected.size());
  EXPECT_EQ(first_difference(of_one, expected), expected.size());
  EXPECT_EQ(first_difference(of_two, expected), expected.size());
}

// While the disk does not answer at all, frames are drawn, coarser; once it does, they become sharp.
TEST(GroundOnADeadDisk, FramesAreDrawnAllTheSame) {
  const std::vector<std::byte> bytes = ground_file();
  Gate gate(bytes);
  Plan plan;
  ASSERT_TRUE(make_plan(gate.source(), plan).ok());
  const test::AlignedBytes room(plan.cpu_bytes);
  World* world = nullptr;
  ASSERT_TRUE(World::create(plan, gate.source(), room.bytes(), world).ok());
  static_cast<void>(NoopGl::reset());
  Renderer* renderer = nullptr;
  ASSERT_TRUE(Renderer::create(*world, NoopGl::loader(), {}, renderer).ok());
  FrameResult result;
  const auto draw = [&](double x, double z) {
    ViewState view;
    view.width_px = 320;
    view.height_px = 180;
    view.eye = {x, 0.5, z};
    EXPECT_TRUE(look_at(view, {x + 0.5, 0.2, z + 0.1}, {0, 1, 0}));
    set_perspective(view, 60, 0.01, 50);
    view.error_px = 1;
    FrameInput input;
    input.views = {&view, 1};
    input.work_ms = 1;
    Status status = renderer->begin_frame(input, result);
    if (status.ok()) status = renderer->draw(0, {.viewport = {0, 0, 320, 180}});
    if (status.ok()) status = renderer->end_frame();
    EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  };
  // The first frame is complete.
  draw(4, 4);
  ASSERT_TRUE(result.complete);
  gate.shut(true);
  constexpr int kFrames = 100;
  int lacking = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    draw(4 + 0.16 * frame, 20 - 0.16 * frame);
    lacking += result.lacking > 0 ? 1 : 0;
    EXPECT_GT(result.triangles, 0u);
  }
  EXPECT_EQ(gate.own_reads(), 0) << "reads by the thread that draws";
  EXPECT_GT(lacking, kFrames / 2);
  // The library's thread is the one that waits.
  for (int n = 0; n < 1000 && gate.waiting() == 0; ++n)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(gate.waiting(), 1);
  gate.shut(false);
  for (int n = 0; n < 5000 && !result.complete; ++n) {
    draw(4 + 0.16 * kFrames, 20 - 0.16 * kFrames);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(result.complete);
  EXPECT_LE(result.error_px[0], 1);
  renderer->destroy();
  world->destroy();
}

// Planning and creating worlds needs no thread of its own.
TEST_F(LibraryThreads, AWorldIsMadeBesideOneThatIsDrawn) {
  ASSERT_GT(world->info().patches, 0u);
  std::uint32_t patches = 0;
  std::thread other([&] {
    for (int n = 0; n < 3; ++n) {
      Plan own;
      own.needs.queries = 1;
      const Source source = source_of(file);
      if (!make_plan(source, own).ok()) return;
      const test::AlignedBytes room(own.cpu_bytes);
      World* made_world = nullptr;
      if (!World::create(own, source, room.bytes(), made_world).ok()) return;
      patches += made_world->info().patches;
      made_world->destroy();
    }
  });
  Status status;
  for (int frame = 0; frame < 10 && status.ok(); ++frame) status = draw(frame);
  other.join();
  EXPECT_TRUE(status.ok()) << status.what();
  EXPECT_EQ(patches, 3 * world->info().patches);
}

}  // namespace
}  // namespace karst
