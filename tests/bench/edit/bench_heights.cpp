// SPDX-License-Identifier: MIT
// What a dab on heights of patches costs, by tool: inside one patch, and over several; with all that follows
// in the core, and vertices of all patches that are touched, at the finest level.
#include <cstdio>
#include <cstring>
#include <vector>

#include "terrain/edit/patch/edit_heights.h"
#include "terrain/patch/displacement.h"
#include "tests/bench/bench.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

constexpr const char* kNames[] = {"clear", "fill", "extrude", "smooth", "noise", "flatten", "level", "paint"};

int run_heights(bool smoke) {
  constexpr int kLevel = 5;
  const std::vector<std::byte> file = test::wide_world(kLevel).file();
  WorldReader reader;
  if (!reader.open(ByteSource::of(file)).ok()) return 1;
  Config config = World::config_for(reader.info(), kLevel);
  World::add_edit_room(500, config);
  test::LoadedParts live(config);
  if (!live.load(ByteSource::of(file)).ok()) return 1;
  World& world = live.world;
  const World::Editable all = world.edit(0);
  // The middle of a patch in the middle of the world that faces up.
  const glm::dvec3 middle = glm::dvec3(world.info().extent) / 2.0;
  glm::dvec3 place(0.0);
  for (PatchId p = 0; p < all.surface.patches.size(); ++p) {
    if (all.surface.is_free(p) || all.patches[p].collapsed != 0) continue;
    const BasePoint base = base_point(all.surface, kLevel, p, 16, 16);
    if (base.direction.y < 0.9) continue;
    const std::uint32_t block = all.patches[p].height_block;
    const double height =
        block == kNoHeights ? 0 : all.heights->block(block)[16 * 33 + 16] / double{kStepsPerVoxel};
    const glm::dvec3 at = glm::dvec3(patch_origin(all.surface.volume_of(p))) / double{kStepsPerVoxel} +
                          base.position + base.direction * height;
    const glm::dvec3 away = at - middle, best = place - middle;
    if (away.x * away.x + away.z * away.z < best.x * best.x + best.z * best.z) place = at;
  }
  const int repeats = smoke ? 2 : 202;
  int result = 0;
  std::printf("dabs on heights of patches at level %d, microseconds (median, least):\n", kLevel);
  for (const double radius : {0.25, 0.75}) {
    for (const EditTool tool :
         {EditTool::extrude, EditTool::smooth, EditTool::noise, EditTool::flatten, EditTool::level}) {
      Edit edit;
      edit.tool = tool;
      edit.place = place;
      edit.radius = radius;
      edit.strength = 0.02;
      edit.wave = 0.3;
      EditChange change;
      std::size_t changed = 0;
      int n = 0;
      const bench::Times whole = bench::measure(repeats, [&] {
        edit.strength = -edit.strength;
        edit.amount = tool == EditTool::smooth ? 1 : 0.5;
        // Flat places go on being changed.
        edit.place.y = place.y + (++n % 2 == 0 ? 0.02 : -0.02);
        if (!edit_heights(world, edit, nullptr, change).ok()) result = 1;
        changed += change.changed;
      });
      if (changed == 0) result = 1;
      const std::vector<PatchId> touched(change.touched.begin(), change.touched.end());
      const auto count = static_cast<std::size_t>(patch_vertices(kLevel));
      std::vector<GpuVertex> vertices(count * touched.size()), stream(vertices.size());
      const bench::Times made = bench::measure(repeats, [&] {
        for (std::size_t k = 0; k < touched.size(); ++k) {
          if (!live.residency
                   .generate(touched[k], kLevel, kLevel, std::span(vertices).subspan(k * count, count))
                   .ok())
            result = 1;
        }
      });
      const bench::Times written = bench::measure(
          repeats, [&] { std::memcpy(stream.data(), vertices.data(), vertices.size() * sizeof(GpuVertex)); });
      std::printf(
          "  %-8s radius %.2f, %3zu touched: %.0f %.0f; vertices %.0f %.0f, writing their %zu KiB %.1f (%.0f"
          " times)\n",
          kNames[static_cast<int>(tool)], radius, touched.size(), 1e3 * whole.median_ms, 1e3 * whole.least_ms,
          1e3 * made.median_ms, 1e3 * made.least_ms, vertices.size() * sizeof(GpuVertex) / 1024,
          1e3 * written.median_ms, (whole.median_ms + made.median_ms) / written.median_ms);
    }
  }
  return result;
}

const bench::Register kRegister{{"heights", run_heights}};

}  // namespace
}  // namespace karst::core
