// SPDX-License-Identifier: MIT
#include "app/json/json_fields.h"

#include "platform/base/text.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

namespace karst::app {
namespace {

constexpr std::size_t kMaxFileBytes = 16u << 20;

// Tells how far the parser has read.
struct CountingIterator {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  reference operator*() const { return *place; }
  CountingIterator& operator++() {
    *at = ++place;
    return *this;
  }
  CountingIterator operator++(int) {
    const CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return place == other.place; }

  const char* place;
  const char** at;
};

// Builds the tree and stops at the first thing that is too much: nlohmann's own callbacks look at all members
// of a list for each of them that ends, and its tree is freed only after all of the text is in memory.
class JsonBuilder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  using json = nlohmann::json;

  JsonBuilder(const JsonLimits& limits, const char* what, json& root)
      : limits_(limits), what_(what), root_(root) {}

  const std::string& error() const { return error_; }

  bool null() override { return add(nullptr) != nullptr; }
  bool boolean(bool value) override { return add(value) != nullptr; }
  bool number_integer(number_integer_t value) override { return add(value) != nullptr; }
  bool number_unsigned(number_unsigned_t value) override { return add(value) != nullptr; }
  bool number_float(number_float_t value, const string_t&) override { return add(value) != nullptr; }
  bool string(string_t& value) override { return add(std::move(value)) != nullptr; }
  bool binary(binary_t&) override { return fail("not JSON"); }
  bool start_object(std::size_t) override { return open(json::object()); }
  bool start_array(std::size_t) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    if (open_.back()->contains(name)) return fail(quote(name) + " is given twice");
    key_ = std::move(name);
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return fail("not JSON");
  }

 private:
  bool fail(const std::string& what) {
    if (error_.empty()) error_ = what;
    return false;
  }

  json* add(json value) {
    if (++values_ > limits_.values) {
      fail("more than " + std::to_string(limits_.values) + " values, too many for " + what_);
      return nullptr;
    }
    if (open_.empty()) return &(root_ = std::move(value));
    if (open_.back()->is_array()) return &open_.back()->emplace_back(std::move(value));
    return &((*open_.back())[key_] = std::move(value));
  }

  // What is open cannot move: only the innermost of them grows.
  bool open(json value) {
    if (open_.size() == static_cast<std::size_t>(limits_.depth))
      return fail("nested too deeply for " + what_);
    json* const added = add(std::move(value));
    if (added != nullptr) open_.push_back(added);
    return added != nullptr;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  const JsonLimits& limits_;
  std::string what_;
  json& root_;
  std::vector<json*> open_;
  std::string key_;
  std::size_t values_ = 0;
  std::string error_;
};

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
    if (!known) fail(excerpt(item.key()), "unknown field");
  }
}

Error parse_json(std::string_view text, const std::string& name, const JsonLimits& limits, const char* what,
                 nlohmann::json& root) {
  root = nullptr;
  const char* at = text.data();
  JsonBuilder builder(limits, what, root);
  const CountingIterator first{text.data(), &at}, last{text.data() + text.size(), &at};
  if (nlohmann::json::sax_parse(first, last, &builder)) return {};
  // The reader stands behind the byte at fault.
  const auto bytes = static_cast<std::size_t>(at - text.data());
  const std::size_t byte = bytes - std::min<std::size_t>(bytes, 1);
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n') + 1;
  root = nullptr;
  return name + ": line " + std::to_string(line) + ", byte " + std::to_string(byte) + ": " + builder.error();
}

Error read_json_text(const std::string& path, std::string& text) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return path + ": cannot be opened";
  text.clear();
  char block[1 << 16];
  while (file.read(block, sizeof block), file.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes) return path + ": longer than 16 MiB";
  }
  if (file.bad()) return path + ": cannot be read";
  return {};
}

}  // namespace karst::app
