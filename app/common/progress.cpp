// SPDX-License-Identifier: MIT
#include "app/common/progress.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

namespace karst::app {
namespace {

constexpr std::int64_t kFirstDrawNs = 500'000'000;  // shorter work shows no bar
constexpr std::int64_t kRedrawNs = 100'000'000;
constexpr int kBarCharacters = 32;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Progress::Progress(std::string label, std::uint64_t total)
    : label_(std::move(label)),
      total_(std::max<std::uint64_t>(total, 1)),
      start_ns_(now_ns()),
      next_draw_ns_(start_ns_ + kFirstDrawNs),
      terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  finish();
}

void Progress::update(std::uint64_t done) {
  if (!terminal_) return;
  const std::int64_t now = now_ns();
  if (now < next_draw_ns_) return;
  next_draw_ns_ = now + kRedrawNs;
  const double part = static_cast<double>(std::min(done, total_)) / static_cast<double>(total_);
  const double elapsed_s = static_cast<double>(now - start_ns_) * 1e-9;
  char bar[kBarCharacters + 1];
  const int filled = static_cast<int>(part * kBarCharacters);
  for (int i = 0; i < kBarCharacters; ++i) bar[i] = i < filled ? '#' : '.';
  bar[kBarCharacters] = '\0';
  std::fprintf(stderr, "\r\033[K%s [%s] %3.0f %%", label_.c_str(), bar, part * 100);
  if (part > 0.02) std::fprintf(stderr, ", %.0f s left", elapsed_s / part - elapsed_s);
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::finish() {
  if (!drawn_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace karst::app
