// SPDX-License-Identifier: MIT
// One card's way from GL to the screen: a context, the buffers that it draws, and the pipe that shows them,
// set up for one of the planned attempts at a time. Decides nothing about what a failure means for the
// display.
#pragma once

#include <gbm.h>

#include <cstdint>
#include <memory>

#include "platform/base/error.h"
#include "platform/egl_api.h"
#include "platform/kms/card/kms_card.h"
#include "platform/kms/flip_queue.h"
#include "platform/kms/gbm/gbm_context.h"
#include "platform/kms/gbm/swapchain.h"
#include "platform/kms/kms_log.h"
#include "platform/kms/kms_mode.h"
#include "platform/kms/kms_options.h"
#include "platform/kms/pipe/kms_pipe.h"
#include "platform/seat/console_state.h"

namespace karst {

// Whether a negative errno says that another program has the screen.
bool not_master(int error);

class KmsScanout {
 public:
  // All must outlive this. card and connector are looked at when something is opened or set up on them.
  KmsScanout(const KmsOptions& options, const KmsCard& card, const KmsConnector& connector,
             ConsoleState& console, KmsLog& log, const EglApi& egl);

  // A context on the open card. A context that was lost is opened anew by the second.
  Error open();
  Error open_context();
  void close();
  GbmContext& context() { return context_; }
  const GbmContext& context() const { return context_; }

  // Opens the pipes to the connector and plans how to show its mode; try_attempts() comes next.
  Error configure(std::size_t mode);
  // From the current attempt on, sets up the first that the driver takes. False where there is none.
  bool try_attempts();
  KmsPlan& plan() { return plan_; }
  const KmsPlan& plan() const { return plan_; }

  // Of the attempt that is set up.
  bool has_surface() const { return swapchain_.surface() != nullptr; }
  std::uint32_t width() const { return swapchain_.width(); }
  std::uint32_t height() const { return swapchain_.height(); }
  const drmModeModeInfo& mode() const { return mode_; }
  int plane_turns() const { return plane_turns_; }
  int context_turns() const { return context_turns_; }

  Swapchain& swapchain() { return swapchain_; }
  const Swapchain& swapchain() const { return swapchain_; }
  FlipQueue& flips() { return flips_; }
  const FlipQueue& flips() const { return flips_; }

  // As those of KmsPipe, with the picture in a buffer of the swapchain.
  int set_mode(int slot);
  const char* set_mode_text() const { return pipe_->set_mode_text(); }
  int flip(int slot, void* user);

  // Gives up the buffers and what they are on; the context stays.
  void forget();

 private:
  struct GbmFree {
    void operator()(gbm_device* device) const { gbm_device_destroy(device); }
  };

  Error open_pipes();
  Error set_up(int plane_turns);
  Error test();
  KmsPicture picture(int slot) const {
    return {swapchain_.framebuffer(slot), swapchain_.width(), swapchain_.height(), plane_turns_};
  }

  const KmsOptions& options_;
  const KmsCard& card_;
  const KmsConnector& connector_;
  ConsoleState& console_;
  KmsLog& log_;

  std::unique_ptr<gbm_device, GbmFree> gbm_;
  GbmContext context_;   // on gbm_
  Swapchain swapchain_;  // on gbm_, under context_'s surface
  FlipQueue flips_;
  std::unique_ptr<KmsPipe> atomic_;  // null: the driver cannot, or may not
  std::unique_ptr<KmsPipe> legacy_;
  KmsPipe* pipe_ = nullptr;  // the one of these that is used
  KmsPlan plan_;

  drmModeModeInfo mode_{};
  int plane_turns_ = 0;
  int context_turns_ = 0;
};

}  // namespace karst
