// SPDX-License-Identifier: MIT
// A world file as it is, and with checksums that fit, or nothing behind them would ever be reached.
#include "tests/fuzz/run/fuzz_target.h"
#include "tests/fuzz/world_file_target.h"
#include "tests/support/world_damage.h"

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  std::vector<std::byte> file(input.begin(), input.end());
  core::fix_checksums(file);
  core::fuzz_world_file(file);
  if (!std::equal(file.begin(), file.end(), input.begin())) core::fuzz_world_file(input);
}

}  // namespace karst
