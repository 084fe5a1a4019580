// SPDX-License-Identifier: MIT
// What an edit of voxels costs, stage by stage, in time on a core: a voxel of the surface taken out and put
// back, seen from far and from near, and holes. Its octree, extraction and links; all that is done at once in
// the world; what thresholds and shading follow; vertices that change, at the levels that are resident; what
// is left for later frames; and writing as many bytes as vertices have.
#include <cstdio>
#include <cstring>
#include <vector>

#include "terrain/edit/settle.h"
#include "terrain/edit/shape/edit_octree.h"
#include "terrain/edit/shape/edit_shape.h"
#include "terrain/surface/bezier/extract_surface.h"
#include "terrain/surface/bezier/update_surface.h"
#include "tests/bench/bench.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

constexpr int kLevel = 5;
constexpr std::uint32_t kFramePatches = 128;  // as frames with a limit of time have
constexpr std::size_t kExactBoxes = 32;       // PendingDig::kExact
constexpr std::uint32_t kFittedBoxes = 120'000 / patch_vertices(kLevel);  // PendingDig::kFittedVertices

class EditBench {
 public:
  explicit EditBench(test::LoadedParts& live) : live_(live), world_(live.world) {
    const glm::ivec3 extent = world_.info().extent;
    // The highest voxel in the middle.
    top_ = glm::ivec3(extent.x / 2, extent.y - 1, extent.z / 2);
    while (top_.y > 0 && !world_.octree().filled(top_)) --top_.y;
    // Takes any pool that the whole world fits in.
    vertices_.resize(std::size_t{20'000} * patch_vertices(kLevel));
  }

  // Looks at the place from so many voxels away, until nothing lacks.
  bool look(double away) {
    const Camera camera =
        test::camera_at(glm::dvec3(top_) + glm::dvec3(0.5, 0.5 + 0.5 * away, 0.5 + away), 0, 60, -26);
    request_.camera = &camera;
    request_.lod = {.mode = LodMode::error, .max_level = kLevel, .resident_level = kLevel, .error_px = 1};
    request_.width_px = 1280;
    request_.height_px = 720;
    for (int frame = 0; frame < 200; ++frame) {
      live_.residency.begin_frame();
      if (!live_.select(request_).ok()) return false;
      while (!live_.residency.take_morph_rows().halves.empty()) {
      }
      if (live_.generate() == 0 && frame > 4) return true;
    }
    return false;
  }

  bool run(const char* name, double radius, int repeats) {
    Edit edit;
    edit.shape = radius > 0 ? BrushShape::sphere : BrushShape::voxel;
    edit.octree_level = static_cast<std::uint8_t>(world_.octree().depth());
    edit.place = glm::dvec3(top_) + 0.5;
    edit.radius = radius;
    std::vector<double> made, followed, vertices, settled, longest, later, boxes;
    int box_calls = 0;
    std::size_t touched = 0, bytes = 0, rows = 0;
    int levels[kMaxLevel + 1] = {}, later_frames = 0;
    for (int n = 0; n < 2 * repeats; ++n) {
      edit.tool = n % 2 == 0 ? EditTool::clear : EditTool::fill;
      live_.residency.begin_frame();
      double start = bench::cpu_ms();
      EditChange change;
      if (!edit_part(world_, 0, edit, nullptr, change, kExactBoxes).ok() || !change.changed) return false;
      made.push_back(bench::cpu_ms() - start);
      touched = std::max(touched, change.touched.size());
      start = bench::cpu_ms();
      live_.residency.follow_edit(change.touched, change.rows, change.vanished);
      followed.push_back(bench::cpu_ms() - start);
      bytes = 0;
      for (int& level : levels) level = 0;
      start = bench::cpu_ms();
      remake(bytes, levels);
      vertices.push_back(bench::cpu_ms() - start);
      start = bench::cpu_ms();
      std::size_t more = 0;
      int frames = 0;
      for (; live_.residency.has_plain(); ++frames) {
        live_.residency.begin_frame();
        remake(more, levels);
      }
      later.push_back(frames > 0 ? (bench::cpu_ms() - start) / frames : 0);
      later_frames = std::max(later_frames, frames);
      rows = 0;
      for (MorphRows made_rows; !(made_rows = live_.residency.take_morph_rows()).halves.empty();)
        rows += made_rows.halves.size_bytes();
      fit_boxes(boxes, box_calls);
      settle(settled, longest);
      // What is new gets its vertices.
      if (!live_.select(request_).ok()) return false;
      live_.generate();
    }
    std::vector<GpuVertex> stream(std::max<std::size_t>(bytes / sizeof(GpuVertex), 1));
    const double written = 1e3 * bench::measure_cpu(repeats, [&] {
                                   std::memcpy(stream.data(), vertices_.data(), bytes);
                                 }).median_ms;
    const double links = 1e3 * measure_links(edit, repeats).median_ms;
    const auto us = [](std::vector<double> ms) { return 1e3 * bench::times_of(std::move(ms)).median_ms; };
    const double all = us(made) + us(followed) + us(vertices);
    std::printf(
        "  %-14s %4zu patches, %6.1f KiB of vertices, %5.1f of rows; links %6.1f; world %7.1f; follow "
        "%6.1f; vertices %7.1f; at once %7.1f; writing %6.1f (%.0f times); vertices of %d frames "
        "more %6.1f each; boxes in %d calls, %6.1f at most; later %8.1f (a step %.0f at most)\n",
        name, touched, static_cast<double>(bytes) / 1024, static_cast<double>(rows) / 1024, links, us(made),
        us(followed), us(vertices), all, written, all / std::max(written, 0.01), later_frames, us(later),
        box_calls, us(boxes), us(settled), us(longest));
    return true;
  }

 private:
  void remake(std::size_t& bytes, int (&levels)[kMaxLevel + 1]) {
    PatchUpload upload;
    Status status;
    std::size_t at = 0;
    std::uint32_t most = kFramePatches;
    while (live_.residency.remake_next(upload, status, most)) {
      // As the renderer does, into memory that the GPU reads.
      std::memcpy(vertices_.data() + at, upload.vertices.data(), upload.vertices.size_bytes());
      at += upload.vertices.size();
      ++levels[live_.residency.pool().level(upload.patch)];
    }
    bytes = at * sizeof(GpuVertex);
  }

  // The longest call.
  void fit_boxes(std::vector<double>& longest, int& calls) {
    double most = 0;
    int count = 0;
    LatticeBox tight{};
    for (bool more = true; more && world_.edit(0).queue->loose() > 0; ++count) {
      const double start = bench::cpu_ms();
      Settled done;
      for (std::uint32_t n = 0; n < kFittedBoxes && more; ++n) {
        more = fit_next(world_, 0, done, tight);
        if (more) live_.residency.follow_measures(done.measured);
      }
      most = std::max(most, bench::cpu_ms() - start);
    }
    longest.push_back(most);
    calls = std::max(calls, count);
  }

  void settle(std::vector<double>& settled, std::vector<double>& longest) {
    const double start = bench::cpu_ms();
    double most = 0;
    while (!world_.is_settled()) {
      const double began = bench::cpu_ms();
      Settled done;
      settle_some(world_, done);
      if (done.measured != Settled::kNone) live_.residency.follow_measures(done.measured);
      if (done.sky_changed) live_.residency.follow_sky(done.part);
      most = std::max(most, bench::cpu_ms() - began);
    }
    settled.push_back(bench::cpu_ms() - start);
    longest.push_back(most);
    PatchUpload upload;
    Status status;
    while (live_.residency.remake_next(upload, status)) {
    }
  }

  // Octree, extraction and links alone, of voxels that are taken out and put back, so that nothing remains.
  bench::Times measure_links(const Edit& edit, int repeats) {
    const World::Editable all = world_.edit(0);
    Octree& octree = *all.octree;
    const VoxelShape shape(edit, octree.depth(), glm::ivec3(0), all.extent - glm::ivec3(1, 2, 1));
    std::vector<double> ms;
    for (int n = 0; n < 2 * repeats; ++n) {
      const double start = bench::cpu_ms();
      const EditOctree make{&octree, &shape, n % 2 != 0};
      EditOctree::Result made;
      const Octree::Node old_root = octree.root();
      bool ok = make.run(made).ok();
      octree.set_root(made.root);
      const CornerBox box = corners_touched(made.low, made.high);
      ExtractSurface extract;
      extract.octree = &octree;
      extract.extent = all.extent;
      extract.low = box.low;
      extract.high = box.high;
      extract.volumes = all.room->volumes;
      extract.patches = all.room->patches;
      extract.scratch = all.room->table;
      ExtractSurface::Result fresh;
      ok = extract.run(fresh).ok() && ok;
      UpdateSurface update;
      update.fresh = {all.room->volumes.first(fresh.volumes), all.room->patches.first(fresh.patches)};
      update.box = box;
      update.slots = all.slots;
      update.changes = all.room->changes;
      UpdateSurface::Result updated;
      std::uint32_t before = 0;
      ok = update.check(before).ok() && update.run(updated).ok() && ok;
      EditOctree::release(octree, old_root, made.root);
      if (!ok) std::abort();
      ms.push_back(bench::cpu_ms() - start);
    }
    return bench::times_of(std::move(ms));
  }

  test::LoadedParts& live_;
  World& world_;
  glm::ivec3 top_{0};
  ViewRequest request_;
  std::vector<GpuVertex> vertices_;
};

int run_edit(bool smoke) {
  const std::vector<std::byte> file = test::wide_world(kLevel).file();
  const int repeats = smoke ? 1 : 51;
  const struct {
    const char* name;
    double away, radius;
  } cases[] = {{"voxel, far", 40, 0},
               {"voxel, near", 3, 0},
               {"hole 3, far", 40, 3},
               {"hole 3, near", 3, 3},
               {"hole 10, far", 40, 10}};
  std::printf("edits at level %d, microseconds of CPU time, medians:\n", kLevel);
  for (const auto& [name, away, radius] : cases) {
    WorldReader reader;
    if (!reader.open(ByteSource::of(file)).ok()) return 1;
    Config config = World::config_for(reader.info(), kLevel, 100'000);
    World::add_edit_room(8'000, config);
    test::LoadedParts live(config);
    if (!live.load(ByteSource::of(file)).ok()) return 1;
    EditBench edits(live);
    if (!edits.look(away) || !edits.run(name, radius, repeats)) return 1;
  }
  return 0;
}

const bench::Register kRegister{{"edit", run_edit}};

}  // namespace
}  // namespace karst::core
