// SPDX-License-Identifier: MIT
// simulator WORLD.karst PICTURE.ppm [FRAMES]: what a driving simulator does with karst. Two views in one
// framebuffer, behind the car and from above; the car is the simulator's own, in the same depth buffer, under
// the same sun, and casts into karst's shadow maps; its wheels ask for the ground 1000 times a second, on a
// thread of their own. Without a window: the last frame is written as a picture.
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <GLES3/gl3.h>
#include <fcntl.h>
#include <karst/karst.h>
#include <unistd.h>

#include "context.h"
#include "painter.h"
#include "vehicle.h"

namespace simulator {
namespace {

constexpr int kWidth = 960, kHeight = 360;  // of both views together
constexpr karst::Vec3 kUp{0, 0, 1};         // Axes::east_north_up
constexpr std::size_t kBoxes = 1 + kWheels;

bool read_file(void* fd, std::uint64_t offset, std::byte* out, std::size_t count) {
  return pread(*static_cast<int*>(fd), out, count, static_cast<off_t>(offset)) == static_cast<ssize_t>(count);
}

void log_line(void*, karst::Severity severity, const char* text) {
  if (severity != karst::Severity::note) std::fprintf(stderr, "simulator: karst: %s\n", text);
}

bool succeeded(karst::Status status) {
  if (!status.ok()) {
    std::fprintf(stderr, "simulator: %s (%s, %llu)\n", status.what(), status.field(),
                 static_cast<unsigned long long>(status.value()));
  }
  return status.ok();
}

struct FreeMemory {
  void operator()(std::byte* memory) const { std::free(memory); }
};
struct DestroyWorld {
  void operator()(karst::World* world) const { world->destroy(); }
};
struct DestroyRenderer {
  void operator()(karst::Renderer* renderer) const { renderer->destroy(); }
};

// The car as the painter wants it.
void make_boxes(const CarState& car, Box (&boxes)[kBoxes]) {
  boxes[0] = {car.body, {2.1, 0.8, 0.4}, {0.5f, 0.05f, 0.04f}};
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    boxes[1 + wheel] = {car.wheels[wheel], {kWheelRadius_m, 0.12, kWheelRadius_m}, {0.04f, 0.04f, 0.04f}};
  }
}

void make_views(const CarState& car, karst::ViewState (&views)[2]) {
  const Mat4& body = car.body;
  const Vec3 place{body[12], body[13], body[14]}, forwards = unit({body[0], body[1], 0});
  for (karst::ViewState& view : views) {
    view.width_px = kWidth / 2;
    view.height_px = kHeight;
    karst::set_perspective(view, 55, 0.5, 20e3);
  }
  views[0].eye = place + -9 * forwards + 3.5 * kUp;
  karst::look_at(views[0], place + kUp, kUp);
  views[1].eye = place + 30 * kUp;
  karst::look_at(views[1], place, forwards);
  views[1].weight = 0.5;  // where memory is short, the view from above is the coarser one
}

struct Casters {
  const Painter* painter;
  std::span<const Box> boxes;
};
void draw_casters(void* user, const double clip_from_world[16], Vec3 eye) {
  const auto* casters = static_cast<const Casters*>(user);
  double matrix[16];
  for (int i = 0; i < 16; ++i) matrix[i] = clip_from_world[i];
  casters->painter->cast(matrix, eye, casters->boxes);
}

bool draw_frame(karst::Renderer& renderer, const Context& context, const Painter& painter, const Car& car,
                karst::FrameResult& result) {
  const CarState state = car.state();
  Box boxes[kBoxes];
  make_boxes(state, boxes);
  karst::ViewState views[2];
  make_views(state, views);

  Casters casters{&painter, boxes};
  karst::FrameInput input;
  input.views = views;
  input.draw_casters = draw_casters;
  input.user = &casters;
  if (!succeeded(renderer.begin_frame(input, result))) return false;
  const karst::Air air = renderer.air(0);
  context.begin(air.horizon_display_rgb);
  for (unsigned i = 0; i < 2; ++i) {
    const karst::Rect half{static_cast<int>(i) * kWidth / 2, 0, kWidth / 2, kHeight};
    if (!succeeded(renderer.draw(i, {.viewport = half}))) return false;
    glViewport(half.x, half.y, half.width, half.height);
    painter.draw(views[i], renderer.air(i), boxes);
  }
  return succeeded(renderer.end_frame());
}

int run(int fd, const char* picture, int frames) {
  const karst::Source file{static_cast<std::uint64_t>(lseek(fd, 0, SEEK_END)), read_file, &fd};
  karst::Plan plan;
  plan.needs.views = 2;
  plan.needs.queries = 1;
  if (!succeeded(karst::make_plan(file, plan))) return 1;
  std::printf("%.1f MiB of memory and %.1f MiB of the GPU's\n",
              static_cast<double>(plan.cpu_bytes) / (1 << 20),
              static_cast<double>(plan.gpu_bytes) / (1 << 20));
  const std::unique_ptr<std::byte, FreeMemory> memory(
      static_cast<std::byte*>(std::aligned_alloc(karst::kMemoryAlignment, plan.cpu_bytes)));
  karst::World* made = nullptr;
  if (!succeeded(karst::World::create(plan, file, {memory.get(), plan.cpu_bytes}, made, {log_line, nullptr})))
    return 1;
  const std::unique_ptr<karst::World, DestroyWorld> world(made);

  Context context;
  Painter painter;
  if (!context.open(kWidth, kHeight)) return 1;
  karst::Renderer* drawer = nullptr;
  if (!succeeded(karst::Renderer::create(*world, {Context::load, nullptr}, {}, drawer))) return 1;
  const std::unique_ptr<karst::Renderer, DestroyRenderer> renderer(drawer);
  if (!painter.create()) return 1;

  karst::Query* query = nullptr;
  if (!succeeded(world->take_query(query))) return 1;
  const karst::Vec3 low = world->info().low_m, high = world->info().high_m;
  const Vec3 middle = world->from_world({(low.x + high.x) / 2, high.y, (low.z + high.z) / 2});
  Car car;
  if (!car.start(*query, static_cast<int>(world->plan().needs.query_level), middle)) {
    std::fprintf(stderr, "simulator: there is no ground in the middle of the world\n");
    return 1;
  }
  karst::FrameResult result;
  bool drawn = true;
  for (int frame = 0; frame < frames && drawn; ++frame) {
    drawn = draw_frame(*renderer, context, painter, car, result);
  }
  const CarReport report = car.stop();
  world->release(query);
  std::printf("%d frames; the last: %llu triangles, errors of %.1f and %.1f pixels\n", frames,
              static_cast<unsigned long long>(result.triangles), result.error_px[0], result.error_px[1]);
  std::printf(
      "%llu steps of the car, the slowest %.0f us; wheels on the ground %.1f %%, %llu answers coarse\n",
      static_cast<unsigned long long>(report.steps), report.slowest_step_us,
      100.0 * static_cast<double>(report.wheels_on_ground) / static_cast<double>(kWheels * report.steps),
      static_cast<unsigned long long>(report.coarse_answers));
  return drawn && context.write(picture) && glGetError() == GL_NO_ERROR ? 0 : 1;
}

}  // namespace
}  // namespace simulator

int main(int argc, char** argv) {
  const int fd = argc == 3 || argc == 4 ? open(argv[1], O_RDONLY | O_CLOEXEC) : -1;
  if (fd < 0) {
    std::fprintf(stderr, "usage: simulator WORLD.karst PICTURE.ppm [FRAMES]\n");
    return 2;
  }
  return simulator::run(fd, argv[2], argc == 4 ? std::atoi(argv[3]) : 100);
}
