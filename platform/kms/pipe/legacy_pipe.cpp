// SPDX-License-Identifier: MIT
// Sources: the kernel's drm_mode.h.
#include "platform/kms/pipe/legacy_pipe.h"

#include <xf86drm.h>

namespace karst {
namespace {

class LegacyPipe final : public KmsPipe {
 public:
  explicit LegacyPipe(const KmsRoute& route) : route_(route) {}

  std::span<const std::uint64_t> modifiers() const override { return {}; }
  bool can_turn(int) const override { return false; }
  bool can_test() const override { return false; }
  int test(const drmModeModeInfo&, const KmsPicture&) override { return 0; }
  int set_mode(const drmModeModeInfo& mode, const KmsPicture& picture) override {
    drmModeModeInfo copy = mode;  // libdrm's parameters are not const
    std::uint32_t connector = route_.connector;
    return drmModeSetCrtc(route_.fd, route_.crtc, picture.framebuffer, 0, 0, &connector, 1, &copy);
  }
  const char* set_mode_text() const override { return "drmModeSetCrtc"; }
  int flip(const KmsPicture& picture, void* user) override {
    return drmModePageFlip(route_.fd, route_.crtc, picture.framebuffer, DRM_MODE_PAGE_FLIP_EVENT, user);
  }

 private:
  KmsRoute route_;
};

}  // namespace

std::unique_ptr<KmsPipe> make_legacy_pipe(const KmsRoute& route) {
  return std::make_unique<LegacyPipe>(route);
}

}  // namespace karst
