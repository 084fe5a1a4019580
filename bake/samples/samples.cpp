// SPDX-License-Identifier: MIT
#include "bake/samples/samples.h"

#include "bake/samples/sample_solid.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace karst::bake {
namespace {

// The shapes' table: four points a voxel, and this far around the content, where fits look for the surface.
constexpr double kPointsPerVoxel = 4;
constexpr double kMarginVoxels = 3;
constexpr int kLevel = 5;  // K's finest

struct Entry {
  SampleName name;
  std::unique_ptr<SampleShape> (*make)();
};
constexpr Entry kEntries[] = {
    {{"canyon", "a river canyon with terraces, a natural bridge, alcoves and a butte"}, make_canyon},
    {{"caves", "halls with pillars and tunnels under hills"}, make_caves},
    {{"arches", "free-standing arches and fins on a sandy plain"}, make_arches},
    {{"hills", "rolling hills, a plain height field"}, make_hills},
};

class SampleSolid final : public Solid {
 public:
  SampleSolid(const SampleShape& shape, int threads) : grain_(shape.grain) {
    const double margin = kMarginVoxels * shape.voxel_m;
    const Box box{shape.content_m.min - margin, shape.content_m.max + margin};
    shape_ = TabulatedSpace(box, shape.voxel_m / kPointsPerVoxel, threads,
                            [&](glm::dvec3 p) { return shape.value_m(p); });
  }
  double value_m(glm::dvec3 position_m) const override {
    return grain_.apply(shape_.at(position_m), position_m);
  }

 private:
  TabulatedSpace shape_;
  Grain grain_;
};

}  // namespace

double Grain::apply(double value_m, glm::dvec3 p) const {
  const double reach_m = 4 * (strength_m + strata_strength_m);
  double near = 1 - std::abs(value_m) / reach_m;
  if (near <= 0) return value_m;
  return value_m + rough_m(p) * (near * calm(p.y));
}

double Grain::calm(double y) const {
  return 1.0 / 3 + 2.0 / 3 * smooth_step((y - calm_below_m) * 0.25);
}

double Grain::rough_m(glm::dvec3 p) const {
  double relief = strength_m * fbm(p * (1 / width_m), 3, seed);
  if (strata_strength_m > 0) {
    const double tilted = p.y + 0.06 * p.x - 0.04 * p.z;
    relief += strata_strength_m * fbm(glm::dvec2(tilted / strata_m, 0.015 * (p.x + p.z)), 2, seed + 100);
  }
  return relief;
}

std::span<const SampleName> sample_names() {
  static const auto names = [] {
    std::array<SampleName, std::size(kEntries)> result{};
    std::transform(std::begin(kEntries), std::end(kEntries), result.begin(),
                   [](const Entry& e) { return e.name; });
    return result;
  }();
  return names;
}

Sample make_sample(std::string_view name, int threads) {
  for (const Entry& e : kEntries) {
    if (e.name.name != name) continue;
    std::shared_ptr<const SampleShape> shape = e.make();
    auto solid = std::make_unique<SampleSolid>(*shape, threads);
    return {std::move(solid), shape, shape->content_m, shape->voxel_m, kLevel};
  }
  return {};
}

}  // namespace karst::bake
