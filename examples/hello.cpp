// SPDX-License-Identifier: MIT
// hello WORLD.karst PICTURE.ppm: the least that draws terrain. No window is needed.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <fcntl.h>
#include <karst/karst.h>
#include <unistd.h>

static constexpr int kWidth = 960, kHeight = 540;

static void check(karst::Status status) {
  if (status.ok()) return;
  std::fprintf(stderr, "hello: %s (%s)\n", status.what(), status.field());
  std::exit(1);
}
static bool read_file(void* fd, std::uint64_t offset, std::byte* out, std::size_t count) {
  return pread(*static_cast<int*>(fd), out, count, static_cast<off_t>(offset)) == static_cast<ssize_t>(count);
}
static void (*load_gl(void*, const char* name))() {
  return eglGetProcAddress(name);
}

// A context of OpenGL ES 3.0 and a framebuffer with colour and depth, as any program that embeds karst has
// them.
static GLuint make_framebuffer() {
  const EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
  const EGLint es3[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
  if (!eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_ES_API)) std::exit(1);
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, es3);
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) std::exit(1);
  GLuint framebuffer = 0, buffers[2] = {};
  glGenFramebuffers(1, &framebuffer);
  glGenRenderbuffers(2, buffers);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  for (const unsigned depth : {0u, 1u}) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffers[depth]);
    glRenderbufferStorage(GL_RENDERBUFFER, depth ? GL_DEPTH_COMPONENT24 : GL_RGBA8, kWidth, kHeight);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, depth ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0,
                              GL_RENDERBUFFER, buffers[depth]);
  }
  return framebuffer;
}

int main(int argc, char** argv) {
  int fd = argc == 3 ? open(argv[1], O_RDONLY) : -1;
  if (fd < 0) return std::fprintf(stderr, "usage: hello WORLD.karst PICTURE.ppm\n"), 2;
  const karst::Source file{static_cast<std::uint64_t>(lseek(fd, 0, SEEK_END)), read_file, &fd};

  karst::Plan plan;  // what it will take; nothing is taken yet
  check(karst::make_plan(file, plan));
  std::byte* memory = static_cast<std::byte*>(std::aligned_alloc(karst::kMemoryAlignment, plan.cpu_bytes));
  karst::World* world = nullptr;
  check(karst::World::create(plan, file, {memory, plan.cpu_bytes}, world));
  const GLuint framebuffer = make_framebuffer();
  karst::Renderer* renderer = nullptr;
  check(karst::Renderer::create(*world, {load_gl, nullptr}, {}, renderer));

  // From above the south-west corner to the middle of the ground; x is east, y north, z up.
  const karst::Vec3 low = world->from_world(world->info().low_m),
                    high = world->from_world(world->info().high_m);
  karst::ViewState view;
  view.width_px = kWidth;
  view.height_px = kHeight;
  view.eye = {low.x, std::min(low.y, high.y), high.z + 0.2 * (high.x - low.x)};
  karst::look_at(view, {(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2}, {0, 0, 1});
  karst::set_perspective(view, 50, 0.5, 20e3);
  karst::FrameResult result;
  for (int frame = 0; frame < 100 && !result.complete; ++frame) {
    check(renderer->begin_frame({.views = {&view, 1}}, result));
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClear(GL_DEPTH_BUFFER_BIT);
    check(renderer->draw(0, {.viewport = {0, 0, kWidth, kHeight}}));
    check(renderer->end_frame());  // leaves framebuffer 0 bound
  }
  std::printf("%llu triangles, no point further than %.1f pixels from the full surface\n",
              static_cast<unsigned long long>(result.triangles), result.error_px[0]);

  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  std::vector<unsigned char> rgba(4 * kWidth * kHeight);
  glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  std::FILE* picture = std::fopen(argv[2], "wb");
  if (picture == nullptr) return 1;
  std::fprintf(picture, "P6 %d %d 255\n", kWidth, kHeight);
  for (int y = kHeight - 1; y >= 0; --y) {
    for (int x = 0; x < kWidth; ++x)
      std::fwrite(&rgba[4 * static_cast<unsigned>(y * kWidth + x)], 1, 3, picture);
  }
  renderer->destroy();
  world->destroy();
  std::free(memory);
  return std::fclose(picture) == 0 ? 0 : 1;
}
