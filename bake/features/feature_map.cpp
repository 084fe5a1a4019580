// SPDX-License-Identifier: MIT
#include "bake/features/feature_map.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "app/common/json_writer.h"
#include "app/json/json_fields.h"

namespace karst::bake {

using namespace core;
using app::JsonFields;

namespace {

constexpr double kFar = FeatureMap::kFarthestM;
constexpr double kLeast = 1e-3;      // metres
constexpr double kHighest = 20'000;  // metres
constexpr double kMostWavelength = 1e7;
constexpr double kRiverTolerance = 1.0 / 64;  // of its width, and of a spacing
constexpr const char* kKinds[] = {"hill", "mountain", "dunes", "river"};

glm::dvec2 place_of(const JsonFields& fields, const char* name, const nlohmann::json& value) {
  if (!value.is_array() || value.size() != 2) {
    fields.fail(name, "not two numbers, x and z");
    return {};
  }
  return {fields.number(name, value[0], -kFar, kFar), fields.number(name, value[1], -kFar, kFar)};
}

void parse_river(const JsonFields& fields, std::size_t& points, PlacedFeature& placed) {
  fields.only({"feature", "points", "width", "depth", "valley"});
  Feature& river = placed.feature;
  river.width_m = fields.number("width", kLeast, kHighest);
  river.depth_m = fields.number("depth", 0, kHighest);
  river.valley_m = fields.number("valley", kLeast, kFar);
  const nlohmann::json& list = fields.list("points", FeatureMap::kMostPoints);
  if (fields.error().ok() && list.size() < 2) fields.fail("points", "fewer than two");
  points += list.size();
  if (points > FeatureMap::kMostPoints) fields.fail("points", "more than 100000 of all rivers");
  for (const nlohmann::json& point : list) {
    if (!fields.error().ok()) return;
    if (!point.is_array() || point.size() != 3) {
      fields.fail("points", "not three numbers, x, z and the water's height");
      return;
    }
    const glm::dvec2 place{fields.number("points", point[0], -kFar, kFar),
                           fields.number("points", point[1], -kFar, kFar)};
    placed.points.push_back({place, fields.number("points", point[2], -kHighest, kHighest)});
  }
}

PlacedFeature parse_feature(const JsonFields& fields, std::size_t& points) {
  PlacedFeature placed;
  Feature& feature = placed.feature;
  const std::string kind = fields.word("feature", {"hill", "mountain", "dunes", "river"});
  feature.kind = static_cast<FeatureKind>(std::find(std::begin(kKinds), std::end(kKinds), kind) - kKinds);
  if (feature.kind == FeatureKind::river) {
    parse_river(fields, points, placed);
    return placed;
  }
  const nlohmann::json& centre = fields.get("center");
  if (fields.error().ok()) feature.place_m = place_of(fields, "center", centre);
  feature.radius_m = fields.number("radius", kLeast, kFar);
  if (feature.kind == FeatureKind::hill) {
    fields.only({"feature", "center", "radius", "height"});
    feature.height_m = fields.number("height", -kHighest, kHighest);
  } else if (feature.kind == FeatureKind::mountain) {
    fields.only({"feature", "center", "radius", "height", "peakiness"});
    feature.height_m = fields.number("height", -kHighest, kHighest);
    if (fields.has("peakiness")) feature.peakiness = fields.number("peakiness", 0, 1);
  } else {
    fields.only({"feature", "center", "radius", "height", "wavelength", "towards"});
    feature.height_m = fields.number("height", 0, kHighest);
    feature.wavelength_m = fields.number("wavelength", kLeast, kFar);
    if (fields.has("towards") && fields.error().ok()) {
      const glm::dvec2 way = place_of(fields, "towards", fields.get("towards"));
      if (glm::length(way) > 0) {
        feature.towards = glm::normalize(way);
      } else {
        fields.fail("towards", "0, 0 is no direction");
      }
    }
  }
  return placed;
}

void parse_noise(const JsonFields& fields, NoiseSum& noise) {
  fields.only({"height", "amplitude", "wavelength", "persistence", "octaves"});
  if (fields.has("height")) noise.base_m = fields.number("height", -kHighest, kHighest);
  if (fields.has("amplitude")) noise.amplitude_m = fields.number("amplitude", 0, kHighest);
  if (fields.has("wavelength")) noise.wavelength_m = fields.number("wavelength", 1, kMostWavelength);
  if (fields.has("persistence")) noise.persistence = fields.number("persistence", 0.01, 1);
  if (!fields.has("octaves")) return;
  const double octaves = fields.number("octaves", 1, kMostOctaves);
  if (octaves != std::floor(octaves)) fields.fail("octaves", "not a whole number");
  noise.octaves = static_cast<int>(octaves);
}

void write_number_list(app::JsonWriter& out, const char* name, std::initializer_list<double> numbers) {
  out.key(name).begin_array();
  for (const double number : numbers) out.value(number);
  out.end_array();
}

void write_feature(app::JsonWriter& out, const PlacedFeature& placed) {
  const Feature& feature = placed.feature;
  out.begin_object().field("feature", kKinds[static_cast<int>(feature.kind)]);
  if (feature.kind == FeatureKind::river) {
    out.field("width", feature.width_m).field("depth", feature.depth_m).field("valley", feature.valley_m);
    out.key("points").begin_array();
    for (const RiverPoint& point : placed.points) {
      out.begin_array().value(point.place_m.x).value(point.place_m.y).value(point.level_m).end_array();
    }
    out.end_array();
  } else {
    write_number_list(out, "center", {feature.place_m.x, feature.place_m.y});
    out.field("radius", feature.radius_m).field("height", feature.height_m);
    if (feature.kind == FeatureKind::mountain) out.field("peakiness", feature.peakiness);
    if (feature.kind == FeatureKind::dunes) {
      out.field("wavelength", feature.wavelength_m);
      write_number_list(out, "towards", {feature.towards.x, feature.towards.y});
    }
  }
  out.end_object();
}

int samples_along(double size_m, double spacing_m) {
  return static_cast<int>(std::floor(size_m / spacing_m + 1e-9)) + 1;
}

}  // namespace

int FeatureMap::columns() const {
  return samples_along(size_m[0], spacing_m);
}
int FeatureMap::rows() const {
  return samples_along(size_m[1], spacing_m);
}

Error parse_feature_map(std::string_view text, const std::string& name, FeatureMap& map) {
  map = {};
  nlohmann::json root;
  if (Error error = app::parse_json(text, name, {}, "a land of features", root); !error.ok()) return error;
  const JsonFields fields(root, name);
  fields.only({"size", "spacing", "seed", "water", "noise", "features"});
  if (!fields.error().ok()) return fields.error();
  if (fields.has("size")) {
    const nlohmann::json& size = fields.get("size");
    if (!size.is_array() || size.size() != 2) {
      fields.fail("size", "not two numbers, to the east and to the south");
    } else {
      for (std::size_t k = 0; k < 2; ++k) map.size_m[k] = fields.number("size", size[k], kLeast, 2 * kFar);
    }
  }
  if (fields.has("spacing")) map.spacing_m = fields.number("spacing", kLeast, kFar);
  for (const double size_m : map.size_m) {
    const double samples = size_m / map.spacing_m;
    if (fields.error().ok() && !(samples >= 4 && samples < ElevationRows::kMostSide))
      fields.fail("spacing", "the ground has less than 5 or more than 4194304 samples a side");
  }
  if (fields.has("seed")) {
    const double seed = fields.number("seed", 0, 4'294'967'295.0);
    if (seed != std::floor(seed)) fields.fail("seed", "not a whole number");
    map.seed = static_cast<std::uint32_t>(seed);
  }
  if (fields.has("water")) map.water_m = fields.number("water", -kHighest, kHighest);
  if (!fields.error().ok()) return fields.error();
  if (fields.has("noise")) {
    const JsonFields noise(fields.get("noise"), name + ": noise");
    parse_noise(noise, map.noise);
    if (!noise.error().ok()) return noise.error();
  }
  if (fields.has("features")) {
    std::size_t points = 0;
    const nlohmann::json& list = fields.list("features", FeatureMap::kMostFeatures);
    if (!fields.error().ok()) return fields.error();
    for (std::size_t k = 0; k < list.size(); ++k) {
      const JsonFields feature(list[k], name + ": feature " + std::to_string(k));
      map.features.push_back(parse_feature(feature, points));
      if (!feature.error().ok()) return feature.error();
    }
  }
  return fields.error();
}

Error read_feature_map(const std::string& path, FeatureMap& map) {
  std::string text;
  if (Error error = app::read_json_text(path, text); !error.ok()) return error;
  return parse_feature_map(text, path, map);
}

std::string feature_map_text(const FeatureMap& map) {
  app::JsonWriter out;
  out.begin_object();
  write_number_list(out, "size", {map.size_m[0], map.size_m[1]});
  out.field("spacing", map.spacing_m).field("seed", map.seed);
  if (map.water_m) out.field("water", *map.water_m);
  out.key("noise").begin_object();
  out.field("height", map.noise.base_m).field("amplitude", map.noise.amplitude_m);
  out.field("wavelength", map.noise.wavelength_m).field("persistence", map.noise.persistence);
  out.field("octaves", map.noise.octaves).end_object();
  out.key("features").begin_array();
  for (const PlacedFeature& placed : map.features) write_feature(out, placed);
  out.end_array().end_object();
  return out.text();
}

MapSurface::MapSurface(const FeatureMap& map) {
  rect_.columns = map.columns();
  rect_.spacing_m = map.spacing_m;
  rect_.first_x = -(rect_.columns - 1) / 2;
  rect_.first_z = -(map.rows() - 1) / 2;
  for (const PlacedFeature& placed : map.features) {
    Feature feature = placed.feature;
    if (feature.kind == FeatureKind::river) {
      const double tolerance_m = kRiverTolerance * std::min(feature.width_m, map.spacing_m);
      feature.first_piece = static_cast<std::uint32_t>(pieces_.size());
      feature.pieces = static_cast<std::uint32_t>(river_pieces(placed.points, tolerance_m, {}));
      pieces_.resize(pieces_.size() + feature.pieces);
      river_pieces(placed.points, tolerance_m, std::span(pieces_).subspan(feature.first_piece));
      glm::dvec2 low = pieces_[feature.first_piece].from_m, high = low;
      for (std::uint32_t n = 0; n < feature.pieces; ++n) {
        low = glm::min(low, pieces_[feature.first_piece + n].to_m);
        high = glm::max(high, pieces_[feature.first_piece + n].to_m);
      }
      feature.place_m = 0.5 * (low + high);
      feature.radius_m = 0.5 * glm::length(high - low) + 0.5 * feature.width_m + feature.valley_m;
    }
    features_.push_back(feature);
  }
  order_features(features_);
  surface_ = {map.seed, map.noise, features_, pieces_};
}

void MapSurface::rows(int first, int count, std::span<float> out) const {
  SampleRect rect = rect_;
  rect.first_z += first;
  rect.rows = count;
  std::vector<std::uint32_t> near(2 * features_.size() + pieces_.size() + 1);
  procedural_heights(surface_, rect, near, out);
}

}  // namespace karst::bake
