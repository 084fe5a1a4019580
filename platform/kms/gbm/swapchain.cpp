// SPDX-License-Identifier: MIT
#include "platform/kms/gbm/swapchain.h"

#include <drm_fourcc.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <cerrno>

#include "platform/base/log.h"

namespace karst {
namespace {

constexpr std::uint32_t kUse = GBM_BO_USE_SCANOUT | GBM_BO_USE_RENDERING;

}  // namespace

Error Swapchain::create(gbm_device* device, int drm_fd, std::uint32_t width, std::uint32_t height,
                        std::uint32_t format, std::span<const std::uint64_t> modifiers) {
  destroy();
  device_ = device;
  drm_fd_ = drm_fd;
  width_ = width;
  height_ = height;
  format_ = format;
  modifier_count_ = std::min(modifiers.size(), modifiers_.size());
  std::copy_n(modifiers.begin(), modifier_count_, modifiers_.begin());
  errno = 0;
  if (modifier_count_ > 0) {
    surface_ = gbm_surface_create_with_modifiers2(device, width, height, format, modifiers_.data(),
                                                  static_cast<unsigned>(modifier_count_), kUse);
  } else {
    surface_ = gbm_surface_create(device, width, height, format, kUse);
  }
  if (surface_ == nullptr) return errno_text("gbm_surface_create", errno != 0 ? errno : EINVAL);
  return {};
}

void Swapchain::destroy() {
  drop_probe();
  for (Slot& slot : slots_) {
    if (slot.taken) gbm_surface_release_buffer(surface_, slot.bo);
    if (slot.framebuffer != 0) drmModeRmFB(drm_fd_, slot.framebuffer);
    slot = {};
  }
  if (surface_ != nullptr) gbm_surface_destroy(surface_);
  surface_ = nullptr;
}

Error Swapchain::take_front(int& slot) {
  slot = kNone;
  errno = 0;
  gbm_bo* bo = gbm_surface_lock_front_buffer(surface_);
  if (bo == nullptr) return errno_text("gbm_surface_lock_front_buffer", errno != 0 ? errno : ENOMEM);
  std::size_t found = slots_.size();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].bo == bo) {
      found = i;
      break;
    }
    if (slots_[i].bo == nullptr) found = std::min(found, i);
  }
  Error error;
  if (found == slots_.size()) {
    error = "the driver uses more buffers than it needs";
  } else if (slots_[found].bo == nullptr) {
    error = add_framebuffer(bo, slots_[found].framebuffer);
  }
  if (!error.ok()) {
    gbm_surface_release_buffer(surface_, bo);
    return error;
  }
  slots_[found].bo = bo;
  slots_[found].taken = true;
  slot = static_cast<int>(found);
  return {};
}

void Swapchain::release(int slot) {
  if (slot == kNone) return;
  Slot& entry = slots_[static_cast<std::size_t>(slot)];
  if (!entry.taken) return;
  entry.taken = false;
  gbm_surface_release_buffer(surface_, entry.bo);
}

Error Swapchain::add_framebuffer(gbm_bo* bo, std::uint32_t& framebuffer) const {
  std::uint32_t handles[4] = {};
  std::uint32_t strides[4] = {};
  std::uint32_t offsets[4] = {};
  std::uint64_t modifiers[4] = {};
  const int planes = std::min(gbm_bo_get_plane_count(bo), 4);
  const std::uint64_t modifier = gbm_bo_get_modifier(bo);
  for (int i = 0; i < planes; ++i) {
    handles[i] = gbm_bo_get_handle_for_plane(bo, i).u32;
    strides[i] = gbm_bo_get_stride_for_plane(bo, i);
    offsets[i] = gbm_bo_get_offset(bo, i);
    modifiers[i] = modifier;
  }
  if (planes < 1) {
    handles[0] = gbm_bo_get_handle(bo).u32;
    strides[0] = gbm_bo_get_stride(bo);
  }
  const std::uint32_t width = gbm_bo_get_width(bo);
  const std::uint32_t height = gbm_bo_get_height(bo);
  const bool named = modifier_count_ > 0 && modifier != DRM_FORMAT_MOD_INVALID;
  const int failed =
      named ? drmModeAddFB2WithModifiers(drm_fd_, width, height, format_, handles, strides, offsets,
                                         modifiers, &framebuffer, DRM_MODE_FB_MODIFIERS)
            : drmModeAddFB2(drm_fd_, width, height, format_, handles, strides, offsets, &framebuffer, 0);
  if (failed != 0) return errno_text("drmModeAddFB2", failed);
  return {};
}

Error Swapchain::make_probe(std::uint32_t& framebuffer) {
  drop_probe();
  errno = 0;
  probe_ = modifier_count_ > 0
               ? gbm_bo_create_with_modifiers2(device_, width_, height_, format_, modifiers_.data(),
                                               static_cast<unsigned>(modifier_count_), kUse)
               : gbm_bo_create(device_, width_, height_, format_, kUse);
  if (probe_ == nullptr) return errno_text("gbm_bo_create", errno != 0 ? errno : EINVAL);
  Error error = add_framebuffer(probe_, probe_framebuffer_);
  framebuffer = probe_framebuffer_;
  return error;
}

void Swapchain::drop_probe() {
  if (probe_framebuffer_ != 0) drmModeRmFB(drm_fd_, probe_framebuffer_);
  if (probe_ != nullptr) gbm_bo_destroy(probe_);
  probe_framebuffer_ = 0;
  probe_ = nullptr;
}

}  // namespace karst
