// SPDX-License-Identifier: MIT
// What steps cost: an edit of voxels without and with what is kept of it, taking it back, doing it again; and
// the bytes that its step takes of Needs::undo_bytes. A voxel of the surface, and a hole of three voxels'
// radius. And a stroke of 60 dabs: all of it, and the longest of its parts, one of which a frame waits for.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "terrain/edit/shape/edit_shape.h"
#include "terrain/edit/undo/take_part.h"
#include "tests/bench/bench.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

double median(std::vector<double>& times_ms) {
  std::ranges::nth_element(times_ms, times_ms.begin() + static_cast<std::ptrdiff_t>(times_ms.size() / 2));
  return 1e3 * times_ms[times_ms.size() / 2];
}

Status edit_shape_or_heights(World& world, const Edit& edit, UndoLog* log, EditChange& change) {
  return edits_voxels(edit.tool) ? edit_shape(world, edit, log, change)
                                 : edit_heights(world, edit, log, change);
}

int run_undo(bool smoke) {
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
  glm::ivec3 top(extent.x / 2, extent.y - 1, extent.z / 2);
  while (top.y > 0 && !world.octree().filled(top)) --top.y;
  std::vector<std::uint64_t> memory(std::size_t{4} << 17);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  const int repeats = smoke ? 1 : 51;
  int result = 0;
  for (const bool hole : {false, true}) {
    Edit edit;
    edit.shape = hole ? BrushShape::sphere : BrushShape::voxel;
    edit.octree_level = static_cast<std::uint8_t>(world.octree().depth());
    edit.place = glm::dvec3(top) + 0.5;
    edit.radius = 3;
    EditChange change;
    std::size_t bytes = 0, heights = 0;
    std::vector<double> plain, kept, undone, redone;
    const auto timed = [](std::vector<double>& to, const auto& work) {
      to.push_back(bench::measure(1, work).median_ms);
    };
    const auto back = [&] {
      const bool found = log.undo([&](UndoPart part) {
        bytes = heights = 0;
        for (const UndoCell cell : part) {
          bytes += UndoLog::cell_bytes(cell.bytes.size());
          heights += cell.kind == CellKind::patch_heights;
        }
        undo_shape(world, part, change);
      });
      if (!found || !change.changed) result = 1;
    };
    for (int n = 0; n < repeats; ++n) {
      const auto make = [&](UndoLog* to) {
        if (!edit_shape(world, edit, to, change).ok() || !change.changed) result = 1;
      };
      edit.tool = EditTool::clear;
      timed(plain, [&] { make(nullptr); });
      edit.tool = EditTool::fill;
      make(nullptr);
      edit.tool = EditTool::clear;
      log.begin();
      timed(kept, [&] { make(&log); });
      log.end();
      timed(undone, back);
      timed(redone, [&] { log.redo([&](UndoPart part) { redo_shape(world, part, change); }); });
      back();
    }
    std::printf(
        "  %-6s microseconds (median): edit %.0f, kept as a step %.0f, taken back %.0f, done again %.0f;"
        " %zu bytes, %zu patches\n",
        hole ? "hole" : "voxel", median(plain), median(kept), median(undone), median(redone), bytes, heights);
  }
  return result;
}

int run_stroke(bool smoke) {
  constexpr int kLevel = 5, kDabs = 60;
  const std::vector<std::byte> file = test::wide_world(kLevel).file();
  WorldReader reader;
  if (!reader.open(ByteSource::of(file)).ok()) return 1;
  Config config = World::config_for(reader.info(), kLevel);
  World::add_edit_room(4'000, config);
  test::LoadedParts live(config);
  if (!live.load(ByteSource::of(file)).ok()) return 1;
  World& world = live.world;
  const glm::ivec3 extent = world.info().extent;
  std::vector<std::uint64_t> memory(std::size_t{64} << 17);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  int result = 0;
  for (const EditTool tool : {EditTool::clear, EditTool::extrude}) {
    std::vector<double> back, again;
    std::size_t parts = 0;
    const auto take = [&](bool undo, std::vector<double>& times) {
      parts = 0;
      const auto one = [&](UndoPart part) {
        const double start = bench::cpu_ms();
        take_part(world, part, undo, [](const EditChange&) {});
        times.push_back(bench::cpu_ms() - start);
        ++parts;
      };
      if (!(undo ? log.undo(one) : log.redo(one))) result = 1;
    };
    log.begin();
    for (int n = 0; n < kDabs; ++n) {
      glm::ivec3 top(extent.x / 4 + n * extent.x / (2 * kDabs), extent.y - 1, extent.z / 2);
      while (top.y > 0 && !world.octree().filled(top)) --top.y;
      Edit edit;
      edit.tool = tool;
      edit.place = glm::dvec3(top) + 0.5;
      edit.radius = 3;
      edit.strength = 0.2;
      EditChange change;
      if (!edit_shape_or_heights(world, edit, &log, change).ok()) result = 1;
    }
    log.end();
    const int repeats = smoke ? 1 : 5;
    for (int n = 0; n < repeats; ++n) {
      take(true, back);
      take(false, again);
    }
    take(true, back);
    const auto print = [&](const char* name, const std::vector<double>& times) {
      double all = 0;
      for (const double ms : times) all += ms;
      const double rounds = static_cast<double>(times.size()) / static_cast<double>(parts);
      std::printf(" %s %.1f ms, its longest part %.2f;", name, all / rounds,
                  *std::ranges::max_element(times));
    };
    std::printf("  stroke of %d dabs, %s, %zu parts:", kDabs, tool == EditTool::clear ? "holes" : "heights",
                parts);
    print("taken back", back);
    print("done again", again);
    std::printf("\n");
  }
  return result;
}

const bench::Register kRegister{
    {"undo", [](bool smoke) { return std::max(run_undo(smoke), run_stroke(smoke)); }}};

}  // namespace
}  // namespace karst::core
