// SPDX-License-Identifier: MIT
#include "bake/carve/json_fields.h"

#include <cmath>
#include <fstream>
#include <utility>

namespace karst::bake {
namespace {

constexpr std::size_t kMaxFileBytes = 64u << 20;

}  // namespace

JsonFields::JsonFields(const json& object, std::string place) : object_(object), place_(std::move(place)) {
  if (!object.is_object()) error_ = place_ + ": not an object";
}

void JsonFields::fail(const std::string& field, const std::string& what) const {
  if (error_.ok()) error_ = place_ + ": " + field + ": " + what;
}

const nlohmann::json& JsonFields::get(const char* field) const {
  static const json kNothing;
  const auto it = object_.find(field);
  if (it != object_.end()) return *it;
  fail(field, "missing");
  return kNothing;
}

std::string JsonFields::word(const char* field, std::initializer_list<const char*> allowed) const {
  const json& value = get(field);
  std::string list;
  for (const char* a : allowed) {
    if (value.is_string() && value.get_ref<const std::string&>() == a) return a;
    list += (list.empty() ? "" : ", ") + std::string(a);
  }
  fail(field, "not one of " + list);
  return *allowed.begin();
}

std::string JsonFields::text(const char* field, std::size_t most) const {
  const json& value = get(field);
  if (!value.is_string()) {
    fail(field, "not text");
    return {};
  }
  const std::string& text = value.get_ref<const std::string&>();
  if (!text.empty() && text.size() <= most) return text;
  fail(field, "not text of 1 to " + std::to_string(most) + " bytes");
  return {};
}

double JsonFields::number(const std::string& field, const json& value, double low, double high) const {
  const double number = value.is_number() ? value.get<double>() : NAN;
  if (number >= low && number <= high) return number;
  const auto text = [](double v) { return json(v).dump(); };
  fail(field, "not a number in " + text(low) + " to " + text(high));
  return low;
}

glm::dvec3 JsonFields::vector(const std::string& field, const json& value, double low, double high) const {
  glm::dvec3 result(low);
  if (!value.is_array() || value.size() != 3) {
    fail(field, "not three numbers");
    return result;
  }
  for (int k = 0; k < 3; ++k) result[k] = number(field, value[static_cast<std::size_t>(k)], low, high);
  return result;
}

const nlohmann::json& JsonFields::list(const char* field, std::size_t most) const {
  const json& value = get(field);
  static const json kEmpty = json::array();
  if (value.is_array() && value.size() <= most) return value;
  fail(field, value.is_array() ? "more than " + std::to_string(most) : "not a list");
  return kEmpty;
}

void JsonFields::only(std::initializer_list<const char*> allowed) const {
  if (!object_.is_object()) return;
  for (const auto& item : object_.items()) {
    bool known = false;
    for (const char* a : allowed) known = known || item.key() == a;
    if (!known) fail(item.key().substr(0, 40), "unknown field");
  }
}

Error parse_json(std::string_view text, const std::string& name, int depth, const char* what,
                 nlohmann::json& root) {
  // The callback keeps depth bounded, for the parser's own objects are freed recursively.
  bool too_deep = false;
  const auto shallow = [&too_deep, depth](int at, nlohmann::json::parse_event_t, nlohmann::json&) {
    too_deep = too_deep || at > depth;
    return !too_deep;
  };
  try {
    root = nlohmann::json::parse(text.begin(), text.end(), shallow);
  } catch (const nlohmann::json::exception& e) {
    return name + ": not JSON: " + std::string(e.what());
  }
  if (too_deep) return name + ": nested too deeply for " + what;
  return {};
}

Error read_json_text(const std::string& path, std::string& text) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return path + ": cannot be opened";
  text.clear();
  char block[1 << 16];
  while (file.read(block, sizeof block), file.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes) return path + ": longer than 64 MiB";
  }
  if (file.bad()) return path + ": cannot be read";
  return {};
}

}  // namespace karst::bake
