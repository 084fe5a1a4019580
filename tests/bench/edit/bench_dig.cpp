// SPDX-License-Identifier: MIT
// Digging where there is only ground: a hole of 20 m in voxels of 1 m, and what making its region takes.
#include <cstdio>
#include <memory>
#include <vector>

#include "terrain/edit/regions/make_region.h"
#include "terrain/edit/regions/region_growth.h"
#include "terrain/edit/settle.h"
#include "terrain/edit/shape/edit_shape.h"
#include "tests/bench/bench.h"
#include "tests/library/ground_file.h"
#include "tests/support/ground_editor.h"
#include "tests/support/test_world.h"

#include "terrain/world/terrain_parts.h"

namespace karst::core::bench {
namespace {

constexpr std::int64_t kSide = 257;
constexpr double kRadius = 10;
constexpr std::uint32_t kPatches = 4'096;
constexpr std::size_t kExactBoxes = 32;       // PendingDig::kExact
constexpr std::uint32_t kFittedBoxes = 256;   // PendingDig::kFitted
constexpr std::uint32_t kFramePatches = 512;  // of bases, as frames with a limit of time have

double height(double x, double z) {
  return 40 + 9 * test::value_noise(3, glm::dvec3(x, 0, z) / 25.0);
}

// All that a world with room for one region takes.
class GroundToDig {
 public:
  explicit GroundToDig(const test::MemoryGround& ground)
      : file_(test::ground_file(ground, 1.0)), editor(ground, 600) {
    WorldReader reader;
    Status status = reader.open(ByteSource::of(file_));
    Config config = World::config_for(reader.info(), reader.info().level, reader.ground());
    World::add_dig_room(reader.info(), reader.ground(), 1, kPatches, config);
    World::add_edit_room(kPatches, config);
    memory_ = test::AlignedBytes(static_cast<std::size_t>(terrain_budget(config).cpu_bytes()));
    if (status.ok()) status = parts.create(config, memory_.bytes());
    if (status.ok()) status = parts.load(ByteSource::of(file_));
    is_ok = status.ok();
  }

 private:
  std::vector<std::byte> file_;
  test::AlignedBytes memory_{0};

 public:
  test::GroundEditor editor;
  TerrainParts parts;
  bool is_ok = false;
};

int run_dig(bool smoke) {
  const auto ground = test::MemoryGround::to_dig(kSide, kSide, 8192, [](std::int64_t i, std::int64_t k) {
    return static_cast<std::int32_t>(height(double(i), double(k)) * kStepsPerVoxel / kVertexStep);
  });
  std::vector<double> begin_ms, make_ms, step_ms, parts_ms, edit_ms, boxes_ms, box_ms, growth_ms, shown_ms,
      vertices_ms, later_ms;
  std::uint32_t patches = 0, changed = 0, steps = 0, frames = 0;
  for (int n = 0; n < (smoke ? 1 : 9); ++n) {
    const auto dug = std::make_unique<GroundToDig>(ground);
    if (!dug->is_ok) return 1;
    World& world = dug->parts.world;
    Edit hole;
    hole.place = {128, height(128, 128), 128};
    hole.radius = kRadius;
    double start = cpu_ms();
    const auto lap = [&](std::vector<double>& out) {
      const double now = cpu_ms();
      out.push_back(now - start);
      start = now;
    };
    const auto bottom = static_cast<std::int32_t>(hole.place.y - kRadius) - 24;
    MakeRegion make{&world, &dug->editor.edits, {{28, 28}, {36, 36}}, bottom, bottom + 70};
    bool changes = false;
    if (!make.begin().ok() || !try_part(world, 0, hole, changes).ok() || !changes) return 1;
    lap(begin_ms);
    steps = 0;
    double most = 0, all = 0;
    for (bool done = false; !done; ++steps) {
      done = make.step();
      std::vector<double> one;
      lap(one);
      most = std::max(most, one[0]);
      all += one[0];
      if (done) parts_ms.push_back(one[0]);
    }
    step_ms.push_back(most);
    make_ms.push_back(all);
    patches = make.patches;
    EditChange change;
    if (!edit_part(world, 0, hole, nullptr, change, kExactBoxes).ok() || !change.changed) return 1;
    lap(edit_ms);
    Settled fitted;
    most = 0;
    all = 0;
    for (bool more = true; more; ++steps) {
      for (std::uint32_t k = 0; k < kFittedBoxes && more; ++k)
        more = fit_next(world, 0, fitted, change.tight);
      std::vector<double> one;
      lap(one);
      most = std::max(most, one[0]);
      all += one[0];
    }
    boxes_ms.push_back(all);
    box_ms.push_back(most);
    changed = static_cast<std::uint32_t>(change.touched.size());
    world.open_region();
    const LatticeBox whole{glm::ivec3(0), world.parts()[0].extent * kStepsPerVoxel};
    const RegionGrowth growth = FindRegionGrowth{&world, &dug->editor.edits, 0, whole}.run();
    GroundChange grown;
    dug->editor.edits.grow_region(0, growth, nullptr, grown);
    lap(growth_ms);
    dug->parts.residency.follow_region(0);
    lap(shown_ms);
    Status status;
    frames = 0;
    most = 0;
    do {
      std::uint32_t left = kFramePatches;
      for (PatchUpload upload; dug->parts.residency.generate_base(upload, status, left);) {
      }
      std::vector<double> one;
      lap(one);
      most = std::max(most, one[0]);
      ++frames;
    } while (dug->parts.residency.fresh_parts() != 0 && status.ok());
    if (!status.ok()) return 1;
    vertices_ms.push_back(most);
    while (!world.is_settled()) {
      Settled done;
      settle_some(world, done);
    }
    lap(later_ms);
  }
  const auto median = [](std::vector<double>& ms) { return times_of(ms).median_ms; };
  std::printf("dig: a hole of %.0f voxels' radius where there is only ground: %u patches, %u touched\n",
              kRadius, patches, changed);
  std::printf(
      "  the call %.2f ms; %u parts; region %.2f in all, one %.2f at most, the last %.2f; hole %.2f; "
      "boxes "
      "%.2f in all, %.2f at most; to show it %.2f, of which nodes around %.2f; coarse vertices in %u frames, "
      "%.2f at most; "
      "later %.0f\n",
      median(begin_ms), steps, median(make_ms), median(step_ms), median(parts_ms), median(edit_ms),
      median(boxes_ms), median(box_ms), median(growth_ms) + median(shown_ms), median(growth_ms), frames,
      median(vertices_ms), median(later_ms));
  return 0;
}

const Register kDig{{"dig", run_dig}};

}  // namespace
}  // namespace karst::core::bench
