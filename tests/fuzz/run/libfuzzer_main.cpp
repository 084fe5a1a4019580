// SPDX-License-Identifier: MIT
// The entries that libFuzzer calls.
#include "tests/fuzz/run/fuzz_target.h"

extern "C" int LLVMFuzzerInitialize(int* count, char*** words);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
  karst::start_target({*words, static_cast<std::size_t>(*count)});
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  karst::fuzz_one(std::as_bytes(std::span(data, size)));
  return 0;
}
