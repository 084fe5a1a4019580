// SPDX-License-Identifier: MIT
// Elevation images as karst-bake reads them. What begins with ENVI or BYTEORDER is a text header up to the
// first zero byte, and the raw samples beside it.
#include "bake/elevation/elevation.h"
#include "tests/fuzz/run/fuzz_target.h"
#include "tests/fuzz/run/image_place.h"

#include <algorithm>
#include <cmath>

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  static const ImagePlace place;
  const std::string_view text = as_text(input);
  bake::ReadElevation read;
  read.pixel_size_m = 1;
  read.allow_8bit = true;
  if (text.starts_with("ENVI") || text.starts_with("BYTEORDER")) {
    const std::size_t end = std::min(text.find('\0'), text.size());
    place.write("raw.hdr", input.first(end));
    read.path = place.write("raw.bil", input.subspan(std::min(end + 1, input.size())));
  } else {
    read.path = place.write("image", input);
  }
  bake::Elevation elevation;
  const Error error = read.run(elevation);
  must_be_short(error);
  if (!error.ok()) return;
  must(elevation.width >= 2 && elevation.width <= bake::kMaxElevationSide && elevation.height >= 2 &&
       elevation.height <= bake::kMaxElevationSide);
  const std::size_t samples =
      static_cast<std::size_t>(elevation.width) * static_cast<std::size_t>(elevation.height);
  must(elevation.heights_m.size() == samples && elevation.valid.size() == samples);
  std::uint64_t voids = 0;
  for (std::size_t k = 0; k < samples; ++k) {
    voids += elevation.valid[k] == 0;
    must(std::fabs(elevation.heights_m[k]) <= bake::kMaxElevationM);
  }
  must(voids == elevation.voids && voids < samples);
}

}  // namespace karst
