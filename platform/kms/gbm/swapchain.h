// SPDX-License-Identifier: MIT
// The buffers that the GPU draws and the screen shows, each tracked from the swap that fills it to the flip
// that replaces it. GBM makes them, EGL draws into them; here is which of them is where.
#pragma once

#include <gbm.h>

#include <array>
#include <cassert>
#include <cstdint>
#include <span>

#include "platform/base/error.h"

namespace karst {

class Swapchain {
 public:
  static constexpr int kNone = -1;
  static constexpr std::size_t kMost = 4;  // what Mesa's surfaces hold

  Swapchain() = default;
  Swapchain(const Swapchain&) = delete;
  Swapchain& operator=(const Swapchain&) = delete;
  ~Swapchain() { destroy(); }

  // modifiers: layouts to choose from, empty: the driver's own choice without naming it.
  Error create(gbm_device* device, int drm_fd, std::uint32_t width, std::uint32_t height,
               std::uint32_t format, std::span<const std::uint64_t> modifiers);
  // The EGL surface on surface() must be gone.
  void destroy();

  gbm_surface* surface() const { return surface_; }
  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }

  // Takes the buffer that eglSwapBuffers finished. slot is its place; kNone on an error.
  Error take_front(int& slot);
  // slot: of take_front().
  std::uint32_t framebuffer(int slot) const {
    assert(slot >= 0 && static_cast<std::size_t>(slot) < kMost);
    return slots_[static_cast<std::size_t>(slot)].framebuffer;
  }
  // Gives a buffer back for drawing; kNone is no buffer.
  void release(int slot);
  bool has_free() const { return surface_ != nullptr && gbm_surface_has_free_buffers(surface_) != 0; }

  // A framebuffer for testing, of the same size, format and layout; removed with the next call or destroy().
  Error make_probe(std::uint32_t& framebuffer);
  void drop_probe();

 private:
  struct Slot {
    gbm_bo* bo = nullptr;
    std::uint32_t framebuffer = 0;
    bool taken = false;  // queued or on the screen
  };

  Error add_framebuffer(gbm_bo* bo, std::uint32_t& framebuffer) const;

  gbm_device* device_ = nullptr;
  int drm_fd_ = -1;
  gbm_surface* surface_ = nullptr;
  std::uint32_t width_ = 0;
  std::uint32_t height_ = 0;
  std::uint32_t format_ = 0;
  std::array<std::uint64_t, 32> modifiers_{};
  std::size_t modifier_count_ = 0;
  std::array<Slot, kMost> slots_{};
  gbm_bo* probe_ = nullptr;
  std::uint32_t probe_framebuffer_ = 0;
};

}  // namespace karst
