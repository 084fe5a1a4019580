// SPDX-License-Identifier: MIT
#include "app/edit/edit_script.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "app/json/json_fields.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

constexpr double kFar = 1e9;  // metres
constexpr double kLeastLength = 1e-3;
constexpr double kMostLength = 1e6;

// In the order of EditTool; undo and redo follow.
constexpr std::initializer_list<const char*> kTools = {"clear",   "fill",  "extrude", "smooth", "noise",
                                                       "flatten", "level", "paint",   "undo",   "redo"};
constexpr std::initializer_list<const char*> kShapes = {"voxel", "box", "sphere", "capsule", "cylinder"};

template <class Words>
int place_of(const Words& words, std::string_view word) {
  int n = 0;
  for (const char* one : words) {
    if (word == one) return n;
    ++n;
  }
  return 0;
}

Vec3 vector_of(const JsonFields& fields, const char* field, double most) {
  const glm::dvec3 v = fields.vector(field, -most, most);
  return {v.x, v.y, v.z};
}

void read_optional(const JsonFields& fields, const char* field, double low, double high, double& out) {
  if (fields.has(field)) out = fields.number(field, low, high);
}

// A whole number.
std::uint32_t count_of(const JsonFields& fields, const char* field, double most) {
  const double number = fields.number(field, 0, most);
  if (number != static_cast<double>(static_cast<std::uint32_t>(number)))
    fields.fail(field, "not a whole number");
  return static_cast<std::uint32_t>(number);
}

Edit read_edit(const JsonFields& fields, int tool) {
  Edit edit;
  edit.tool = static_cast<EditTool>(tool);
  if (fields.has("shape"))
    edit.shape = static_cast<BrushShape>(place_of(kShapes, fields.word("shape", kShapes)));
  edit.place = vector_of(fields, "place_m", kFar);
  edit.to = edit.place;
  if (edit.shape == BrushShape::capsule) edit.to = vector_of(fields, "to_m", kFar);
  if (edit.shape == BrushShape::box) edit.half_m = vector_of(fields, "half_m", kMostLength);
  if (edit.shape == BrushShape::voxel)
    edit.octree_level = static_cast<std::uint8_t>(count_of(fields, "octree_level", 9));
  if (edit.tool == EditTool::paint && !fields.get("material").is_string())
    edit.material = static_cast<std::uint8_t>(count_of(fields, "material", 255));
  if (fields.has("up")) edit.up = vector_of(fields, "up", 1e6);
  read_optional(fields, "radius_m", kLeastLength, kMostLength, edit.radius_m);
  read_optional(fields, "strength_m", -kMostLength, kMostLength, edit.strength_m);
  read_optional(fields, "amount", 0, 1, edit.amount);
  read_optional(fields, "hardness", 0, 1, edit.hardness);
  read_optional(fields, "wave_m", kLeastLength, kMostLength, edit.wave_m);
  if (fields.has("seed")) edit.seed = count_of(fields, "seed", 4294967295.0);
  return edit;
}

ScriptStep read_step(const JsonFields& fields) {
  ScriptStep step;
  const int tool = place_of(kTools, fields.word("tool", kTools));
  constexpr int kUndo = static_cast<int>(EditTool::paint) + 1;
  if (tool >= kUndo) {
    step.kind = tool == kUndo ? ScriptStep::undo : ScriptStep::redo;
    fields.only({"tool", "check"});
    return step;
  }
  fields.only({"tool", "shape", "place_m", "to_m", "half_m", "octree_level", "material", "up", "radius_m",
               "strength_m", "amount", "hardness", "wave_m", "seed", "joined", "check"});
  step.what = read_edit(fields, tool);
  if (step.what.tool == EditTool::paint && fields.get("material").is_string())
    step.material = fields.text("material", sizeof WorldInfo().material_names[0] - 1);
  if (fields.has("joined")) {
    if (!fields.get("joined").is_boolean()) fields.fail("joined", "not true or false");
    step.joined = fields.get("joined").is_boolean() && fields.get("joined").get<bool>();
  }
  return step;
}

void put(std::string& line, const char* name, std::string_view text) {
  line += line.empty() ? "{\"" : ",\"";
  line += name;
  line += "\":";
  line += text;
}

std::string text_of(double number) {
  char room[32];
  const auto end = std::to_chars(room, room + sizeof room, number).ptr;
  return {room, end};
}

std::string text_of(Vec3 v) {
  return "[" + text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z) + "]";
}

std::string word_text(std::initializer_list<const char*> words, int n) {
  return "\"" + std::string(words.begin()[n]) + "\"";
}

}  // namespace

Error parse_script_line(std::string_view line, const std::string& place, ScriptStep& step) {
  nlohmann::json root;
  if (Error error = parse_json(line, place, {.depth = 3, .values = 64}, "an edit", root); !error.ok())
    return error;
  const JsonFields fields(root, place);
  if (fields.error().ok()) step = read_step(fields);
  return fields.error();
}

