// SPDX-License-Identifier: MIT
// printf into strings, for reports.
#pragma once

#include <cstdint>
#include <string>

namespace karst::bake {

// Appends, 511 bytes at most.
__attribute__((format(printf, 2, 3))) void print(std::string& out, const char* format, ...);

// For %llu.
inline unsigned long long number(std::uint64_t n) {
  return n;
}

}  // namespace karst::bake
