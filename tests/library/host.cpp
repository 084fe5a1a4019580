// SPDX-License-Identifier: MIT
#include "tests/library/host.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <gtest/gtest.h>

#include "platform/headless/headless_display.h"

namespace karst::test {

Source MemoryFile::source() {
  return {bytes_.size(),
          [](void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
            auto* const self = static_cast<MemoryFile*>(user);
            ++self->reads_;
            if (self->fails) return false;
            std::memcpy(out, self->bytes_.data() + offset, count);
            return true;
          },
          this};
}

std::vector<std::byte> cave_world_file() {
  static const std::vector<std::byte> kFile = [] {
    TestWorld world({40, 24, 36}, [](glm::ivec3 v) {
      const glm::dvec3 p(v);
      const double ground = 10 + 4 * value_noise(5, glm::dvec3(p.x, 0, p.z) / 11.0);
      const bool cave = std::hypot(p.y - 6.5, p.z - 18.0) < 3.2;
      return p.y + 0.5 < ground && !cave;
    });
    world.roughen(4, 3, 500);
    return world.file();
  }();
  return kFile;
}

Needs without_heights(Needs needs) {
  needs.max_cpu_bytes = 0;
  Plan plan;
  plan.needs = needs;
  MemoryFile file(cave_world_file());
  needs.max_cpu_bytes = make_plan(file.source(), plan).value();
  return needs;
}

int largest_difference(const Pixels& a, const Pixels& b) {
  int most = 0;
  for (std::size_t n = 0; n < a.rgba.size(); ++n) {
    most = std::max(most, std::abs(int{a.rgba[n]} - int{b.rgba[n]}));
  }
  return a.rgba.size() == b.rgba.size() ? most : 256;
}

double share_beyond(const Pixels& a, const Pixels& b, int most) {
  std::size_t count = 0;
  for (std::size_t n = 0; n + 3 < a.rgba.size(); n += 4) {
    bool differs = false;
    for (std::size_t c = 0; c < 3; ++c) {
      differs = differs || std::abs(int{a.rgba[n + c]} - int{b.rgba[n + c]}) > most;
    }
    count += differs;
  }
  return static_cast<double>(count) / (static_cast<double>(a.rgba.size()) / 4);
}

HostWorld::HostWorld(Needs needs, Placement placement, std::vector<std::byte> bytes,
                     const GroundFunction& ground)
    : file(std::move(bytes)), source(file.source()) {
  plan.needs = needs;
  plan.placement = placement;
  plan.ground = ground;
  const Status planned = make_plan(source, plan);
  EXPECT_TRUE(planned.ok()) << planned.what() << " " << planned.field();
  memory_ = std::make_unique<AlignedBytes>(plan.cpu_bytes);
  const Log lines{[](void* user, Severity, const char* text) {
                    static_cast<std::vector<std::string>*>(user)->push_back(text);
                  },
                  &log};
  const Status made = World::create(plan, source, memory_->bytes(), world, lines);
  EXPECT_TRUE(made.ok()) << made.what() << " " << made.field();
}

HostWorld::~HostWorld() {
  if (world != nullptr) world->destroy();
}

HostPicture::HostPicture(int width, int height, GLenum depth_format) : width_(width), height_(height) {
  Error error;
  display_ = open_headless_display({}, error);
  EXPECT_NE(display_, nullptr) << error.text();
  glGenRenderbuffers(1, &colour_);
  glBindRenderbuffer(GL_RENDERBUFFER, colour_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glGenRenderbuffers(1, &depth_);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_);
  glRenderbufferStorage(GL_RENDERBUFFER, depth_format, width, height);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  EXPECT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
}

HostPicture::~HostPicture() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(1, &colour_);
  glDeleteRenderbuffers(1, &depth_);
}

GlLoader HostPicture::loader() {
  return {[](void* user, const char* name) { return static_cast<Display*>(user)->gl_function(name); },
          display_.get()};
}

void HostPicture::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
}

void HostPicture::use_depth(GLuint texture) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  if (texture != 0) {
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture, 0);
  } else {
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  }
  EXPECT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
}

