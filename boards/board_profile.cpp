// SPDX-License-Identifier: MIT
#include "boards/board_profile.h"

#include <charconv>
#include <cmath>
#include <cstdint>

#include "karst/plan.h"
#include "platform/base/text.h"

namespace karst {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;
constexpr double kMostMiB = 4096;
// The smallest pool draws something: a page for a patch, and as many as a view of a small world has.
constexpr double kLeastVertexMiB = 0.25;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

bool read(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

bool read_pair(std::string_view text, double& a, double& b) {
  const std::size_t x = text.find('x');
  return x != std::string_view::npos && read(text.substr(0, x), a) && read(text.substr(x + 1), b);
}

bool whole(double value, double least, double most) {
  return value >= least && value <= most && value == std::floor(value);
}

bool power_of_two(double value, double least, double most) {
  if (!whole(value, least, most)) return false;
  const auto n = static_cast<std::uint64_t>(value);
  return (n & (n - 1)) == 0;
}

struct Key {
  const char* name;
  const char* range;
  bool (*set)(std::string_view value, BoardProfile& profile);
};

bool set_bytes(std::string_view value, double least, std::uint64_t& bytes) {
  double mib = 0;
  if (!read(value, mib) || mib < least || mib > kMostMiB) return false;
  bytes = static_cast<std::uint64_t>(mib * static_cast<double>(kMiB));
  return true;
}

constexpr Key kKeys[] = {
    {"title", "a text", [](std::string_view v, BoardProfile& p) { return !(p.title = v).empty(); }},
    {"driver", "a text", [](std::string_view v, BoardProfile& p) { return !(p.driver = v).empty(); }},
    {"cpu_mib", "0.5..4096",
     [](std::string_view v, BoardProfile& p) { return set_bytes(v, 0.5, p.cpu_bytes); }},
    {"gpu_mib", "0.5..4096",
     [](std::string_view v, BoardProfile& p) { return set_bytes(v, 0.5, p.gpu_bytes); }},
    {"size", "WxH, sides of 16..16384 pixels",
     [](std::string_view v, BoardProfile& p) {
       double w = 0;
       double h = 0;
       constexpr double kMost = kMostPictureSide;
       if (!read_pair(v, w, h) || !whole(w, 16, kMost) || !whole(h, 16, kMost)) return false;
       p.width = static_cast<int>(w);
       p.height = static_cast<int>(h);
       return true;
     }},
    {"colour", "xrgb8888 or rgb565",
     [](std::string_view v, BoardProfile& p) {
       p.rgb565 = v == "rgb565";
       return p.rgb565 || v == "xrgb8888";
     }},
    {"buffers", "2 or 3",
     [](std::string_view v, BoardProfile& p) {
       p.buffers = v == "3" ? 3 : 2;
       return v == "2" || v == "3";
     }},
    {"level", "1..6",
     [](std::string_view v, BoardProfile& p) {
       double n = 0;
       if (!read(v, n) || !whole(n, 1, kFinestLevel)) return false;
       p.level = static_cast<int>(n);
       return true;
     }},
    {"error_px", "0.01..1000",
     [](std::string_view v, BoardProfile& p) {
       return read(v, p.error_px) && p.error_px >= 0.01 && p.error_px <= 1000;
     }},
    {"vertex_mib", "0.25..256",
     [](std::string_view v, BoardProfile& p) {
       return set_bytes(v, kLeastVertexMiB, p.vertex_bytes) && p.vertex_bytes <= 256 * kMiB;
     }},
    {"cascades", "0, or NxSIDE: 1..3 cascades of 512..2048 texels a side, a multiple of 16",
     [](std::string_view v, BoardProfile& p) {
       double n = 0;
       double side = 0;
       if (v == "0") return true;
       if (!read_pair(v, n, side) || !whole(n, 1, kMostShadowMaps)) return false;
       if (!whole(side / kShadowSizeStep, double{kLeastShadowSize} / kShadowSizeStep,
                  double{kMostShadowSize} / kShadowSizeStep))
         return false;
       p.cascades = static_cast<int>(n);
       p.cascade_side = static_cast<int>(side);
       return true;
     }},
    {"detail", "low, medium or high",
     [](std::string_view v, BoardProfile& p) {
       p.detail = v == "low" ? 0 : v == "medium" ? 1 : 2;
       return p.detail < 2 || v == "high";
     }},
    {"shading", "forward or deferred",
     [](std::string_view v, BoardProfile& p) {
       p.deferred = v == "deferred";
       return p.deferred || v == "forward";
     }},
    {"drape", "0, or 256..16384 pixels a side, a power of two",
     [](std::string_view v, BoardProfile& p) {
       double side = 0;
       if (v == "0") return true;
       if (!read(v, side) || !power_of_two(side, 256, 16384)) return false;
       p.drape_side = static_cast<int>(side);
       return true;
     }},
    {"antialias", "none, edges, msaa2 or msaa4",
     [](std::string_view v, BoardProfile& p) {
       constexpr std::string_view kWords[] = {"none", "edges", "msaa2", "msaa4"};
       int n = 0;
       while (n < 4 && kWords[n] != v) ++n;
       p.antialias = static_cast<Antialias>(n & 3);
       return n < 4;
     }},
};
constexpr std::size_t kKeyCount = std::size(kKeys);

std::size_t find_key(std::string_view name) {
  std::size_t i = 0;
  while (i < kKeyCount && kKeys[i].name != name) ++i;
  return i;
}

Error parse_line(std::string_view line, bool (&given)[kKeyCount], BoardProfile& profile) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return "expected `key = value  # reason`";
  const std::string_view name = trimmed(line.substr(0, equals));
  const std::size_t hash = line.find('#', equals);
  const std::string_view value = trimmed(line.substr(equals + 1, hash - equals - 1));
  const std::string_view reason = hash == std::string_view::npos ? "" : trimmed(line.substr(hash + 1));
  const std::size_t key = find_key(name);
  if (key == kKeyCount) return "unknown key " + quote(name);
  const std::string what = kKeys[key].name;
  if (given[key]) return what + " is given twice";
  given[key] = true;
  if (!kKeys[key].set(value, profile)) return what + " is not " + kKeys[key].range;
  const bool text = what == "title" || what == "driver";
  if (reason.empty() && !text) return what + " has no reason (# ...)";
  return {};
}

}  // namespace

