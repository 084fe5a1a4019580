// SPDX-License-Identifier: MIT
#include "platform/kms/kms_scanout.h"

#include <drm_fourcc.h>

#include <cassert>
#include <cerrno>
#include <span>
#include <string>
#include <utility>

#include "platform/base/log.h"
#include "platform/kms/pipe/atomic_pipe.h"
#include "platform/kms/pipe/kms_route.h"
#include "platform/kms/pipe/legacy_pipe.h"

namespace karst {
namespace {

std::uint32_t drm_format(ColourFormat format) {
  return format == ColourFormat::rgb565 ? DRM_FORMAT_RGB565 : DRM_FORMAT_XRGB8888;
}

}  // namespace

bool not_master(int error) {
  return error == -EACCES || error == -EPERM;
}

KmsScanout::KmsScanout(const KmsOptions& options, const KmsCard& card, const KmsConnector& connector,
                       ConsoleState& console, KmsLog& log, const EglApi& egl)
    : options_(options),
      card_(card),
      connector_(connector),
      console_(console),
      log_(log),
      context_(egl),
      flips_(swapchain_) {}

Error KmsScanout::open() {
  gbm_.reset(gbm_create_device(card_.fd()));
  if (gbm_ == nullptr) {
    return card_.path() + ": " + errno_text("gbm_create_device", errno != 0 ? errno : ENODEV);
  }
  return open_context();
}

Error KmsScanout::open_context() {
  if (Error error = context_.open(gbm_.get(), drm_format(options_.format)); !error.ok()) {
    return card_.path() + ": " + error.text();
  }
  return {};
}

void KmsScanout::close() {
  forget();
  context_.close();
  pipe_ = nullptr;
  atomic_.reset();
  legacy_.reset();
  gbm_.reset();
  plan_.clear();
}

void KmsScanout::forget() {
  flips_.clear();
  context_.drop_surface();
  swapchain_.destroy();
}

Error KmsScanout::open_pipes() {
  pipe_ = nullptr;
  atomic_.reset();
  legacy_.reset();
  KmsRoute route;
  if (Error error = choose_route(card_, connector_, route); !error.ok()) return error;
  if (options_.atomic && card_.atomic()) {
    if (Error error = open_atomic_pipe(route, drm_format(options_.format), atomic_); !error.ok()) {
      if (!options_.legacy) return error;
      log_.tell(card_.path() + ": " + error.text() + "; using the legacy calls");
    }
  }
  if (options_.legacy) legacy_ = make_legacy_pipe(route);
  save_crtc(route, card_, console_);
  return {};
}

Error KmsScanout::configure(std::size_t mode) {
  forget();
  plan_.clear();
  if (Error error = open_pipes(); !error.ok()) return card_.path() + ": " + error.text();
  if (!console_.crtc_taken.load()) {
    log_.tell(card_.path() +
              ": what the screen shows cannot be read (drmModeGetCrtc), so it is not given back");
  }
  if (!card_.lacks().empty()) log_.say(card_.path() + ": " + card_.lacks());
  AttemptLimits limits;
  limits.atomic = atomic_ != nullptr;
  limits.legacy = legacy_ != nullptr;
  limits.modifiers =
      options_.modifiers && card_.modifiers() && atomic_ != nullptr && !atomic_->modifiers().empty();
  limits.lower_modes = options_.mode.kind != ModeRequest::Kind::exact || options_.mode_fallback;
  plan_.start(connector_.modes, mode, limits);
  if (plan_.empty()) {
    return card_.path() + ": the driver has no atomic calls, and the legacy ones are off";
  }
  return {};
}

bool KmsScanout::try_attempts() {
  for (; !plan_.over(); plan_.advance()) {
    pipe_ = plan_.attempt().atomic ? atomic_.get() : legacy_.get();
    const int turns = options_.quarter_turns & 3;
    if (turns != 0 && pipe_->can_turn(turns)) {
      const Error error = set_up(turns);
      if (error.ok()) return true;
      log_.tell(connector_.name + " " + plan_.text() + ": the plane cannot turn it: " + error.text());
    }
    const Error error = set_up(0);
    if (error.ok()) return true;
    log_.tell(connector_.name + " " + plan_.text() + ": " + error.text() +
              (plan_.has_next() ? "; trying the next way" : ""));
  }
  forget();
  return false;
}

Error KmsScanout::set_up(int plane_turns) {
  forget();
  mode_ = plan_.mode();
  plane_turns_ = plane_turns;
  context_turns_ = (options_.quarter_turns - plane_turns) & 3;
  std::uint32_t width = mode_.hdisplay;
  std::uint32_t height = mode_.vdisplay;
  if ((plane_turns & 1) != 0) std::swap(width, height);
  const std::span<const std::uint64_t> none;
  Error error = swapchain_.create(gbm_.get(), card_.fd(), width, height, drm_format(options_.format),
                                  plan_.attempt().modifiers ? pipe_->modifiers() : none);
  if (error.ok() && pipe_->can_test()) {
    error = test();
    swapchain_.drop_probe();
  }
  if (error.ok()) error = context_.set_surface(swapchain_.surface());
  return error;
}

// Whether the driver would take a picture of the swapchain's.
Error KmsScanout::test() {
  KmsPicture probe{0, swapchain_.width(), swapchain_.height(), plane_turns_};
  if (Error error = swapchain_.make_probe(probe.framebuffer); !error.ok()) return error;
  const int refused = pipe_->test(mode_, probe);
  if (refused == 0) return {};
  const std::string text = errno_text("TEST_ONLY commit", refused);
  if (!not_master(refused)) return text;
  log_.say(connector_.name + ": " + text + "; the first frame will tell");
  return {};
}

int KmsScanout::set_mode(int slot) {
  assert(pipe_ != nullptr);
  return pipe_->set_mode(mode_, picture(slot));
}

int KmsScanout::flip(int slot, void* user) {
  assert(pipe_ != nullptr);
  return pipe_->flip(picture(slot), user);
}

}  // namespace karst
