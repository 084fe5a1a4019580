// SPDX-License-Identifier: MIT
// Strict reading of JSON: a field that is missing, unknown, of the wrong type or out of range is an error
// that names the file, the place in it and the field. For sources that read JSON alone.
#pragma once

#include "platform/base/error.h"

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include <initializer_list>
#include <string>
#include <string_view>

namespace karst::app {

// One object with its place in the file for messages, as "file.json: shape 3". Reading goes on after an
// error, with values that are in range but mean nothing; the first error is kept, and to be looked at in the
// end.
class JsonFields {
 public:
  using json = nlohmann::json;

  // object outlives this.
  JsonFields(const json& object, std::string place);

  const Error& error() const { return error_; }
  void fail(const std::string& field, const std::string& what) const;
  bool has(const char* field) const { return object_.contains(field); }
  const json& get(const char* field) const;
  // One of the words; the first on an error.
  std::string word(const char* field, std::initializer_list<const char*> allowed) const;
  // Text of 1 to `most` bytes.
  std::string text(const char* field, std::size_t most) const;
  double number(const std::string& field, const json& value, double low, double high) const;
  double number(const char* field, double low, double high) const {
    return number(field, get(field), low, high);
  }
  glm::dvec3 vector(const std::string& field, const json& value, double low, double high) const;
  glm::dvec3 vector(const char* field, double low, double high) const {
    return vector(field, get(field), low, high);
  }
  // A list of at most `most`; empty on an error.
  const json& list(const char* field, std::size_t most) const;
  void only(std::initializer_list<const char*> allowed) const;

 private:
  const json& object_;
  std::string place_;
  mutable Error error_;  // the first
};

// Lists and objects in each other, and values of all kinds together: a value takes up to 100 bytes.
struct JsonLimits {
  int depth = 8;
  std::size_t values = 500'000;
};

// Stops where the text is not JSON, goes beyond a limit or has a field twice, and names line and byte; takes
// time in proportion to the bytes read. what: of what it should be, for messages. A byte order mark is
// skipped.
Error parse_json(std::string_view text, const std::string& name, const JsonLimits& limits, const char* what,
                 nlohmann::json& root);

// The whole file, at most 16 MiB.
Error read_json_text(const std::string& path, std::string& text);

}  // namespace karst::app
