// SPDX-License-Identifier: MIT
#include "app/stage/stage_view.h"

#include <cmath>

namespace karst::app {

bool& skip_of(Inspection& inspection, SkipChoice skip) {
  switch (skip) {
    case SkipChoice::frustum:
      return inspection.skip_frustum;
    case SkipChoice::backface:
      return inspection.skip_backface;
    case SkipChoice::occlusion:
      return inspection.skip_occluded;
    case SkipChoice::cascades:
      return inspection.skip_cascades;
    case SkipChoice::triplanar:
      return inspection.skip_triplanar;
    case SkipChoice::blend:
      return inspection.skip_blend;
    case SkipChoice::sun:
      return inspection.skip_sun;
    case SkipChoice::material:
      return inspection.skip_material;
    case SkipChoice::detail:
      return inspection.skip_detail;
    case SkipChoice::cave:
      break;
  }
  return inspection.skip_cave;
}

void turn_sun(const LocalAxes& axes, const WorldInfo& world, StageView& view) {
  if (world.basis == Basis::plane) return;
  const Vec3 local = view.sun.towards;
  const auto along = [&](double east, double up, double north) {
    return east * local.x + up * local.y - north * local.z;
  };
  view.sun.towards = {along(axes.east.x, axes.up.x, axes.north.x),
                      along(axes.east.y, axes.up.y, axes.north.y),
                      along(axes.east.z, axes.up.z, axes.north.z)};
}

StageView stage_view(const SceneArguments& arguments, const WorldInfo& world) {
  constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
  StageView view;
  const double azimuth = arguments.sun_azimuth_deg * kRadiansPerDegree;
  const double elevation = arguments.sun_elevation_deg * kRadiansPerDegree;
  view.sun.towards = {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                      -std::cos(azimuth) * std::cos(elevation)};
  // --haze says where 63 % of the light is haze, a visibility where 95 % is.
  if (arguments.haze_voxels > 0) {
    view.sun.visibility_m = arguments.haze_voxels * world.voxel_size_m * std::log(20.0);
  }
  view.view.error_px = arguments.error_px;
  Inspection& inspection = view.inspection;
  constexpr LodMode kModes[] = {LodMode::error, LodMode::distance, LodMode::full};
  inspection.lod = kModes[static_cast<int>(arguments.lod)];
  inspection.distance_voxels = arguments.lod_distance_voxels;
  constexpr Show kShown[] = {Show::materials, Show::cascades, Show::levels, Show::lookups};
  inspection.show = kShown[static_cast<int>(arguments.show)];
  for (int n = 0; n < kSkipCount; ++n) {
    if ((arguments.drawn_anyway >> n & 1) != 0) skip_of(inspection, static_cast<SkipChoice>(n)) = false;
  }
  if (arguments.generate_ms >= 0) view.work_ms = arguments.generate_ms;
  return view;
}

}  // namespace karst::app
