// SPDX-License-Identifier: MIT
// A host program for tests of the public headers: a world in memory, a context without a screen, a
// framebuffer.
#pragma once

#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "karst/inspect.h"
#include "karst/karst.h"
#include "platform/display.h"
#include "tests/support/test_world.h"

namespace karst::test {

// Bytes of a .karst file as a Source; counts reads, and fails them when it is told to.
class MemoryFile {
 public:
  explicit MemoryFile(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  Source source();
  std::uint64_t reads() const { return reads_; }
  bool fails = false;

 private:
  std::vector<std::byte> bytes_;
  std::atomic<std::uint64_t> reads_ = 0;
};

// Hills with a cave through them, roughened: 40 x 24 x 36 voxels of 1 m.
std::vector<std::byte> cave_world_file();
// The same needs with the least memory that this world can do with: heights are read when they are wanted.
Needs without_heights(Needs needs);

struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // row 0 at the bottom

  const std::uint8_t* at(int x, int y) const {
    return rgba.data() +
           4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};
// Largest difference of any byte, and the share of pixels that differ by more than `most`.
int largest_difference(const Pixels& a, const Pixels& b);
double share_beyond(const Pixels& a, const Pixels& b, int most);

// World and memory.
class HostWorld {
 public:
  explicit HostWorld(Needs needs = {}, Placement placement = {},
                     std::vector<std::byte> file = cave_world_file(), const GroundFunction& ground = {});
  ~HostWorld();
  HostWorld(const HostWorld&) = delete;
  HostWorld& operator=(const HostWorld&) = delete;

  MemoryFile file;
  Source source;
  Plan plan;
  World* world = nullptr;
  std::vector<std::string> log;

 private:
  std::unique_ptr<AlignedBytes> memory_;
};

// A context of OpenGL ES 3.0 and a framebuffer in it; row 0 at the bottom.
class HostPicture {
 public:
  HostPicture(int width, int height, GLenum depth_format = GL_DEPTH_COMPONENT24);
  ~HostPicture();
  HostPicture(const HostPicture&) = delete;
  HostPicture& operator=(const HostPicture&) = delete;

  GlLoader loader();
  GLuint name() const { return framebuffer_; }
  void bind() const;
  // Has this as its depth instead of its own; 0: its own again.
  void use_depth(GLuint texture) const;
  void clear(float depth = 1, const float (&rgb)[3] = {0, 0, 0}) const;
  Pixels read() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  std::unique_ptr<Display> display_;
  int width_;
  int height_;
  GLuint colour_ = 0;
  GLuint depth_ = 0;
  GLuint framebuffer_ = 0;
};

// A world, a picture and a renderer, which open() makes anew.
class HostTest : public testing::Test {
 protected:
  HostTest(int width, int height) : picture_(width, height) {}
  void TearDown() override { close(); }
  void open(Needs needs = {}, Placement placement = {}, GlOptions options = {},
            std::vector<std::byte> file = cave_world_file(), const GroundFunction& ground = {});
  void close();
  // A frame over magenta, without the sky. Pixels that show it: where one looks through the terrain.
  std::size_t holes(const ViewState& view, double work_ms, FrameResult& result);

  HostPicture picture_;
  std::unique_ptr<HostWorld> host_;
  Renderer* renderer_ = nullptr;
};

// What Editor::save writes.
std::vector<std::byte> saved_by(Editor& editor);

// A camera in the world's own axes, and the same in the frame of a placement: east_up_south from (x, y, z)
// towards a target.
ViewState looking(const World& world, Vec3 eye_m, Vec3 target_m, int width, int height);

// A whole frame of views of the picture's size into it, drawn one over the other; no GL error.
FrameResult draw_frame(Renderer& renderer, const HostPicture& picture, std::vector<ViewState> views,
                       double work_ms = 0, const Target* target = nullptr);

}  // namespace karst::test
