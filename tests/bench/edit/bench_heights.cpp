// SPDX-License-Identifier: MIT
// What a dab on heights of patches costs, by tool: inside one patch, and over several. Patches that are
// touched are resident at the finest level. With all that follows in the core, thresholds and shading, and
// vertices that change, copied.
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

constexpr int kLevel = 5;

bool hold(test::LoadedParts& live, std::span<const PatchId> patches) {
  for (const PatchId patch : patches) {
    PatchUpload upload;
    Status status;
    if (live.residency.pool().level(patch) < kLevel &&
        !live.residency.make_resident(patch, kLevel, upload, status))
      return false;
  }
  return true;
}

struct Remade {
  std::size_t bytes = 0;
  std::size_t patches = 0;
};

// As the renderer does, into memory that the GPU reads.
Remade remake(test::LoadedParts& live, std::span<GpuVertex> stream) {
  Remade made;
  PatchUpload upload;
  Status status;
  PatchId last = 0xffffffffu;
  while (live.residency.remake_next(upload, status)) {
    std::memcpy(stream.data() + made.bytes / sizeof(GpuVertex), upload.vertices.data(),
                upload.vertices.size_bytes());
    made.bytes += upload.vertices.size_bytes();
    made.patches += upload.patch != last;
    last = upload.patch;
  }
  return made;
}

int run_heights(bool smoke) {
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
  const std::vector<GpuVertex> source(std::size_t{40} * patch_vertices(kLevel));
  std::printf("dabs on heights of patches at level %d, microseconds of CPU time, medians:\n", kLevel);
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
      // All that a dab touches is resident at the finest level.
      if (!edit_heights(world, edit, nullptr, change).ok() || !change.changed) return 1;
      if (!hold(live, change.touched)) return 1;
      std::vector<double> made, followed, vertices;
      std::vector<GpuVertex> stream(change.touched.size() * patch_vertices(kLevel));
      std::size_t touched = 0, bytes = 0, remade = 0;
      for (int n = 0; n < repeats; ++n) {
        live.residency.begin_frame();
        edit.strength = -edit.strength;
        edit.amount = tool == EditTool::smooth ? 1 : 0.5;
        // Flat places go on being changed.
        edit.place.y = place.y + (n % 2 == 0 ? 0.02 : -0.02);
        double start = bench::cpu_ms();
        if (!edit_heights(world, edit, nullptr, change).ok()) return 1;
        made.push_back(bench::cpu_ms() - start);
        if (!change.changed) continue;
        touched = std::max(touched, change.touched.size());
        start = bench::cpu_ms();
        live.residency.follow_edit(change.touched, change.rows, change.vanished);
        followed.push_back(bench::cpu_ms() - start);
        start = bench::cpu_ms();
        const Remade now = remake(live, stream);
        vertices.push_back(bench::cpu_ms() - start);
        bytes = std::max(bytes, now.bytes);
        remade = std::max(remade, now.patches);
        while (!live.residency.take_morph_rows().halves.empty()) {
        }
      }
      const bench::Times written =
          bench::measure_cpu(repeats, [&] { std::memcpy(stream.data(), source.data(), bytes); });
      const auto us = [](std::vector<double> ms) { return 1e3 * bench::times_of(std::move(ms)).median_ms; };
      const double whole = us(made) + us(followed) + us(vertices);
      std::printf(
          "  %-8s radius %.2f, %3zu touched, %2zu made: core %.0f; follow %.1f; vertices %.1f; at once %.0f; "
          "writing %.1f KiB %.1f (%.0f times)\n",
          kNames[static_cast<int>(tool)], radius, touched, remade, us(made), us(followed), us(vertices),
          whole, static_cast<double>(bytes) / 1024, 1e3 * written.median_ms,
          whole / std::max(1e3 * written.median_ms, 0.01));
    }
  }
  return 0;
}

const bench::Register kRegister{{"heights", run_heights}};

}  // namespace
}  // namespace karst::core
