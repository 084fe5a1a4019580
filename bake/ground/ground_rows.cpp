// SPDX-License-Identifier: MIT
#include "bake/ground/ground_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bake/base/parallel.h"
#include "bake/surroundings/sink_sea.h"

namespace karst::bake {
namespace {

constexpr int kMadeRows = 16;  // a thread at a time
constexpr int kAround = 64;    // rows of a strip's neighbours that its voids are filled from

}  // namespace

Error GroundRows::open() {
  return rows_.open(settings_);
}

void GroundRows::hold(Elevation made, double unit_m) {
  held_ = std::move(made);
  made_unit_m_ = unit_m;
  holds_ = is_made_ = true;
}

void GroundRows::make(Elevation facts, double unit_m, int threads, Make make) {
  held_ = std::move(facts);
  made_unit_m_ = unit_m;
  make_ = std::move(make);
  threads_ = threads;
  is_made_ = true;
}

void GroundRows::run_made(const Take& take) const {
  const auto wide = static_cast<std::size_t>(width());
  const int strip = kMadeRows * threads_;
  std::vector<float> rows(static_cast<std::size_t>(strip) * wide);
  for (int first = 0; first < height(); first += strip) {
    const auto count = static_cast<std::size_t>(std::min(strip, height() - first));
    parallel_chunks(count, kMadeRows, threads_, [&](std::size_t from, std::size_t to, int) {
      make_(first + static_cast<int>(from), static_cast<int>(to - from),
            std::span(rows).subspan(from * wide, (to - from) * wide));
    });
    for (std::size_t row = 0; row < count; ++row) {
      if (!take(std::span<const float>(rows).subspan(row * wide, wide))) return;
    }
  }
}

Error GroundRows::run(const Take& take) {
  if (make_) {
    run_made(take);
    return {};
  }
  if (!is_held()) return run_strips(take);
  if (!holds_) {
    if (Error error = read_all(); !error.ok()) return error;
  }
  const auto wide = static_cast<std::size_t>(width());
  for (std::size_t row = 0; row < static_cast<std::size_t>(height()); ++row) {
    if (!take(std::span<const float>(held_.heights_m).subspan(row * wide, wide))) break;
  }
  return {};
}

Error GroundRows::read_all() {
  const auto samples = static_cast<std::size_t>(std::int64_t{width()} * height());
  held_.heights_m.resize(samples);
  if (Error error = rows_.read(0, height(), held_.heights_m); !error.ok()) return error;
  const Elevation& facts = rows_.facts();
  held_.width = facts.width;
  held_.height = facts.height;
  held_.spacing_x_m = facts.spacing_x_m;
  held_.spacing_z_m = facts.spacing_z_m;
  held_.valid.assign(samples, 1);
  for (std::size_t n = 0; n < samples; ++n) {
    if (!std::isnan(held_.heights_m[n])) continue;
    held_.heights_m[n] = 0;
    held_.valid[n] = 0;
    ++held_.voids;
  }
  voids_ = held_.voids;
  if (voids_ == samples) return settings_.path + ": no sample is valid: all are void";
  fill_voids(held_);
  if (water_m_) sunk_ = SinkSea{*water_m_}.run(held_);
  holds_ = true;
  return {};
}

// window: rows [begin, end) as they were read, from the row window_first on.
Error GroundRows::run_strips(const Take& take) {
  voids_ = 0;
  const auto wide = static_cast<std::size_t>(width());
  const int strip = std::max(rows_.rows_at_once(), 1);
  // Rows before the strip, filled; the strip; and what comes behind.
  std::vector<float> window;
  int window_first = 0;  // row
  int read_end = 0;
  int leading = 0;  // rows at the north border in strips of nothing but voids
  std::vector<float> last;
  for (int first = 0; first < height(); first += strip) {
    const int end = std::min(first + strip, height());
    const int wanted = std::min(end + kAround, height());
    if (wanted > read_end) {
      const std::size_t before = window.size();
      window.resize(before + static_cast<std::size_t>(wanted - read_end) * wide);
      const std::span<float> fresh = std::span(window).subspan(before);
      if (Error error = rows_.read(read_end, wanted - read_end, fresh); !error.ok()) return error;
      voids_ += static_cast<std::uint64_t>(
          std::count_if(fresh.begin(), fresh.end(), [](float h) { return std::isnan(h); }));
      read_end = wanted;
    }
    const std::size_t begin = static_cast<std::size_t>(first - window_first) * wide;
    const std::size_t count = static_cast<std::size_t>(end - first) * wide;
    std::span<float> rows = std::span(window).subspan(begin, count);
    const auto is_void = [](float h) { return std::isnan(h); };
    if (std::all_of(rows.begin(), rows.end(), is_void)) {
      if (last.empty()) {
        leading += end - first;
      } else {
        for (std::size_t n = 0; n < count; ++n) rows[n] = last[n % wide];
      }
    } else if (std::any_of(rows.begin(), rows.end(), is_void)) {
      Elevation part;
      part.width = width();
      part.height = static_cast<int>(window.size() / wide);
      part.heights_m = window;
      part.valid.assign(window.size(), 1);
      for (std::size_t n = 0; n < window.size(); ++n) {
        if (!is_void(window[n])) continue;
        part.heights_m[n] = 0;
        part.valid[n] = 0;
      }
      fill_voids(part);
      std::copy_n(part.heights_m.begin() + static_cast<std::ptrdiff_t>(begin), count, rows.begin());
    }
    if (!is_void(rows.front())) {
      for (; leading > 0; --leading) {
        if (!take(rows.first(wide))) return {};
      }
      for (std::size_t at = 0; at < count; at += wide) {
        if (!take(rows.subspan(at, wide))) return {};
      }
      last.assign(rows.end() - static_cast<std::ptrdiff_t>(wide), rows.end());
    }
    const int keep = std::max(end - kAround, 0);
    if (keep > window_first) {
      window.erase(
          window.begin(),
          window.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(keep - window_first) * wide));
      window_first = keep;
    }
  }
  return leading == 0 ? Error() : Error(settings_.path + ": no sample is valid: all are void");
}

}  // namespace karst::bake
