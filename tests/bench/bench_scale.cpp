// SPDX-License-Identifier: MIT
// What a frame's choice costs when the world grows and the view does not: levels by error, culling and draw
// list over surfaces of K's size, ten and a hundred times as many patches, seen from one place in one corner
// with a far plane that leaves the same patches in view.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "terrain/draw/draw_list.h"
#include "terrain/lod/morph.h"
#include "terrain/lod/select_lod.h"
#include "terrain/view/camera.h"
#include "tests/bench/bench.h"
#include "tests/support/culled_view.h"
#include "tests/support/grid_surface.h"

namespace karst::core {
namespace {

constexpr int kLevel = 5;

// As bench_view's, but each patch's from its own place, so that the same patch is the same in every world.
std::vector<std::uint16_t> make_errors(const GridSurface& grid) {
  std::vector<std::uint16_t> values;
  for (const Volume& v : grid.volumes) {
    std::mt19937_64 random(v.corner[0] * 1'000u + v.corner[2] + v.corner[1] * 1'000'000u);
    double error = 200.0 * std::exp2(static_cast<double>(random() >> 11) * 0x1p-52);
    for (int j = 1; j < kLevel; ++j, error /= 3.0) values.push_back(static_cast<std::uint16_t>(error));
    for (int m = 2; m <= kLevel; ++m) values.push_back(static_cast<std::uint16_t>(12'000 >> m));
  }
  return values;
}

int run_size(int side, int sheets, int repeats) {
  const GridSurface grid = make_grid_surface(side, side, 0.5, 7, sheets);
  const std::size_t patches = grid.patches.size();
  const std::vector<std::uint16_t> errors = make_errors(grid);
  std::vector<PatchLod> lods(patches);
  std::vector<std::uint8_t> levels(patches);
  std::vector<std::uint32_t> scratch(patches);
  std::vector<DrawItem> items(4'096);
  // Ground that faces up, with normals up to 45 degrees aside.
  const std::vector<NormalCone> cones(patches, {{0, 127, 0}, 180});
  CameraSettings settings;
  settings.position = {2.0, 24.0, 2.0};
  settings.yaw_deg = 225.0;
  settings.pitch_deg = -15.0;
  settings.far_voxels = 50.0;
  Camera camera;
  if (!make_camera(settings, camera).ok()) return 1;
  const Frustum frustum = make_frustum(camera);
  test::CulledView culled(grid.surface(), grid.bounds);

  SelectLod select;
  select.camera = &camera;
  select.surface = grid.surface();
  select.bounds = grid.bounds;
  select.tree = &grid.tree;
  select.scale = make_error_scale(camera, 1280, 720, select.settings.error_px);
  select.lods = lods;
  select.culled = culled.find(&frustum, grid.tree);
  select.errors = {kLevel, errors};
  select.levels = levels;
  SetThresholds set;
  set.scale = select.scale;
  set.surface = select.surface;
  set.bounds = select.bounds;
  set.errors = select.errors;
  set.lods = lods;
  if (!set.validate().ok()) return 1;
  set.run();
  BuildDrawList build;
  build.boxes = culled.boxes();
  build.culled = select.culled;
  build.camera = &camera;
  build.surface = select.surface;
  build.levels = levels;
  build.cones = cones;
  build.scratch = scratch;
  build.items = items;
  if (!select.validate().ok() || !build.validate().ok()) return 1;
  bool ok = true;
  BuildDrawList::Result list;
  const bench::Times seen = bench::measure(repeats, [&] { culled.find(&frustum, grid.tree); });
  const bench::Times chosen = bench::measure(repeats, [&] { select.run(); });
  const bench::Times listed = bench::measure(repeats, [&] { ok = build.run(list).ok() && ok; });
  std::printf("  %8zu %8u %10.1f %10.1f %10.1f %10.1f %10.1f\n", patches, list.drawn, 1e3 * seen.median_ms,
              1e3 * chosen.median_ms, 1e3 * listed.median_ms,
              1e3 * (seen.median_ms + chosen.median_ms + listed.median_ms),
              1e3 * (seen.least_ms + chosen.least_ms + listed.least_ms));
  return ok ? 0 : 1;
}

int run_scale(bool smoke) {
  const int repeats = smoke ? 1 : 2'000;
  std::printf("scale: one view, larger worlds; microseconds, medians of %d\n", repeats);
  std::printf("  %8s %8s %10s %10s %10s %10s %10s\n", "patches", "drawn", "in view", "levels", "list", "all",
              "least");
  int failed = run_size(59, 1, repeats);
  failed |= run_size(187, 1, repeats);
  if (!smoke) failed |= run_size(418, 2, repeats);
  return failed;
}

const bench::Register registered{{"scale", run_scale}};

}  // namespace
}  // namespace karst::core
