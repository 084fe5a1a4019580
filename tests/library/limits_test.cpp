// SPDX-License-Identifier: MIT
// Plans with hardly any room still give frames, which say what they gave up.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/gl/noop_gl.h"
#include "tests/library/host.h"

namespace karst {
namespace {

using test::HostWorld;
using test::NoopGl;

// Two frames; FrameLimit bits of both.
std::uint32_t limits_of(const Needs& needs, double error_px, double work_ms, bool& complete) {
  HostWorld host(needs);
  if (host.world == nullptr) return 0;
  static_cast<void>(NoopGl::reset());
  Renderer* renderer = nullptr;
  const Status made = Renderer::create(*host.world, NoopGl::loader(), {}, renderer);
  EXPECT_TRUE(made.ok()) << made.what() << " " << made.field();
  if (!made.ok()) return 0;
  std::uint32_t limits = 0;
  for (int frame = 0; frame < 2; ++frame) {
    ViewState view = test::looking(*host.world, {20.0 + frame, 30, 40}, {20, 8, 18}, 320, 180);
    view.error_px = error_px;
    FrameInput input;
    input.views = {&view, 1};
    input.work_ms = work_ms;
    FrameResult result;
    const Status begun = renderer->begin_frame(input, result);
    EXPECT_TRUE(begun.ok()) << begun.what() << " " << begun.field() << " " << begun.value();
    EXPECT_TRUE(renderer->draw(0, {.viewport = {0, 0, 320, 180}}).ok());
    EXPECT_TRUE(renderer->end_frame().ok());
    limits |= result.limits;
    complete = result.complete;
  }
  renderer->destroy();
  return limits;
}

TEST(Limits, NothingIsGivenUpWhereThereIsRoom) {
  bool complete = false;
  EXPECT_EQ(limits_of({}, 4, 0, complete), 0u);
  EXPECT_TRUE(complete);
}

TEST(Limits, LittleVertexMemoryIsNamed) {
  const std::uint64_t coarse = std::uint64_t{HostWorld().world->info().patches} * 512;
  for (const std::uint64_t bytes : {std::uint64_t{1}, std::uint64_t{4096}, coarse / 4, coarse * 2}) {
    for (const double work_ms : {0.0, 1e4}) {
      Needs needs;
      needs.vertex_bytes = bytes;
      bool complete = false;
      const std::uint32_t limits = limits_of(needs, 0.05, work_ms, complete);
      EXPECT_NE(limits & (kLimitVertexMemory | kLimitDrawItems), 0u) << bytes << " " << work_ms;
    }
  }
}

}  // namespace
}  // namespace karst
