// SPDX-License-Identifier: MIT
// The promises of include/karst/renderer.h about OpenGL state, through the public calls alone:
// tests/gl/state_test.cpp is the thorough one.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/gl/dirty_host.h"
#include "tests/library/host.h"

namespace karst {
namespace {

using test::Api;
using test::DirtyHost;
using test::HostContext;
using test::HostTarget;

constexpr GlOptions options_for(Api api, Shading shading) {
  GlOptions options;
  options.first_unit = 5;
  options.first_block = 3;
  options.shading = shading;
  options.desktop = api == Api::desktop;
  return options;
}

class Program {
 public:
  Program(HostContext& host, Shading shading, bool dirty)
      : host_(host), options_(options_for(host.api(), shading)), target_(host, 0) {
    if (dirty) dirty_ = std::make_unique<DirtyHost>(host);
    run();
  }
  std::vector<std::vector<std::uint8_t>> pictures;

 private:
  template <class Work>
  void call(const char* name, GLuint framebuffer, Work work) {
    if (dirty_ != nullptr) dirty_->dirty(framebuffer, false);
    const Status status = work();
    ASSERT_TRUE(status.ok()) << name << ": " << status.what() << ' ' << status.field();
    if (dirty_ == nullptr) return;
    EXPECT_EQ(dirty_->wrong_error(false), "") << name;
    EXPECT_EQ(dirty_->wrong_state(options_.first_unit, options_.first_block), "") << name;
    EXPECT_EQ(dirty_->changed_objects(), "") << name;
  }

  void frame(const std::vector<ViewState>& views) {
    FrameResult result;
    call("begin_frame", 0, [&] {
      const Status status = renderer_->begin_frame({.views = views, .work_ms = 0}, result);
      EXPECT_EQ(host_.integer(GL_DRAW_FRAMEBUFFER_BINDING), 0);
      return status;
    });
    for (std::uint32_t n = 0; n < views.size(); ++n) {
      target_.clear(1);
      const auto framebuffer = static_cast<int>(target_.name());
      call("draw", target_.name(), [&] {
        const Status status = renderer_->draw(n, {.viewport = {4, 4, 80, 52}, .framebuffer = target_.name()});
        EXPECT_EQ(host_.integer(GL_DRAW_FRAMEBUFFER_BINDING), framebuffer);
        return status;
      });
      pictures.push_back(target_.picture());
    }
    call("end_frame", 0, [&] { return renderer_->end_frame(); });
  }

  void run() {
    Needs needs;
    needs.views = 2;
    needs.deferred_width = 80;
    needs.deferred_height = 52;
    test::HostWorld world(needs);
    ASSERT_NE(world.world, nullptr);
    call("create", 0, [&] { return Renderer::create(*world.world, host_.loader(), options_, renderer_); });
    ASSERT_NE(renderer_, nullptr);
    const WorldInfo& info = world.world->info();
    const Vec3 middle{(info.low_m.x + info.high_m.x) / 2, (info.low_m.y + info.high_m.y) / 2,
                      (info.low_m.z + info.high_m.z) / 2};
    const Vec3 eyes[3] = {{info.high_m.x, info.high_m.y + 8, info.high_m.z},
                          {info.low_m.x, info.high_m.y + 4, info.high_m.z},
                          {info.low_m.x, info.high_m.y + 9, middle.z}};
    std::vector<ViewState> views;
    for (const Vec3& eye : eyes) views.push_back(test::looking(*world.world, eye, middle, 80, 52));
    frame({views[0], views[1]});
    frame({views[2], views[0]});
    renderer_->destroy();
    if (dirty_ != nullptr) {
      EXPECT_EQ(dirty_->changed_objects(), "");
    }
  }

  HostContext& host_;
  GlOptions options_;
  HostTarget target_;
  std::unique_ptr<DirtyHost> dirty_;
  Renderer* renderer_ = nullptr;
};

class PublicState : public testing::TestWithParam<Api> {};

TEST_P(PublicState, OfTheHostDoesNotMatterAndIsLeftAsPromised) {
  HostContext host(GetParam());
  ASSERT_TRUE(host.ok());
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    const Program clean(host, shading, false);
    const Program dirty(host, shading, true);
    ASSERT_EQ(clean.pictures.size(), 4u);
    ASSERT_EQ(dirty.pictures.size(), 4u);
    for (std::size_t n = 0; n < 4; ++n) EXPECT_TRUE(clean.pictures[n] == dirty.pictures[n]) << n;
    EXPECT_FALSE(clean.pictures[0] == clean.pictures[1]);
  }
}

INSTANTIATE_TEST_SUITE_P(Hosts, PublicState, testing::Values(Api::es, Api::desktop));

}  // namespace
}  // namespace karst
