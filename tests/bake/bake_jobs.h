// SPDX-License-Identifier: MIT
// Jobs that a test knows to succeed.
#pragma once

#include "bake/elevation/solid.h"
#include "bake/pipeline/bake.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace karst::bake {

inline WorldGrid grid_around(const Box& content_m, double voxel_m) {
  WorldGrid grid;
  EXPECT_EQ(WorldGrid::around(content_m, voxel_m, grid).text(), "");
  return grid;
}

inline std::vector<std::byte> world_of(const Bake& job, Bake::Report& report) {
  std::vector<std::byte> file;
  EXPECT_EQ(job.run(report, {}, file).text(), "");
  return file;
}

}  // namespace karst::bake
