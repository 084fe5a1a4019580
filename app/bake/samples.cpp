// SPDX-License-Identifier: MIT
#include "app/bake/samples.h"

#include "app/bake/sample_solid.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace karst::bake {
namespace {

struct Entry {
  SampleName name;
  Sample (*make)();
};
constexpr Entry kEntries[] = {
    {{"canyon", "a river canyon with terraces, a natural bridge, alcoves and buttes"}, make_canyon},
    {{"caves", "tunnels and halls with pillars under hills"}, make_caves},
    {{"arches", "free-standing arches and fins on a sandy plain"}, make_arches},
    {{"hills", "rolling hills, a plain height field"}, make_hills},
};

}  // namespace

double Grain::apply(double value_m, glm::dvec3 p) const {
  // Away from the surface the grain fades out: it need not be computed there, and the value stays continuous.
  const double reach_m = 4 * (strength_m + strata_strength_m);
  const double near = 1 - std::abs(value_m) / reach_m;
  if (near <= 0) return value_m;
  double relief = strength_m * fbm(p * (1 / width_m), 4, seed);
  if (strata_m > 0) {
    const double tilt = 0.06 * p.x - 0.04 * p.z;
    const glm::dvec3 layered(p.x * 0.02, (p.y + tilt) / strata_m, p.z * 0.02);
    relief += strata_strength_m * fbm(layered, 2, seed + 100);
  }
  return value_m + relief * near;
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

Sample make_sample(std::string_view name) {
  for (const Entry& e : kEntries) {
    if (e.name.name == name) return e.make();
  }
  return {};
}

}  // namespace karst::bake
