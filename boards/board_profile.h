// SPDX-License-Identifier: MIT
// What a board can do, and what karst may take of it: small text files, one a board, built into the program.
// A line is `key = value  # reason`; every number has its reason. Profiles are untrusted like any other file:
// a user may hand in an own one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "platform/base/error.h"

namespace karst {

// edges: silhouettes, of what is shaded from a G-buffer. The others: samples of a pixel.
enum class Antialias : std::uint8_t { none, edges, msaa2, msaa4 };
constexpr int samples_of(Antialias antialias) {
  return antialias == Antialias::msaa2 ? 2 : antialias == Antialias::msaa4 ? 4 : 1;
}

struct BoardProfile {
  std::string name;             // of the file
  std::string title;            // the board, for people
  std::string driver;           // GPU and its driver
  std::uint64_t cpu_bytes = 0;  // for the arena
  std::uint64_t gpu_bytes = 0;  // for GL objects and scan-out buffers together
  int width = 0;                // of the picture, pixels
  int height = 0;
  bool rgb565 = false;
  int buffers = 2;                 // scan-out buffers in use, 2 or 3
  int level = 0;                   // finest, 1..6
  double error_px = 1;             // bound of the level of detail
  std::uint64_t vertex_bytes = 0;  // of the pool
  int cascades = 0;                // shadow cascades, 0..3
  int cascade_side = 0;            // texels
  bool deferred = false;           // pixels are shaded once, from a G-buffer
  int detail = 1;                  // of textures, 0 low, 1 medium, 2 high
  Antialias antialias = Antialias::none;
  int drape_side = 0;  // of the largest image over the world, pixels; 0: none

  // What the cascades, the largest drape and the scan-out buffers take.
  std::uint64_t cascade_bytes() const;
  std::uint64_t drape_bytes() const;
  std::uint64_t scan_out_bytes() const;
};

struct BoardText {
  const char* name;
  const char* text;
};
// The built-in profiles, sorted by name.
std::span<const BoardText> board_texts();

// The error names source and line: an unknown or missing key, a value outside its
// range, a missing reason, a key given twice.
Error parse_board(std::string_view text, const std::string& source, BoardProfile& profile);

// The built-in profile of that name. The error names those that there are.
Error find_board(std::string_view name, BoardProfile& profile);

}  // namespace karst
