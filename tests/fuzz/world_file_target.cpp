// SPDX-License-Identifier: MIT
// The entry of libFuzzer. The build's own fuzz test is deterministic and needs no libFuzzer; this one runs
// for as long as you like, from the root of the repository, over a folder of .karst files:
//   clang++ -std=c++20 -g -O1 -I. -fsanitize=fuzzer,address,undefined -fconstexpr-steps=100000000
//     tests/fuzz/world_file_target.cpp terrain/*/*.cpp -o build/fuzz_world_file
#include "tests/fuzz/world_file_target.h"

#include "tests/support/world_damage.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// Each input as it is and with checksums that fit, or nothing behind them would ever be reached.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::byte> file(size);
  if (size != 0) std::memcpy(file.data(), data, size);
  karst::core::fuzz_world_file(file);
  karst::core::fix_checksums(file);
  karst::core::fuzz_world_file(file);
  return 0;
}
