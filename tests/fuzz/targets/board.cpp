// SPDX-License-Identifier: MIT
// Profiles of boards.
#include "boards/board_profile.h"
#include "tests/fuzz/run/fuzz_target.h"

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  static const std::string name = "some.board";
  BoardProfile profile;
  const Error error = parse_board(as_text(input), name, profile);
  must_be_short(error);
  if (!error.ok()) return;
  must(profile.width > 0 && profile.height > 0 && profile.level >= 1 && profile.level <= 6);
  must(profile.cascades >= 0 && profile.cascades <= 3 && profile.buffers >= 2 && profile.buffers <= 3);
  must(profile.scan_out_bytes() > 0 && profile.cascade_bytes() <= std::uint64_t{1} << 40 &&
       profile.drape_bytes() <= std::uint64_t{1} << 40);
}

}  // namespace karst
