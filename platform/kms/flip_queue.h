// SPDX-License-Identifier: MIT
// Which of a swapchain's buffers is on the screen, which is on its way there, and until when the driver has
// to say so.
#pragma once

#include <cassert>
#include <cstdint>
#include <utility>

#include "platform/kms/gbm/swapchain.h"

namespace karst {

class FlipQueue {
 public:
  static constexpr int kNone = Swapchain::kNone;

  // The swapchain must outlive the queue. Buffers that are not needed any more are given back to it.
  explicit FlipQueue(Swapchain& swapchain) : swapchain_(swapchain) {}

  int on_screen() const { return on_screen_; }
  bool pending() const { return pending_ != kNone; }  // handed to the kernel
  bool waiting() const { return waiting_ != kNone; }  // drawn, behind the pending one; with three buffers
  // When the pending one counts as lost, on the clock of now_ns().
  std::int64_t deadline_ns() const { return deadline_ns_; }

  void queued(int slot, std::int64_t deadline_ns) {
    assert(!pending());
    pending_ = slot;
    deadline_ns_ = deadline_ns;
  }
  void wait(int slot) {
    assert(pending() && !waiting());
    waiting_ = slot;
  }
  int take_waiting() { return std::exchange(waiting_, kNone); }

  // A mode was set with this buffer.
  void set(int slot) { swapchain_.release(std::exchange(on_screen_, slot)); }
  // The pending one is on the screen.
  void flipped() { set(std::exchange(pending_, kNone)); }
  // The driver has lost the pending one.
  void lost() {
    swapchain_.release(std::exchange(waiting_, kNone));
    swapchain_.release(std::exchange(pending_, kNone));
  }
  // The swapchain is about to be destroyed.
  void clear() { on_screen_ = pending_ = waiting_ = kNone; }

 private:
  Swapchain& swapchain_;
  int on_screen_ = kNone;
  int pending_ = kNone;
  int waiting_ = kNone;
  std::int64_t deadline_ns_ = 0;
};

}  // namespace karst