Error parse_script(std::string_view text, const std::string& name, std::vector<ScriptStep>& steps) {
  steps.clear();
  text = without_byte_order_mark(text);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '[') {
    nlohmann::json root;
    const JsonLimits limits{.depth = 4, .values = 40 * kMostScriptSteps};
    if (Error error = parse_json(text, name, limits, "a list of edits", root); !error.ok()) return error;
    for (std::size_t k = 0; k < root.size(); ++k) {
      const JsonFields fields(root[k], name + ": edit " + std::to_string(k));
      if (fields.error().ok()) steps.push_back(read_step(fields));
      if (!fields.error().ok()) return fields.error();
    }
    return {};
  }
  const bool journal = text.starts_with("{\"journal\":");
  if (journal) text = text.substr(0, text.rfind('\n') + 1);
  std::size_t number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    // Of a journal: which world it is of.
    if (line.starts_with("{\"journal\":") || line.starts_with("{\"saving\":")) continue;
    if (steps.size() == kMostScriptSteps)
      return name + ": more than " + std::to_string(kMostScriptSteps) + " edits";
    const std::string place = name + ": line " + std::to_string(number);
    if (Error error = parse_script_line(line, place, steps.emplace_back()); !error.ok()) return error;
  }
  return {};
}

std::vector<ScriptStep> effective_steps(const std::vector<ScriptStep>& steps, ScriptCounts& counts) {
  std::vector<std::vector<ScriptStep>> done, undone;
  for (const ScriptStep& step : steps) {
    if (step.kind == ScriptStep::edit) {
      undone.clear();
      if (step.joined && !done.empty()) {
        done.back().push_back(step);
      } else {
        done.push_back({step});
      }
      continue;
    }
    const bool is_undo = step.kind == ScriptStep::undo;
    std::vector<std::vector<ScriptStep>>&from = is_undo ? done : undone, &to = is_undo ? undone : done;
    ++(is_undo ? counts.undone : counts.redone);
    if (from.empty()) continue;
    to.push_back(std::move(from.back()));
    from.pop_back();
  }
  std::vector<ScriptStep> left;
  for (const std::vector<ScriptStep>& stroke : done) {
    left.insert(left.end(), stroke.begin(), stroke.end());
    if (!stroke.empty()) left[left.size() - stroke.size()].joined = false;
  }
  return left;
}

Error find_materials(const WorldInfo& info, const std::string& name, std::vector<ScriptStep>& steps) {
  for (std::size_t n = 0; n < steps.size(); ++n) {
    ScriptStep& step = steps[n];
    if (step.material.empty()) continue;
    std::string known = "none";
    step.what.material = kNoMaterial;
    bool found = step.material == "none";
    for (std::uint32_t m = 0; m < info.materials; ++m) {
      known += std::string(", ") + info.material_names[m];
      if (step.material != info.material_names[m]) continue;
      step.what.material = static_cast<std::uint8_t>(m);
      found = true;
    }
    if (!found) return name + ": edit " + std::to_string(n) + ": material: not one of the world's: " + known;
  }
  return {};
}

std::string script_line(const ScriptStep& step) {
  std::string line;
  if (step.kind != ScriptStep::edit) {
    put(line, "tool", step.kind == ScriptStep::undo ? "\"undo\"" : "\"redo\"");
    return line + "}";
  }
  const Edit& edit = step.what;
  put(line, "tool", word_text(kTools, static_cast<int>(edit.tool)));
  put(line, "shape", word_text(kShapes, static_cast<int>(edit.shape)));
  put(line, "place_m", text_of(edit.place));
  if (edit.shape == BrushShape::capsule) put(line, "to_m", text_of(edit.to));
  if (edit.shape == BrushShape::box) put(line, "half_m", text_of(edit.half_m));
  if (edit.shape == BrushShape::voxel) put(line, "octree_level", std::to_string(edit.octree_level));
  if (edit.tool == EditTool::paint) put(line, "material", std::to_string(edit.material));
  const Edit standard;
  const auto differs = [&](double Edit::*member, const char* name) {
    if (edit.*member != standard.*member) put(line, name, text_of(edit.*member));
  };
  if (edit.tool == EditTool::flatten) put(line, "up", text_of(edit.up));
  differs(&Edit::radius_m, "radius_m");
  differs(&Edit::strength_m, "strength_m");
  differs(&Edit::amount, "amount");
  differs(&Edit::hardness, "hardness");
  differs(&Edit::wave_m, "wave_m");
  if (edit.seed != 0) put(line, "seed", std::to_string(edit.seed));
  if (step.joined) put(line, "joined", "true");
  return line + "}";
}

}  // namespace karst::app
