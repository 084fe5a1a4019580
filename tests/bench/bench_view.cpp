// SPDX-License-Identifier: MIT
// What a frame costs before the GPU: levels of detail, culling, draw list and index stream over a made-up
// surface of about the size of K's test scene (3,560 patches), and over one of 100 times as many.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "terrain/draw/draw_list.h"
#include "terrain/draw/expand_indices.h"
#include "terrain/draw/index_batches.h"
#include "terrain/lod/morph.h"
#include "terrain/lod/select_lod.h"
#include "terrain/view/camera.h"
#include "tests/bench/bench.h"
#include "tests/support/culled_view.h"
#include "tests/support/grid_surface.h"

namespace karst::core {
namespace {

struct Scene {
  GridSurface grid;
  Camera camera;
  std::vector<std::uint8_t> levels;
  std::vector<std::uint32_t> scratch, first_page, next_page, stream;
  std::vector<DrawItem> items;
  std::vector<std::uint16_t> table;
};

constexpr int kLevel = 5;

// Errors that fall to a third from level to level, from 200 to 800 steps at level 1, like those of mountains
// at 60 m voxels; reaches of a whole triangle.
std::vector<std::uint16_t> make_errors(std::size_t patches) {
  std::mt19937_64 random(3);
  std::vector<std::uint16_t> values;
  for (std::size_t p = 0; p < patches; ++p) {
    double error = 200.0 * std::exp2(static_cast<double>(random() >> 11) * 0x1p-52);
    for (int j = 1; j < kLevel; ++j, error /= 3.0) values.push_back(static_cast<std::uint16_t>(error));
    for (int m = 2; m <= kLevel; ++m) values.push_back(static_cast<std::uint16_t>(12'000 >> m));
  }
  return values;
}

struct ByError {
  SelectLod::Result selected;
  BuildDrawList::Result list;
  bench::Times thresholds, rows, levels, listed;
};

// What changes with the picture alone, and the levels of a frame; select and build as for levels by distance.
bool run_by_error(SelectLod select, BuildDrawList build, test::CulledView& culled, int repeats,
                  ByError& result) {
  Frustum frustum;
  const std::size_t patches = select.levels.size();
  const std::vector<std::uint16_t> errors = make_errors(patches);
  std::vector<PatchLod> lods(patches);
  select.settings.mode = LodMode::error;
  select.scale = make_error_scale(*select.camera, 1280, 720, select.settings.error_px);
  select.errors = {kLevel, errors};
  select.lods = lods;
  select.culled = build.culled;
  SetThresholds set;
  set.scale = select.scale;
  set.surface = select.surface;
  set.bounds = select.bounds;
  set.errors = select.errors;
  set.lods = lods;
  if (!set.validate().ok() || !select.validate().ok()) return false;
  result.thresholds = bench::measure(std::max(repeats / 10, 1), [&] { set.run(); });
  std::vector<std::uint16_t> rows(patches * kMorphRow);
  result.rows = bench::measure(std::max(repeats / 10, 1), [&] {
    for (PatchId p = 0; p < patches; ++p) {
      make_morph_row(select.surface, lods, p,
                     std::span<std::uint16_t, kMorphRow>(rows.data() + p * kMorphRow, kMorphRow));
    }
  });
  result.levels = bench::measure(repeats, [&] { result.selected = select.run(); });
  bool ok = true;
  result.listed = bench::measure(repeats, [&] {
    frustum = make_frustum(*build.camera);
    build.culled = culled.find(&frustum, *select.tree);
    ok = build.run(result.list).ok() && ok;
  });
  return ok;
}

int run_scene(const char* name, int side, glm::dvec3 eye, double yaw_deg, int repeats) {
  Scene s{make_grid_surface(side, side, 0.5, 7), {}, {}, {}, {}, {}, {}, {}, {}};
  const std::size_t patches = s.grid.patches.size();
  CameraSettings settings;
  settings.position = eye;
  settings.yaw_deg = yaw_deg;
  settings.pitch_deg = -12.0;
  if (!make_camera(settings, s.camera).ok()) return 1;
  s.levels.resize(patches);
  s.scratch.resize(patches);
  s.items.resize(patches);
  constexpr std::uint32_t kSlot = slot_pages(kLevel);
  s.next_page.resize(patches * kSlot);
  for (std::uint32_t page = 0; page < s.next_page.size(); ++page) {
    s.next_page[page] = page % kSlot + 1 < kSlot ? page + 1 : kNoPage;
    if (page % kSlot == 0) s.first_page.push_back(page);
  }
  s.stream.resize(786'432);  // Config::stream_indices
  s.table.resize(index_count(kMaxLevel));
  if (!build_index_tables(kMaxLevel, s.table).ok()) return 1;

  SelectLod select;
  select.settings.mode = LodMode::distance;
  select.camera = &s.camera;
  select.surface = s.grid.surface();
  select.bounds = s.grid.bounds;
  select.tree = &s.grid.tree;
  select.levels = s.levels;
  Frustum frustum;
  test::CulledView view(s.grid.surface(), s.grid.bounds);
  BuildDrawList build;
  build.boxes = view.boxes();
  build.camera = &s.camera;
  build.surface = select.surface;
  build.levels = s.levels;
  build.scratch = s.scratch;
  build.items = s.items;
  if (!select.validate().ok()) return 1;

  SelectLod::Result selected;
  BuildDrawList::Result list;
  const auto lod = bench::measure(repeats, [&] { selected = select.run(); });
  bool ok = true;
  const auto culled = bench::measure(repeats, [&] {
    frustum = make_frustum(s.camera);
    build.culled = view.find(&frustum, s.grid.tree);
    ok = build.run(list).ok() && ok;
  });
  const ExpandIndices expand{
      s.table, std::span(s.items).first(list.drawn), {s.first_page, s.next_page, {}}, s.stream};
  if (!ok || !expand.validate(select.settings.max_level).ok()) return 1;
  std::size_t indices = 0;
  const auto expanded = bench::measure(repeats, [&] {
    indices = 0;
    for (ExpandIndices::Chunk c; c.next_item < list.drawn; indices += c.indices) c = expand.run(c.next_item);
  });
  // The same with pages as they lie after long streaming: anywhere.
  std::vector<std::uint32_t> places(s.next_page.size());
  std::iota(places.begin(), places.end(), 0u);
  std::shuffle(places.begin(), places.end(), std::mt19937_64(5));
  for (std::uint32_t page = 0; page < places.size(); ++page) {
    s.next_page[places[page]] = page % kSlot + 1 < kSlot ? places[page + 1] : kNoPage;
    if (page % kSlot == 0) s.first_page[page / kSlot] = places[page];
  }
  const auto scattered = bench::measure(repeats, [&] {
    for (ExpandIndices::Chunk c; c.next_item < list.drawn;) c = expand.run(c.next_item);
  });
  const auto refit = bench::measure(
      std::max(repeats / 10, 1), [&] { ok = s.grid.tree.build(select.surface, s.grid.bounds).ok() && ok; });

  ByError by_error;
  ok = run_by_error(select, build, view, repeats, by_error) && ok;

  std::printf("view %s: %zu patches, %u drawn, %u raised, %u triangles, %zu indices\n", name, patches,
              list.drawn, selected.raised, list.triangles, indices);
  const auto line = [](const char* what, bench::Times t) {
    std::printf("  %-24s median %8.4f ms  least %8.4f ms\n", what, t.median_ms, t.least_ms);
  };
  line("levels of detail", lod);
  line("culling and draw list", culled);
  std::printf("  %-24s median %8.4f ms\n", "both", lod.median_ms + culled.median_ms);
  line("index stream", expanded);
  std::printf("  %-24s        %8.2f GB/s written\n", "",
              static_cast<double>(indices) * sizeof(std::uint32_t) / (expanded.median_ms * 1e6));
  line("of scattered pages", scattered);
  std::printf("  %-24s        %8.2f GB/s written\n", "",
              static_cast<double>(indices) * sizeof(std::uint32_t) / (scattered.median_ms * 1e6));
  line("box hierarchy, all anew", refit);
  std::printf("  by error: %u drawn, %u triangles\n", by_error.list.drawn, by_error.list.triangles);
  line("thresholds, all anew", by_error.thresholds);
  line("rows for the GPU", by_error.rows);
  line("levels by error", by_error.levels);
  line("culling and draw list", by_error.listed);
  std::printf("  %-24s median %8.4f ms\n", "both", by_error.levels.median_ms + by_error.listed.median_ms);
  return ok && indices == 3u * list.triangles ? 0 : 1;
}

int run_view(bool smoke) {
  const int repeats = smoke ? 1 : 1'000;
  int failed = run_scene("K's size, corner", 59, {2.0, 22.0, 58.0}, -40.0, repeats);
  failed |= run_scene("K's size, middle", 59, {30.0, 22.0, 30.0}, 0.0, repeats);
  if (!smoke) failed |= run_scene("large", 500, {250.0, 30.0, 250.0}, 30.0, repeats / 10);
  return failed;
}

const bench::Register registered{{"view", run_view}};

}  // namespace
}  // namespace karst::core
