// SPDX-License-Identifier: MIT
// A target of libFuzzer: a program of one file of tests/fuzz/targets, which defines fuzz_one, and of
// libfuzzer_main.cpp, or, in builds without libFuzzer, of replay_main.cpp. `./dev fuzz` runs all of them.
#pragma once

#include "platform/base/error.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace karst {

// Whatever the bytes are, it returns; what has to hold and does not is a trap.
void fuzz_one(std::span<const std::byte> input);

// Before all else, with the words of main(). A target that works in children serves as one here and exits.
void start_target(std::span<char* const> words);

inline void must(bool holds) {
  if (!holds) __builtin_trap();
}

// What a user is told can be read: it quotes no more than a part of the input.
inline void must_be_short(const Error& error) {
  must(error.text().size() < 1'000);
}

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace karst
