// SPDX-License-Identifier: MIT
#include "platform/kms/kms_mode.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "platform/base/text.h"

namespace karst {
namespace {

constexpr int kMostPixels = 16384;      // a side; drivers refuse such modes long before
constexpr double kSameRefreshHz = 0.5;  // 59.94 is what a user means by 60 where there is no 60
constexpr std::size_t kMostLowerModes = 8;

std::int64_t pixels(const drmModeModeInfo& mode) {
  return std::int64_t{mode.hdisplay} * mode.vdisplay;
}

template <class T>
bool read(std::string_view& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool read_exact(std::string_view text, ModeRequest& request) {
  if (!read(text, request.width) || !text.starts_with('x')) return false;
  text.remove_prefix(1);
  if (!read(text, request.height)) return false;
  if (text.starts_with('@')) {
    text.remove_prefix(1);
    if (!read(text, request.refresh_hz) || !(request.refresh_hz >= 1 && request.refresh_hz <= 1000)) {
      return false;
    }
  }
  const auto fits = [](int side) { return side >= 1 && side <= kMostPixels; };
  return text.empty() && fits(request.width) && fits(request.height);
}

}  // namespace

Error parse_mode(std::string_view text, std::string_view what, ModeRequest& request) {
  request = {};
  if (text == "preferred") return {};
  request.kind = text == "highest" ? ModeRequest::Kind::highest : ModeRequest::Kind::exact;
  if (text == "highest" || read_exact(text, request)) return {};
  return std::string(what) + ": " + quote(text) + " is not preferred, highest or WxH[@HZ]";
}

double refresh_hz(const drmModeModeInfo& mode) {
  if (mode.htotal == 0 || mode.vtotal == 0) return mode.vrefresh;
  double hz = mode.clock * 1000.0 / (static_cast<double>(mode.htotal) * mode.vtotal);  // clock: kHz
  if ((mode.flags & DRM_MODE_FLAG_INTERLACE) != 0) hz *= 2;
  if ((mode.flags & DRM_MODE_FLAG_DBLSCAN) != 0) hz /= 2;
  if (mode.vscan > 1) hz /= mode.vscan;
  return hz;
}

std::string mode_text(const drmModeModeInfo& mode) {
  char text[64];
  std::snprintf(text, sizeof text, "%ux%u@%.2f", unsigned{mode.hdisplay}, unsigned{mode.vdisplay},
                refresh_hz(mode));
  return text;
}

bool same_mode(const drmModeModeInfo& a, const drmModeModeInfo& b) {
  return a.hdisplay == b.hdisplay && a.vdisplay == b.vdisplay && a.clock == b.clock && a.htotal == b.htotal &&
         a.vtotal == b.vtotal && a.flags == b.flags;
}

std::size_t choose_mode(std::span<const drmModeModeInfo> modes, const ModeRequest& request) {
  std::size_t best = kNoMode;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const drmModeModeInfo& mode = modes[i];
    if (mode.hdisplay == 0 || mode.vdisplay == 0) continue;
    if (request.kind == ModeRequest::Kind::preferred) {
      if ((mode.type & DRM_MODE_TYPE_PREFERRED) != 0) return i;
      if (best == kNoMode) best = i;
    } else if (request.kind == ModeRequest::Kind::highest) {
      if (best == kNoMode || pixels(mode) > pixels(modes[best]) ||
          (pixels(mode) == pixels(modes[best]) && refresh_hz(mode) > refresh_hz(modes[best]))) {
        best = i;
      }
    } else if (mode.hdisplay == request.width && mode.vdisplay == request.height) {
      if (request.refresh_hz == 0) return i;
      const auto off = [&](std::size_t n) { return std::fabs(refresh_hz(modes[n]) - request.refresh_hz); };
      if (off(i) <= kSameRefreshHz && (best == kNoMode || off(i) < off(best))) best = i;
    }
  }
  return best;
}

std::string attempt_text(const KmsAttempt& attempt, std::span<const drmModeModeInfo> modes) {
  const std::string mode = attempt.mode < modes.size() ? mode_text(modes[attempt.mode]) : "no mode";
  if (!attempt.atomic) return mode + ", legacy";
  return mode + (attempt.modifiers ? ", atomic with modifiers" : ", atomic without modifiers");
}

std::vector<KmsAttempt> plan_attempts(std::span<const drmModeModeInfo> modes, std::size_t first,
                                      const AttemptLimits& limits) {
  std::vector<std::size_t> order{first};
  if (limits.lower_modes) {
    std::vector<std::size_t> lower;
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const auto same_size = [&](std::size_t n) {
        return modes[n].hdisplay == modes[i].hdisplay && modes[n].vdisplay == modes[i].vdisplay;
      };
      if (pixels(modes[i]) == 0 || pixels(modes[i]) >= pixels(modes[first])) continue;
      if (std::none_of(lower.begin(), lower.end(), same_size)) lower.push_back(i);
    }
    std::stable_sort(lower.begin(), lower.end(),
                     [&](std::size_t a, std::size_t b) { return pixels(modes[a]) > pixels(modes[b]); });
    lower.resize(std::min(lower.size(), kMostLowerModes));
    order.insert(order.end(), lower.begin(), lower.end());
  }
  std::vector<KmsAttempt> plan;
  if (limits.atomic && limits.modifiers) plan.push_back({first, true, true});
  if (limits.atomic) {
    for (const std::size_t mode : order) plan.push_back({mode, true, false});
  }
  if (limits.legacy) {
    for (const std::size_t mode : order) plan.push_back({mode, false, false});
  }
  return plan;
}

void KmsPlan::start(std::vector<drmModeModeInfo> modes, std::size_t first, const AttemptLimits& limits) {
  modes_ = std::move(modes);
  wanted_ = modes_[first];
  attempts_ = plan_attempts(modes_, first, limits);
  at_ = 0;
}

void KmsPlan::clear() {
  attempts_.clear();
  at_ = 0;
}

}  // namespace karst
