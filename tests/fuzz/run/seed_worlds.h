// SPDX-License-Identifier: MIT
// Small worlds that mutations start from.
#pragma once

#include "tests/support/world_bytes.h"

#include <vector>

namespace karst {

// One of the least sections, one of all that a world can have.
inline std::vector<std::vector<std::byte>> seed_worlds() {
  core::TestWorld full(2, 1, 12);
  full.add_materials(2, 16, core::TextureFormat::etc2, 1, 5);
  full.add_blend_map(5, 3, 6);
  return {core::TestWorld(2, 1, 12).bytes(), full.bytes()};
}

}  // namespace karst
