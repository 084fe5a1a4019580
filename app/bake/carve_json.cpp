// SPDX-License-Identifier: MIT
// Strict reading of carve JSON: a field that is missing, unknown, of the wrong type or out of range is an
// error.
#include "app/bake/bake_error.h"
#include "app/bake/carve.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <initializer_list>

namespace karst::bake {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxFileBytes = 64u << 20;

// One shape's object, with its place in the file for messages.
class Fields {
 public:
  Fields(const json& object, const std::string& name, std::size_t index)
      : object_(object), place_(name + ": shape " + std::to_string(index)) {
    if (!object.is_object()) throw BakeError(place_ + ": not an object");
  }

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw BakeError(place_ + ": " + field + ": " + what);
  }
  bool has(const char* field) const { return object_.contains(field); }

  const json& get(const char* field) const {
    const auto it = object_.find(field);
    if (it == object_.end()) fail(field, "missing");
    return *it;
  }
  std::string word(const char* field, std::initializer_list<const char*> allowed) const {
    const json& value = get(field);
    std::string list;
    for (const char* a : allowed) {
      if (value.is_string() && value.get_ref<const std::string&>() == a) return a;
      list += (list.empty() ? "" : ", ") + std::string(a);
    }
    fail(field, "not one of " + list);
  }
  double number(const std::string& field, const json& value, double low, double high) const {
    const double number = value.is_number() ? value.get<double>() : NAN;
    if (!(number >= low && number <= high)) {
      const auto text = [](double v) { return json(v).dump(); };
      fail(field, "not a number in " + text(low) + " to " + text(high));
    }
    return number;
  }
  glm::dvec3 vector(const std::string& field, const json& value, double low, double high) const {
    if (!value.is_array() || value.size() != 3) fail(field, "not three numbers");
    glm::dvec3 result;
    for (int k = 0; k < 3; ++k) result[k] = number(field, value[static_cast<std::size_t>(k)], low, high);
    return result;
  }
  void only(std::initializer_list<const char*> allowed) const {
    for (const auto& item : object_.items()) {
      bool known = false;
      for (const char* a : allowed) known = known || item.key() == a;
      if (!known) fail(item.key().substr(0, 40), "unknown field");
    }
  }

 private:
  const json& object_;
  std::string place_;
};

CarveShape parse_shape(const Fields& fields, std::size_t& points) {
  constexpr double kFar = CarveShape::kFarthestM, kRadius = CarveShape::kMaxRadiusM;
  constexpr double kSmall = 1e-6;  // metres; a shape of no size is a mistake
  CarveShape shape;
  const std::string kind = fields.word("shape", {"box", "sphere", "capsule"});
  shape.fill = fields.word("op", {"fill", "empty"}) == "fill";
  if (fields.has("blend")) shape.blend_m = fields.number("blend", fields.get("blend"), 0, kRadius);
  if (kind == "box") {
    fields.only({"shape", "op", "blend", "center", "size", "radius"});
    shape.kind = CarveShape::Kind::box;
    shape.centre_m = fields.vector("center", fields.get("center"), -kFar, kFar);
    shape.half_m = 0.5 * fields.vector("size", fields.get("size"), kSmall, kFar);
    const double least = std::min({shape.half_m.x, shape.half_m.y, shape.half_m.z});
    if (fields.has("radius")) shape.radius_m = fields.number("radius", fields.get("radius"), 0, least);
  } else if (kind == "sphere") {
    fields.only({"shape", "op", "blend", "center", "radius"});
    shape.centre_m = fields.vector("center", fields.get("center"), -kFar, kFar);
    shape.radius_m = fields.number("radius", fields.get("radius"), kSmall, kRadius);
  } else {
    fields.only({"shape", "op", "blend", "points", "radius"});
    shape.kind = CarveShape::Kind::capsule;
    shape.radius_m = fields.number("radius", fields.get("radius"), kSmall, kRadius);
    const json& list = fields.get("points");
    if (!list.is_array() || list.size() < 2) fields.fail("points", "not a list of two or more points");
    points += list.size();
    if (points > CarveShape::kMostPoints) fields.fail("points", "more than 100000 points together");
    for (const json& point : list) shape.points_m.push_back(fields.vector("points", point, -kFar, kFar));
  }
  return shape;
}

}  // namespace

std::vector<CarveShape> parse_carve(std::string_view text, const std::string& name) {
  // The callback keeps depth bounded, for the parser's own objects are freed recursively.
  bool too_deep = false;
  const auto shallow = [&too_deep](int depth, json::parse_event_t, json&) {
    too_deep = too_deep || depth > 8;
    return !too_deep;
  };
  json root;
  try {
    root = json::parse(text.begin(), text.end(), shallow);
  } catch (const json::exception& e) {
    throw BakeError(name + ": not JSON: " + std::string(e.what()));
  }
  if (too_deep) throw BakeError(name + ": nested too deeply for a list of shapes");
  if (!root.is_array()) throw BakeError(name + ": not a list of shapes");
  if (root.size() > CarveShape::kMostShapes) {
    throw BakeError(name + ": " + std::to_string(root.size()) + " shapes; the most is 10000");
  }
  std::vector<CarveShape> shapes;
  std::size_t points = 0;
  for (std::size_t k = 0; k < root.size(); ++k)
    shapes.push_back(parse_shape(Fields(root[k], name, k), points));
  return shapes;
}

std::vector<CarveShape> read_carve(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw BakeError(path + ": cannot be opened");
  std::string text;
  char block[1 << 16];
  while (file.read(block, sizeof block), file.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes) throw BakeError(path + ": longer than 64 MiB");
  }
  if (file.bad()) throw BakeError(path + ": cannot be read");
  return parse_carve(text, path);
}

}  // namespace karst::bake
