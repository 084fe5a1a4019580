// SPDX-License-Identifier: MIT
#include "app/json/json_fields.h"
#include "bake/carve/carve.h"

#include <algorithm>

namespace karst::bake {

using app::JsonFields;
using app::parse_json;
using app::read_json_text;

namespace {

CarveShape parse_shape(const JsonFields& fields, std::size_t& points) {
  constexpr double kFar = CarveShape::kFarthestM, kRadius = CarveShape::kMaxRadiusM;
  constexpr double kSmall = 1e-6;  // metres; a shape of no size is a mistake
  CarveShape shape;
  const std::string kind = fields.word("shape", {"box", "sphere", "capsule"});
  shape.fill = fields.word("op", {"fill", "empty"}) == "fill";
  if (fields.has("blend")) shape.blend_m = fields.number("blend", 0, kRadius);
  if (kind == "box") {
    fields.only({"shape", "op", "blend", "center", "size", "radius"});
    shape.kind = CarveShape::Kind::box;
    shape.centre_m = fields.vector("center", -kFar, kFar);
    shape.half_m = 0.5 * fields.vector("size", kSmall, kFar);
    const double least = std::min({shape.half_m.x, shape.half_m.y, shape.half_m.z});
    if (fields.has("radius")) shape.radius_m = fields.number("radius", 0, least);
  } else if (kind == "sphere") {
    fields.only({"shape", "op", "blend", "center", "radius"});
    shape.centre_m = fields.vector("center", -kFar, kFar);
    shape.radius_m = fields.number("radius", kSmall, kRadius);
  } else {
    fields.only({"shape", "op", "blend", "points", "radius"});
    shape.kind = CarveShape::Kind::capsule;
    shape.radius_m = fields.number("radius", kSmall, kRadius);
    const nlohmann::json& list = fields.get("points");
    if (!list.is_array() || list.size() < 2) {
      fields.fail("points", "not a list of two or more points");
      return shape;
    }
    points += list.size();
    if (points > CarveShape::kMostPoints) fields.fail("points", "more than 100000 points together");
    for (const nlohmann::json& point : list) {
      if (!fields.error().ok()) break;
      shape.points_m.push_back(fields.vector("points", point, -kFar, kFar));
    }
  }
  return shape;
}

}  // namespace

Error parse_carve(std::string_view text, const std::string& name, std::vector<CarveShape>& shapes) {
  shapes.clear();
  nlohmann::json root;
  if (Error error = parse_json(text, name, {}, "a list of shapes", root); !error.ok()) return error;
  if (!root.is_array()) return name + ": not a list of shapes";
  if (root.size() > CarveShape::kMostShapes) {
    return name + ": " + std::to_string(root.size()) + " shapes; the most is 10000";
  }
  std::size_t points = 0;
  for (std::size_t k = 0; k < root.size(); ++k) {
    const JsonFields fields(root[k], name + ": shape " + std::to_string(k));
    shapes.push_back(parse_shape(fields, points));
    if (!fields.error().ok()) return fields.error();
  }
  return {};
}

Error read_carve(const std::string& path, std::vector<CarveShape>& shapes) {
  std::string text;
  if (Error error = read_json_text(path, text); !error.ok()) return error;
  return parse_carve(text, path, shapes);
}

}  // namespace karst::bake