void HostPicture::clear(float depth, const float (&rgb)[3]) const {
  bind();
  glClearColor(rgb[0], rgb[1], rgb[2], 1);
  glClearDepthf(depth);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

Pixels HostPicture::read() const {
  Pixels pixels{width_, height_, {}};
  pixels.rgba.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
  bind();
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, pixels.rgba.data());
  return pixels;
}

void HostTest::open(Needs needs, Placement placement, GlOptions options, std::vector<std::byte> file,
                    const GroundFunction& ground) {
  close();
  host_ = std::make_unique<HostWorld>(needs, placement, std::move(file), ground);
  ASSERT_NE(host_->world, nullptr);
  const Status status = Renderer::create(*host_->world, picture_.loader(), options, renderer_);
  ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
}

std::size_t HostTest::holes(const ViewState& view, double work_ms, FrameResult& result) {
  constexpr float kMagenta[3] = {1, 0, 1};
  FrameInput input;
  input.views = {&view, 1};
  input.work_ms = work_ms;
  const Status begun = renderer_->begin_frame(input, result);
  EXPECT_TRUE(begun.ok()) << begun.what() << " " << begun.field() << " " << begun.value();
  picture_.clear(1, kMagenta);
  Target target;
  target.viewport = {0, 0, static_cast<int>(view.width_px), static_cast<int>(view.height_px)};
  target.framebuffer = picture_.name();
  target.sky = false;
  picture_.bind();
  EXPECT_TRUE(renderer_->draw(0, target).ok());
  EXPECT_TRUE(renderer_->end_frame().ok());
  const Pixels pixels = picture_.read();
  std::size_t count = 0;
  for (std::size_t n = 0; n < pixels.rgba.size(); n += 4) {
    if (pixels.rgba[n] == 255 && pixels.rgba[n + 1] == 0 && pixels.rgba[n + 2] == 255) ++count;
  }
  return count;
}

void HostTest::close() {
  if (renderer_ != nullptr) renderer_->destroy();
  renderer_ = nullptr;
  host_.reset();
}

ViewState looking(const World& world, Vec3 eye_m, Vec3 target_m, int width, int height) {
  ViewState view;
  view.eye = world.from_world(eye_m);
  view.width_px = static_cast<std::uint32_t>(width);
  view.height_px = static_cast<std::uint32_t>(height);
  const Vec3 top = world.from_world({eye_m.x, eye_m.y + 1, eye_m.z});
  const Vec3 up{top.x - view.eye.x, top.y - view.eye.y, top.z - view.eye.z};
  EXPECT_TRUE(look_at(view, world.from_world(target_m), up));
  set_perspective(view, 60, 1, 2000);
  return view;
}

FrameResult draw_frame(Renderer& renderer, const HostPicture& picture, std::vector<ViewState> views,
                       double work_ms, const Target* target) {
  FrameResult result;
  FrameInput input;
  input.views = views;
  input.work_ms = work_ms;
  const Status begun = renderer.begin_frame(input, result);
  EXPECT_TRUE(begun.ok()) << begun.what() << " " << begun.field();
  for (std::uint32_t n = 0; n < views.size(); ++n) {
    picture.clear(views[n].reversed_depth ? 0.0f : 1.0f);
    Target whole;
    whole.viewport = {0, 0, picture.width(), picture.height()};
    const Status drawn = renderer.draw(n, target != nullptr ? *target : whole);
    EXPECT_TRUE(drawn.ok()) << drawn.what() << " " << drawn.field();
  }
  EXPECT_TRUE(renderer.end_frame().ok());
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  return result;
}

std::vector<std::byte> saved_by(Editor& editor) {
  std::vector<std::byte> out;
  const auto append = [](void* user, std::span<const std::byte> bytes) {
    auto& to = *static_cast<std::vector<std::byte>*>(user);
    to.insert(to.end(), bytes.begin(), bytes.end());
    return true;
  };
  const Status status = editor.save({&out, append});
  EXPECT_TRUE(status.ok()) << status.what();
  return out;
}

}  // namespace karst::test
