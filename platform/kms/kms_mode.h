// SPDX-License-Identifier: MIT
// Display modes: what a user asks for, which of a connector's modes that is, and what to try when the driver
// refuses it. No device is touched here.
#pragma once

#include <xf86drmMode.h>

#include <cassert>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/error.h"

namespace karst {

struct ModeRequest {
  enum class Kind { preferred, highest, exact };
  Kind kind = Kind::preferred;
  int width = 0;  // of exact, pixels
  int height = 0;
  double refresh_hz = 0;  // of exact; 0: any
};

inline constexpr std::size_t kNoMode = SIZE_MAX;

// "preferred", "highest", "1920x1080" or "1920x1080@59.94". The error names what.
Error parse_mode(std::string_view text, std::string_view what, ModeRequest& request);

// Refreshes a second, from the mode's timing: vrefresh is rounded and 0 in some drivers.
double refresh_hz(const drmModeModeInfo& mode);
// "1920x1080@59.94".
std::string mode_text(const drmModeModeInfo& mode);
bool same_mode(const drmModeModeInfo& a, const drmModeModeInfo& b);

// Index of the mode that the request means, kNoMode where there is none. preferred: the first mode that the
// monitor prefers, else the first. highest: most pixels, then most refreshes. exact: the size, and the
// refresh nearest to the one that is asked for, within 0.5 Hz; without one, the first mode of that size, as
// drivers list the better ones first.
std::size_t choose_mode(std::span<const drmModeModeInfo> modes, const ModeRequest& request);

// One way to bring a picture to the screen.
struct KmsAttempt {
  std::size_t mode = 0;    // index into the connector's modes
  bool atomic = true;      // else the legacy calls
  bool modifiers = false;  // buffers laid out as the plane says it likes best
};
std::string attempt_text(const KmsAttempt& attempt, std::span<const drmModeModeInfo> modes);

struct AttemptLimits {
  bool atomic = true;
  bool legacy = true;
  bool modifiers = true;
  bool lower_modes = true;
};
// What to try, in order: with modifiers, without, modes with fewer pixels (largest first, each size once),
// then the legacy calls for the same modes.
std::vector<KmsAttempt> plan_attempts(std::span<const drmModeModeInfo> modes, std::size_t first,
                                      const AttemptLimits& limits);

// The attempts of one connector, and which of them is made.
class KmsPlan {
 public:
  // first: index of the mode that is wanted. The first attempt is the current one.
  void start(std::vector<drmModeModeInfo> modes, std::size_t first, const AttemptLimits& limits);
  void clear();

  bool empty() const { return attempts_.empty(); }  // nothing is planned
  bool over() const { return at_ == attempts_.size(); }
  bool has_next() const { return at_ + 1 < attempts_.size(); }
  void advance() { ++at_; }
  // Of the current attempt; not when over().
  const KmsAttempt& attempt() const {
    assert(!over());
    return attempts_[at_];
  }
  const drmModeModeInfo& mode() const { return modes_[attempt().mode]; }
  std::string text() const { return attempt_text(attempt(), modes_); }

  // Whether the mode is what was asked for; a lower one may be shown, because the driver refused it.
  bool wants(const drmModeModeInfo& mode) const { return !empty() && same_mode(mode, wanted_); }

 private:
  std::vector<drmModeModeInfo> modes_;
  std::vector<KmsAttempt> attempts_;
  drmModeModeInfo wanted_{};
  std::size_t at_ = 0;
};

}  // namespace karst
