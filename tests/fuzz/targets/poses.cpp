// SPDX-License-Identifier: MIT
// Lines of poses: in pieces of any size they are what they are in one; and as a datagram.
#include "app/motion/pose_stream.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  if (input.empty()) return;
  const std::size_t most = 1 + std::to_integer<std::size_t>(input[0]);
  const std::string_view text = as_text(input.subspan(1));
  const auto same = [](const app::CameraPlace& a, const app::CameraPlace& b) {
    return a.position_m == b.position_m && a.yaw_deg == b.yaw_deg && a.pitch_deg == b.pitch_deg &&
           a.above_ground == b.above_ground;
  };
  app::PoseLines whole, pieces, datagram;
  app::CameraPlace last, piece_last, place;
  whole.feed(text, 0, last);
  whole.end(0, last);
  for (std::size_t at = 0; at < text.size(); at += most) {
    if (pieces.feed(text.substr(at, most), 0, place)) piece_last = place;
  }
  if (pieces.end(0, place)) piece_last = place;
  must(whole.poses() == pieces.poses() && whole.malformed() == pieces.malformed());
  must(whole.poses() == 0 || same(last, piece_last));
  if (datagram.datagram(text, 0, place)) {
    must(std::isfinite(place.position_m.x) && std::isfinite(place.pitch_deg));
    must(datagram.poses() == 1);
  }
}

}  // namespace karst
