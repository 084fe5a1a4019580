// SPDX-License-Identifier: MIT
// The result of every function of the core that can fail: what failed, and which limit or field to change.
// Holds static strings only, so it is trivially copyable and never allocates.
#pragma once

#include <cstdint>

namespace karst {

enum class StatusCode : std::uint8_t {
  ok,
  invalid_argument,  // the caller broke a stated range or shape
  limit_reached,  // a Config limit is too small; field() names it and value() is what was needed (0: unknown)
  corrupt,        // untrusted bytes are not what they claim; field() names the field, value() its byte offset
  unsupported,    // well-formed, but of a version or kind this build does not read
  io,             // bytes could not be read; value() is the byte offset where reading began
};

class [[nodiscard]] Status {
 public:
  constexpr Status() = default;
  // what, field: string literals or other storage that outlives the Status.
  constexpr Status(StatusCode code, const char* what, const char* field = "", std::uint64_t value = 0)
      : what_(what), field_(field), value_(value), code_(code) {}

  constexpr bool ok() const { return code_ == StatusCode::ok; }
  constexpr StatusCode code() const { return code_; }
  constexpr const char* what() const { return what_; }    // one clause: "voxel octets are used up"
  constexpr const char* field() const { return field_; }  // the limit to raise or the field that is wrong
  constexpr std::uint64_t value() const { return value_; }

 private:
  const char* what_ = "ok";
  const char* field_ = "";
  std::uint64_t value_ = 0;
  StatusCode code_ = StatusCode::ok;
};

}  // namespace karst