std::uint64_t BoardProfile::cascade_bytes() const {
  const auto side = static_cast<std::uint64_t>(cascade_side);
  return static_cast<std::uint64_t>(cascades) * side * side * 2;  // 16-bit depth
}

std::uint64_t BoardProfile::drape_bytes() const {
  const auto side = static_cast<std::uint64_t>(drape_side);
  return side * side * 4 * 4 / 3;  // RGBA8 and its mip levels
}

std::uint64_t BoardProfile::scan_out_bytes() const {
  return static_cast<std::uint64_t>(buffers) * static_cast<std::uint64_t>(width) *
         static_cast<std::uint64_t>(height) * (rgb565 ? 2 : 4);
}

Error parse_board(std::string_view text, const std::string& source, BoardProfile& profile) {
  profile = {};
  text = without_byte_order_mark(text);
  bool given[kKeyCount] = {};
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    if (const Error error = parse_line(line, given, profile); !error.ok()) {
      return source + ": line " + std::to_string(number) + ": " + error.text();
    }
  }
  for (std::size_t i = 0; i < kKeyCount; ++i) {
    if (!given[i]) return source + ": " + kKeys[i].name + " is missing";
  }
  return {};
}

Error find_board(std::string_view name, BoardProfile& profile) {
  std::string names;
  for (const BoardText& board : board_texts()) {
    if (board.name == name) {
      Error error = parse_board(board.text, std::string("board ").append(name), profile);
      profile.name = name;
      return error;
    }
    names.append(names.empty() ? "" : ", ").append(board.name);
  }
  return quote(name) + " is not one of " + names;
}

}  // namespace karst
