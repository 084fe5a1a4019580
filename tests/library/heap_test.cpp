// SPDX-License-Identifier: MIT
// After World::create() and Renderer::create() karst takes no memory and makes no GL objects, whatever a
// flight asks of it. The driver is one that does nothing, so that all calls of the heap are karst's.
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/gl/noop_gl.h"
#include "tests/library/host.h"
#include "tests/support/heap_count.h"

namespace karst {
namespace {

using test::HostWorld;
using test::NoopGl;

constexpr int kFrames = 200;

// Little room for vertices and heights: both come and go all the time.
Needs tight_needs() {
  Needs needs;
  needs.views = 2;
  needs.queries = 1;
  needs.query_patches = 64;
  {
    const HostWorld host;
    const std::uint64_t coarse = std::uint64_t{host.world->info().patches} * 512;
    needs.vertex_bytes = coarse + coarse / 2;
  }
  Plan plan;
  plan.needs = needs;
  plan.needs.max_cpu_bytes = 0;
  test::MemoryFile file(test::cave_world_file());
  needs.max_cpu_bytes = make_plan(file.source(), plan).value();
  return needs;
}

ViewState flying(const World& world, int frame, int n) {
  const double angle = 0.05 * frame + 2 * n;
  const Vec3 eye{20 + 14 * std::cos(angle), 20 + 3 * std::sin(0.3 * frame), 18 + 12 * std::sin(angle)};
  ViewState view = test::looking(world, eye, {20, 8 + 0.01 * frame, 18}, 320, 180);
  view.error_px = 1 + frame % 50 / 5.0;
  if (n == 1) set_perspective(view, 20 + frame % 40, 0.5, 500);
  return view;
}

struct Flight {
  Status status;
  std::uint64_t made = 0;
  std::uint64_t uploaded = 0;
  std::uint64_t triangles = 0;
  int casters = 0;
  int found = 0;
};

void ask(const World& world, Query& query, int frame, Flight& flight) {
  const Vec3 at{20 + 15 * std::sin(0.07 * frame), 24, 18 + 13 * std::cos(0.11 * frame)};
  const Vec3 place = world.from_world(at);
  const Vec3 below = world.from_world({at.x + 1, 0, at.z - 1});
  Hit hit;
  Voxel voxel;
  std::array<Hit, 8> column;
  std::array<Vec3, 20> from;
  std::array<Vec3, 20> to;
  std::array<Hit, 20> hits;
  for (std::size_t n = 0; n < from.size(); ++n) {
    from[n] = place;
    to[n] = world.from_world({2.0 * static_cast<double>(n), 0, at.z});
  }
  const Wait wait = frame % 2 == 0 ? Wait::never : Wait::for_file;
  flight.found += query.ground(place, 1, wait, hit);
  flight.found += query.ray(place, below, wait, hit);
  flight.found += query.sphere(place, below, 0.5, wait, hit);
  flight.found += query.pick(place, below, 5, voxel);
  flight.found += static_cast<int>(query.column(place, wait, column));
  flight.found += query.inside(below, wait);
  query.rays(from, to, wait, hits);
  if (frame % 10 == 0) static_cast<void>(query.prepare(hit.place, 3));
}

Flight fly(World& world, Renderer& renderer) {
  Flight flight;
  for (int frame = 0; frame < kFrames && flight.status.ok(); ++frame) {
    const std::array<ViewState, 2> views = {flying(world, frame, 0), flying(world, frame, 1)};
    FrameInput input;
    input.views = std::span(views).first(frame % 9 == 8 ? 1 : 2);
    input.work_ms = frame % 20 == 0 ? 0 : 1e4;
    input.sun.towards = {0.6, 0.5 + 0.001 * frame, -0.5};
    input.casters_moved = frame % 3 == 0;
    input.user = &flight;
    input.draw_casters = [](void* user, const double*, Vec3) { ++static_cast<Flight*>(user)->casters; };
    FrameResult result;
    flight.status = renderer.begin_frame(input, result);
    flight.triangles += result.triangles;
    for (std::uint32_t n = 0; n < input.views.size() && flight.status.ok(); ++n) {
      static_cast<void>(renderer.air(n));
      flight.status = renderer.draw(n, {{0, 0, 320, 180}, n == 0, n == 0 ? Output::linear : Output::display});
    }
    Query* query = nullptr;
    if (!world.take_query(query).ok()) break;
    ask(world, *query, frame, flight);
    world.release(query);
    if (flight.status.ok()) flight.status = renderer.end_frame();
    flight.made += result.made;
    flight.uploaded += costs(renderer).uploaded_bytes;
  }
  return flight;
}

TEST(Heap, NoCallsAndNoGlObjectsInAFlight) {
  HostWorld host(tight_needs(), {Axes::north_east_down, {1000, 2000, 30}, 17});
  ASSERT_NE(host.world, nullptr);
  ASSERT_FALSE(host.plan.holds_all_heights);
  static_cast<void>(NoopGl::reset());
  Renderer* renderer = nullptr;
  const Status made = Renderer::create(*host.world, NoopGl::loader(), {}, renderer);
  ASSERT_TRUE(made.ok()) << made.what() << " " << made.field();
  EXPECT_EQ(NoopGl::get().object_bytes, host.plan.gpu_bytes);
  const std::uint64_t objects = NoopGl::get().objects_made;
  const std::uint64_t bytes = NoopGl::get().object_bytes;
  const std::uint64_t questions = NoopGl::get().questions;
  const std::uint64_t heap = test::heap_calls();
  const Flight flight = fly(*host.world, *renderer);
  const std::uint64_t heap_after = test::heap_calls();
  renderer->destroy();
  const std::uint64_t heap_destroyed = test::heap_calls();
  EXPECT_TRUE(flight.status.ok()) << flight.status.what() << " " << flight.status.field();
  EXPECT_EQ(heap_after - heap, 0u);
  EXPECT_EQ(NoopGl::get().objects_made - objects, 0u);
  EXPECT_EQ(NoopGl::get().object_bytes - bytes, 0u);
  EXPECT_EQ(NoopGl::get().questions - questions, 0u);
  // The flight did something.
  EXPECT_GT(flight.made, 1000u);
  EXPECT_GT(flight.uploaded, 100'000u);
  EXPECT_GT(flight.triangles, std::uint64_t{kFrames} * 100);
  EXPECT_GE(flight.casters, kFrames / 3);
  EXPECT_GT(flight.found, kFrames * 3);
  EXPECT_EQ(heap_destroyed - heap_after, 0u);
  EXPECT_EQ(NoopGl::get().objects_deleted, NoopGl::get().objects_made);
}

}  // namespace
}  // namespace karst
