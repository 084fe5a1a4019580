// SPDX-License-Identifier: MIT
// JSON text, written in order. Numbers are the shortest text that reads back as the same value; NaN and
// infinities, which JSON cannot say, become null.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace karst::app {

class JsonWriter {
 public:
  // In an object every value is preceded by key(); in an array it is not. Containers are closed by the
  // caller.
  JsonWriter& begin_object() { return open('{'); }
  JsonWriter& end_object() { return close('}'); }
  JsonWriter& begin_array() { return open('['); }
  JsonWriter& end_array() { return close(']'); }
  JsonWriter& key(std::string_view name);

  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& value(double number);
  JsonWriter& value(std::int64_t number);
  JsonWriter& value(std::uint64_t number);
  JsonWriter& value(int number) { return value(std::int64_t{number}); }
  JsonWriter& value(unsigned number) { return value(std::uint64_t{number}); }
  JsonWriter& value(bool yes);
  JsonWriter& null();

  template <class T>
  JsonWriter& field(std::string_view name, T content) {
    return key(name).value(content);
  }

  // The text so far, indented by two spaces, with a newline at the end once the outermost container is
  // closed.
  const std::string& text() const { return text_; }

 private:
  JsonWriter& open(char bracket);
  JsonWriter& close(char bracket);
  void before_value();
  void new_line();
  void quote(std::string_view text);

  std::string text_;
  int depth_ = 0;
  bool first_ = true;  // nothing is in the innermost container yet
  bool after_key_ = false;
};

}  // namespace karst::app
