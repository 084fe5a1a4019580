// SPDX-License-Identifier: MIT
// Encoding of planar blocks: colour at three corners, 6, 7 and 6 bits, and a plane through them a channel.
// Begins with the plane of least squares and descends by steps of the corners; channels are apart.
#include "etc2/etc2_blocks.h"

namespace karst::etc2 {
namespace {

struct Plane {
  int corner[3] = {};  // at (0, 0), (4, 0) and (0, 4), in levels
  int error = std::numeric_limits<int>::max();
};

int error_of(const BlockTexels& texels, int channel, int bits, const Plane& plane) {
  const int o = extend(plane.corner[0], bits), h = extend(plane.corner[1], bits),
            v = extend(plane.corner[2], bits);
  int sum = 0;
  for (int p = 0; p < kTexels; ++p) {
    const int d = plane_at(o, h, v, p >> 2, p & 3) - texels.rgba[p][channel];
    sum += d * d;
  }
  return sum;
}

Plane least_squares(const BlockTexels& texels, int channel, int bits) {
  int sum = 0, along_x = 0, along_y = 0;
  for (int p = 0; p < kTexels; ++p) {
    const int value = texels.rgba[p][channel];
    sum += value;
    along_x += (2 * (p >> 2) - 3) * value;
    along_y += (2 * (p & 3) - 3) * value;
  }
  // Slopes are along / 40, the middle is (1.5, 1.5): all times 80.
  const int o = 5 * sum - 3 * (along_x + along_y);
  const int most = (1 << bits) - 1;
  const auto level = [most](int value) {
    return std::clamp((value * most + 40 * 255) / (80 * 255), 0, most);
  };
  Plane plane;
  plane.corner[0] = level(o);
  plane.corner[1] = level(o + 8 * along_x);
  plane.corner[2] = level(o + 8 * along_y);
  return plane;
}

Plane fit_plane(const BlockTexels& texels, int channel, int bits) {
  Plane best = least_squares(texels, channel, bits);
  best.error = error_of(texels, channel, bits, best);
  const int most = (1 << bits) - 1;
  for (int before = -1; before != best.error && best.error > 0;) {
    before = best.error;
    for (int move = 0; move < 27; ++move) {
      const int steps[3] = {move % 3 - 1, move / 3 % 3 - 1, move / 9 - 1};
      Plane moved = best;
      bool inside = true;
      for (int k = 0; k < 3; ++k) {
        moved.corner[k] += steps[k];
        inside = inside && moved.corner[k] >= 0 && moved.corner[k] <= most;
      }
      if (!inside) continue;
      moved.error = error_of(texels, channel, bits, moved);
      if (moved.error < best.error) best = moved;
    }
  }
  return best;
}

}  // namespace

Encoded encode_planar(const BlockTexels& texels, const std::uint8_t (&weights)[kChannels]) {
  const Plane red = fit_plane(texels, 0, 6), green = fit_plane(texels, 1, 7), blue = fit_plane(texels, 2, 6);
  const int(&r)[3] = red.corner;
  const int(&g)[3] = green.corner;
  const int(&b)[3] = blue.corner;
  std::uint64_t bits = place(r[0], 57) | place(g[0] >> 6, 56) | place(g[0] & 63, 49) | place(b[0] >> 5, 48) |
                       place(b[0] >> 3 & 3, 43) | place(b[0] & 7, 39) | place(r[1] >> 1, 34) |
                       place(1, kDifferentialBit) | place(r[1] & 1, 32) | place(g[1], 25) | place(b[1], 19) |
                       place(r[2], 13) | place(g[2], 6) | place(b[2], 0);
  // Sums of red's and of green's fields must stay in 0..31, blue's must not; the fields' top bits are free.
  if (field(bits, 59, 5) + signed_field(bits, 56, 3) < 0) bits |= place(1, 63);
  if (field(bits, 51, 5) + signed_field(bits, 48, 3) < 0) bits |= place(1, 55);
  bits |= field(bits, 43, 2) + field(bits, 40, 2) < 4 ? place(1, 42) : place(7, 45);
  return {bits, red.error * weights[0] + green.error * weights[1] + blue.error * weights[2]};
}

}  // namespace karst::etc2
