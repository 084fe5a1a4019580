// SPDX-License-Identifier: MIT
// What an edit of voxels costs: a voxel of the surface taken out and put back, and a hole of three voxels'
// radius, with all that follows in the core; rock that hides and sky visibility of that, which are found anew
// over the whole world; vertices of all patches that are touched, at the finest level; and writing as many
// bytes.
#include <cstdio>
#include <cstring>
#include <vector>

#include "terrain/edit/shape/edit_shape.h"
#include "tests/bench/bench.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

int run_edit(bool smoke) {
  constexpr int kLevel = 5;
  const std::vector<std::byte> file = test::wide_world(kLevel).file();
  WorldReader reader;
  if (!reader.open(ByteSource::of(file)).ok()) return 1;
  Config config = World::config_for(reader.info(), kLevel);
  World::add_edit_room(4'000, config);
  test::LoadedParts live(config);
  if (!live.load(ByteSource::of(file)).ok()) return 1;
  World& world = live.world;
  const glm::ivec3 extent = world.info().extent;
  // The highest voxel in the middle.
  glm::ivec3 top(extent.x / 2, extent.y - 1, extent.z / 2);
  while (top.y > 0 && !world.octree().filled(top)) --top.y;
  const int repeats = smoke ? 1 : 101;
  int result = 0;
  std::printf("edits, %u patches at level %d, microseconds (median, least):\n",
              world.patch_count() - world.free_patches(), kLevel);
  for (const bool hole : {false, true}) {
    Edit edit;
    edit.shape = hole ? BrushShape::sphere : BrushShape::voxel;
    edit.octree_level = static_cast<std::uint8_t>(world.octree().depth());
    edit.place = glm::dvec3(top) + 0.5;
    edit.radius = 3;
    EditChange change;
    bool dig = true;
    const bench::Times whole = bench::measure(2 * repeats, [&] {
      edit.tool = dig ? EditTool::clear : EditTool::fill;
      dig = !dig;
      if (!edit_shape(world, edit, change).ok() || !change.changed) result = 1;
    });
    std::vector<PatchId> touched(change.touched.begin(), change.touched.end());
    const World::Editable all = world.edit(0);
    const bench::Times rock = bench::measure(
        repeats, [&] { all.occluders->build(*all.octree, all.extent, all.surface, all.bounds); });
    const bench::Times sky = bench::measure(repeats, [&] { all.sky->build(*all.octree, all.extent); });
    const auto count = static_cast<std::size_t>(patch_vertices(kLevel));
    std::vector<GpuVertex> vertices(count * touched.size()), stream(vertices.size());
    const bench::Times made = bench::measure(repeats, [&] {
      for (std::size_t n = 0; n < touched.size(); ++n) {
        if (!live.residency
                 .generate(touched[n], kLevel, kLevel, std::span(vertices).subspan(n * count, count))
                 .ok())
          result = 1;
      }
    });
    const bench::Times written = bench::measure(
        repeats, [&] { std::memcpy(stream.data(), vertices.data(), vertices.size() * sizeof(GpuVertex)); });
    std::printf(
        "  %-6s %4zu touched: all %.0f %.0f, of that rock %.0f %.0f, sky %.0f %.0f;"
        " vertices %.0f %.0f, writing their %zu KiB %.1f (%.0f times)\n",
        hole ? "hole" : "voxel", touched.size(), 1e3 * whole.median_ms, 1e3 * whole.least_ms,
        1e3 * rock.median_ms, 1e3 * rock.least_ms, 1e3 * sky.median_ms, 1e3 * sky.least_ms,
        1e3 * made.median_ms, 1e3 * made.least_ms, vertices.size() * sizeof(GpuVertex) / 1024,
        1e3 * written.median_ms, made.median_ms / written.median_ms);
  }
  return result;
}

const bench::Register kRegister{{"edit", run_edit}};

}  // namespace
}  // namespace karst::core
