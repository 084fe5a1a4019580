// SPDX-License-Identifier: MIT
// Random worlds with morphing levels of detail and random poses around them, for the tests of morphing.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "terrain/lod/select_lod.h"
#include "tests/support/any_camera.h"
#include "tests/support/culled_view.h"
#include "tests/support/morphed_surface.h"

namespace karst::core {

using test::between;
using test::MorphedSurface;
using test::Projection;
using test::Random;
using test::TestWorld;

glm::dvec3 direction(Random& random);  // unit length, uniform

enum class Roughness { flat, smooth, mixed, rough, canyon };
inline constexpr Roughness kAllRoughness[] = {Roughness::flat, Roughness::smooth, Roughness::mixed,
                                              Roughness::rough, Roughness::canyon};
inline constexpr const char* kRoughnessNames[] = {"flat", "smooth", "mixed", "rough", "canyon"};

TestWorld make_world(Random& random, int level, Roughness roughness);

// A world with everything that choosing levels needs.
class Scene {
 public:
  Scene(Random& random, int level, Roughness roughness) : Scene(make_world(random, level, roughness)) {}
  explicit Scene(const TestWorld& world)
      : drawn(world),
        levels(drawn.patches()),
        errors_(world.level_errors()),
        lods_(drawn.patches()),
        nodes_(BoundsTree::node_count(static_cast<std::uint32_t>(drawn.patches()))),
        culled_(drawn.surface(), drawn.bounds()),
        cut_(drawn.patches()) {
    tree_.create(nodes_);
    EXPECT_TRUE(tree_.build(drawn.surface(), drawn.bounds()).ok());
  }
  Scene(const Scene&) = delete;

  // Thresholds for the picture and, with them, levels for all patches.
  SelectLod::Result select(const Camera& camera, glm::ivec2 size_px, double error_px, int max_level) {
    set_thresholds(camera, size_px, error_px, max_level, true);
    return select_again(camera, error_px, max_level, nullptr, levels);
  }

  SelectLod::Result select_again(const Camera& camera, double error_px, int max_level, const Frustum* frustum,
                                 std::span<std::uint8_t> out) const {
    LodSettings settings;
    settings.error_px = error_px;
    settings.max_level = settings.resident_level = max_level;
    return run(settings, camera, frustum, out);
  }

  // With levels capped by what is held, after set_thresholds or select.
  SelectLod::Result select_held(const LodSettings& settings, const Camera& camera, const Frustum* frustum,
                                std::span<const std::uint8_t> resident, std::span<LackingPatch> lacking) {
    return run(settings, camera, frustum, levels, resident, lacking);
  }

  // K's levels, which do not morph, or the finest.
  SelectLod::Result select_still(const LodSettings& settings, const Camera& camera, glm::ivec2 size_px,
                                 const Frustum* frustum) {
    set_thresholds(camera, size_px, settings.error_px, settings.top_level(), false);
    return run(settings, camera, frustum, levels);
  }

  unsigned lower_edges(PatchId patch, std::span<const std::uint8_t> of) const {
    unsigned lower = 0;
    for (int e = 0; e < 4; ++e) {
      const PatchEdge n = drawn.surface().patches[patch].neighbour[e];
      if (n.exists() && of[n.patch()] > 0 && of[n.patch()] + 1 == of[patch]) lower |= 1u << e;
    }
    return lower;
  }

  std::vector<glm::vec3> moved(PatchId patch, int level, const Camera& camera) const {
    return drawn.moved(patch, level, camera, scale, lods_);
  }
  LatticeBox box(PatchId patch) const { return patch_box(drawn.surface(), drawn.bounds(), patch); }
  LevelErrors errors() const { return {drawn.level(), errors_}; }
  const std::vector<PatchLod>& lods() const { return lods_; }

  MorphedSurface drawn;
  ErrorScale scale;
  std::vector<std::uint8_t> levels;

 private:
  void set_thresholds(const Camera& camera, glm::ivec2 size_px, double error_px, int max_level,
                      bool morphing) {
    scale = make_error_scale(camera, size_px.x, size_px.y, error_px);
    SetThresholds set;
    set.scale = scale;
    set.max_level = max_level;
    set.morphing = morphing;
    set.surface = drawn.surface();
    set.bounds = drawn.bounds();
    set.errors = errors();
    set.lods = lods_;
    EXPECT_TRUE(set.validate().ok());
    set.run();
  }

  SelectLod::Result run(const LodSettings& settings, const Camera& camera, const Frustum* frustum,
                        std::span<std::uint8_t> out, std::span<const std::uint8_t> resident = {},
                        std::span<LackingPatch> lacking = {}) const {
    SelectLod select;
    select.settings = settings;
    select.camera = &camera;
    select.surface = drawn.surface();
    select.bounds = drawn.bounds();
    select.tree = &tree_;
    select.scale = scale;
    select.lods = lods_;
    select.culled = culled_.find(frustum, tree_);
    select.errors = errors();
    select.resident = resident;
    select.levels = out;
    select.lacking = lacking;
    select.cut = cut_;
    EXPECT_TRUE(select.validate().ok());
    return select.run();
  }

  std::vector<std::uint16_t> errors_;
  std::vector<PatchLod> lods_;
  std::vector<LatticeBox> nodes_;
  BoundsTree tree_;
  mutable test::CulledView culled_;
  mutable std::vector<PatchId> cut_;
};

struct Pose {
  CameraSettings camera;
  glm::ivec2 size_px;
  double error_px;
};

// Around a random vertex of the surface: at a distance of any size, or where some level of its patch is
// morphing.
Pose random_pose(Random& random, Scene& scene);
Camera camera_of(const CameraSettings& settings);

// How far what is drawn is from the full surface.
struct Deviation {
  double most_px = 0;
  double of_bound = 0;  // the largest share of its frame's bound
  std::size_t samples = 0;
  std::size_t moving = 0;  // vertices between home and target
};
// Of what is seen: one of the points at equal (u, v) is in the picture, the other one at least not behind the
// near plane.
void measure_deviation(const Scene& scene, const Camera& camera, glm::ivec2 size_px, double bound_px,
                       Deviation& most);

// How far the surface moves where levels are others, at every vertex of the full level, pixels; points behind
// the near plane are left out.
double largest_step(const Scene& scene, const Camera& camera, glm::ivec2 size_px,
                    std::span<const std::uint8_t> before, std::span<const std::uint8_t> after);

// What is held of a world: most patches as fine as they may ever be wanted, some coarser in patches or at
// random, some not at all.
std::vector<std::uint8_t> random_held(Random& random, const Scene& scene, double missing);

}  // namespace karst::core
