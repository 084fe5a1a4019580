// SPDX-License-Identifier: MIT
// The text header of raw ENVI files (Harris Geospatial, "ENVI Header Files"): "ENVI" on the first line, then
// `key = value`, where a value in braces may run over several lines. Only single-band images of the types
// that elevation comes in are taken.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "platform/base/error.h"

namespace karst::bake {

enum class EnviType : std::uint8_t { u8 = 1, i16 = 2, f32 = 4, u16 = 12 };  // ENVI's own numbers

struct EnviHeader {
  int width = 0, height = 0;  // samples, lines
  std::uint64_t offset = 0;   // bytes before the first sample
  EnviType type = EnviType::i16;
  bool big_endian = false;
  std::optional<double> spacing_x_m, spacing_z_m;  // from "map info"
  std::optional<double> nodata;                    // "data ignore value"
  bool geographic = false;

  std::uint64_t sample_bytes() const { return type == EnviType::u8 ? 1 : type == EnviType::f32 ? 4 : 2; }
};

// text: the header's bytes. name: the file, for messages. Sizes are checked against the limits of
// elevation.h, spacings are not. need_scale false: map info is not looked at.
Error parse_envi_header(std::string_view text, const std::string& name, bool need_scale, EnviHeader& header);

// The header beside a raw file, "dem.hdr" or "dem.bil.hdr" for "dem.bil"; empty where there is none.
std::string find_envi_header(const std::string& path);

}  // namespace karst::bake
