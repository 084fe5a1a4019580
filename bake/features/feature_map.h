// SPDX-License-Identifier: MIT
// A land of features, from a JSON file and to one (docs/features.md): its size, its noise, and hills,
// mountains, dunes and rivers at their places. From it comes the elevation of a ground.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bake/elevation/elevation.h"
#include "platform/base/error.h"
#include "terrain/procedural/procedural_surface.h"

namespace karst::bake {

struct PlacedFeature {
  core::Feature feature;  // a river's place, radius and pieces are made of points
  std::vector<core::RiverPoint> points;
};

// Metres. The middle is x = z = 0.
struct FeatureMap {
  static constexpr std::size_t kMostFeatures = 20'000;
  static constexpr std::size_t kMostPoints = 100'000;  // of all rivers
  static constexpr double kFarthestM = 1e6;            // |x|, |z|

  double size_m[2] = {4'096, 4'096};  // to the east and to the south
  double spacing_m = 2;               // of the ground's samples
  std::uint32_t seed = 1;
  std::optional<double> water_m;  // of still water
  core::NoiseSum noise{20, 30, 1'200, 0.5, 8};
  std::vector<PlacedFeature> features;

  int columns() const;  // of samples
  int rows() const;
};

// The error names the file, the feature and the field.
Error parse_feature_map(std::string_view text, const std::string& name, FeatureMap& map);
Error read_feature_map(const std::string& path, FeatureMap& map);
// What parse_feature_map() reads back as the same.
std::string feature_map_text(const FeatureMap& map);

// A map's surface, which it owns.
class MapSurface {
 public:
  explicit MapSurface(const FeatureMap& map);

  std::span<const core::Feature> features() const { return features_; }
  std::span<const core::RiverPiece> pieces() const { return pieces_; }
  // Heights of rows [first, first + count) of the map's samples. out: count x columns(). Any thread.
  void rows(int first, int count, std::span<float> out) const;

 private:
  core::SampleRect rect_;
  std::vector<core::Feature> features_;
  std::vector<core::RiverPiece> pieces_;
  core::ProceduralSurface surface_;
};

}  // namespace karst::bake
