// SPDX-License-Identifier: MIT
// What culling of back-facing patches and of those behind rock saves and costs: the same frames of a flight
// with frustum culling alone, with normal cones, and with rock that hides, through halls in rock and over
// open hills, where nothing is hidden. Counts are means a frame, times medians; "jump" is the frame after the
// camera has jumped to another place, which happens every 120 frames.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "terrain/cull/occlusion.h"
#include "terrain/draw/draw_list.h"
#include "tests/bench/bench.h"
#include "tests/support/culled_view.h"
#include "tests/support/morphed_surface.h"

namespace karst::core {
namespace {

constexpr int kLevel = 3;
constexpr std::uint32_t kSearches = 128;  // ViewRequest's default

struct Ways {
  const char* name;
  bool cones, rock;
};
constexpr Ways kWays[] = {{"frustum", false, false}, {"and cones", true, false}, {"and rock", true, true}};

class Flight {
 public:
  explicit Flight(const test::TestWorld& source)
      : source_(source),
        world_(source),
        patches_(static_cast<std::uint32_t>(world_.patches())),
        nodes_(BoundsTree::node_count(patches_)),
        culled_(world_.surface(), world_.bounds()),
        words_(Occluders::word_count(source.extent(), Occluders::kLeastCellLog2)),
        entries_(Occlusion::entry_count(patches_)),
        cones_(patches_),
        levels_(patches_, kLevel),
        scratch_(patches_),
        items_(patches_) {
    tree_.create(nodes_);
    ok_ = tree_.build(world_.surface(), world_.bounds()).ok();
    occluders_.create(words_);
    build_ms_ = bench::measure(5, [&] {
                  occluders_.build(source_.octree(), source_.extent(), world_.surface(), world_.bounds());
                }).median_ms;
    occlusion_.create(entries_, patches_);
    MeasureNormalCones measure;
    measure.surface = world_.surface();
    measure.heights = world_.heights();
    measure.cones = cones_;
    measure.run(0, patches_);
  }

  // A flight from one place in the air to others, turning as it goes. above: over the ground instead.
  int run(const char* name, bool above, int frames) {
    std::printf("rock, %s: %u patches, %llu of %llu half voxels hide, found in %.2f ms\n", name, patches_,
                static_cast<unsigned long long>(occluders_.count(Occluders::Kind::rock)),
                static_cast<unsigned long long>(8 * source_.octree().count_filled()), build_ms_);
    std::printf("  %-10s %8s %10s %10s %10s %10s %10s\n", "", "listed", "backface", "occluded", "us",
                "jump us", "searches");
    for (const Ways& way : kWays) fly(way, above, frames);
    return ok_ ? 0 : 1;
  }

 private:
  glm::dvec3 place(test::Random& random, bool above) const {
    const glm::dvec3 extent(source_.extent());
    for (;;) {
      glm::dvec3 p = extent * glm::dvec3(random.unit(), random.unit(), random.unit());
      if (above) p.y = extent.y + 4.0 * random.unit();
      if (occluders_.is_outside(source_.octree(), tree_, world_.surface(), world_.bounds(),
                                p * double{kStepsPerVoxel}, 0.3 * kStepsPerVoxel)) {
        return p;
      }
    }
  }

  void fly(const Ways& way, bool above, int frames) {
    test::Random random{501};
    std::vector<double> us;
    std::vector<double> jump_us;
    double listed = 0;
    double back = 0;
    double hidden = 0;
    double searches = 0;
    CameraSettings settings;
    constexpr int kFramesAPlace = 120;
    occlusion_.reset();
    for (int n = 0; n < frames; ++n) {
      if (n % kFramesAPlace == 0) {
        settings.position = place(random, above);
        settings.yaw_deg = 360 * random.unit();
        settings.pitch_deg = above ? -25.0 : -5.0;
      }
      settings.yaw_deg += 0.5;
      settings.position.y += 0.002;
      Camera camera;
      ok_ = make_camera(settings, camera).ok() && ok_;
      BuildDrawList::Result result;
      const double ms = bench::measure(1, [&] { ok_ = frame(way, camera, result) && ok_; }).median_ms;
      (n % kFramesAPlace == 0 ? jump_us : us).push_back(1e3 * ms);
      listed += result.drawn;
      back += result.culled_backface;
      hidden += result.culled_occluded;
      searches += way.rock && occlusion_.active() ? occlusion_.searched() : 0;
    }
    std::sort(us.begin(), us.end());
    std::sort(jump_us.begin(), jump_us.end());
    const auto median = [](const std::vector<double>& of) { return of.empty() ? 0.0 : of[of.size() / 2]; };
    std::printf("  %-10s %8.0f %10.0f %10.0f %10.1f %10.1f %10.1f\n", way.name, listed / frames,
                back / frames, hidden / frames, median(us), median(jump_us), searches / frames);
  }

  bool frame(const Ways& way, const Camera& camera, BuildDrawList::Result& result) {
    const Frustum frustum = make_frustum(camera);
    if (way.rock) {
      occlusion_.begin(occluders_, source_.octree(), tree_, world_.surface(), world_.bounds(), camera,
                       kSearches);
    }
    BuildDrawList build;
    build.boxes = culled_.boxes();
    build.culled = culled_.find(&frustum, tree_, way.rock ? &occlusion_ : nullptr);
    build.camera = &camera;
    build.surface = world_.surface();
    build.levels = levels_;
    if (way.cones) build.cones = cones_;
    build.scratch = scratch_;
    build.items = items_;
    return build.run(result).ok();
  }

  const test::TestWorld& source_;
  test::MorphedSurface world_;
  std::uint32_t patches_;
  std::vector<LatticeBox> nodes_;
  BoundsTree tree_;
  test::CulledView culled_;
  std::vector<std::uint64_t> words_;
  Occluders occluders_;
  std::vector<std::uint16_t> entries_;
  Occlusion occlusion_;
  std::vector<NormalCone> cones_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::uint32_t> scratch_;
  std::vector<DrawItem> items_;
  double build_ms_ = 0;
  bool ok_ = true;
};

int run_rock(bool smoke) {
  const glm::ivec3 extent = smoke ? glm::ivec3(24, 16, 24) : glm::ivec3(64, 32, 64);
  const int frames = smoke ? 120 : 2'400;
  const auto roughen = [](test::TestWorld& world) {
    world.set_heights(kLevel, [](glm::dvec3 p) { return 1500 * test::value_noise(3, p * 0.9); });
  };
  test::TestWorld halls(extent, [=](glm::ivec3 v) {
    const double ground = extent.y - 5 + 3 * test::value_noise(5, glm::dvec3(v.x, 0, v.z) / 15.0);
    return v.y < ground && (v.y < 2 || test::value_noise(4, glm::dvec3(v) / 8.0) > -0.3);
  });
  roughen(halls);
  int failed = Flight(halls).run("halls", false, frames);
  test::TestWorld hills(extent, [=](glm::ivec3 v) {
    return v.y < 5 + 3 * test::value_noise(5, glm::dvec3(v.x, 0, v.z) / 15.0);
  });
  roughen(hills);
  failed |= Flight(hills).run("open hills from above", true, frames);
  return failed;
}

const bench::Register registered{{"rock", run_rock}};

}  // namespace
}  // namespace karst::core
