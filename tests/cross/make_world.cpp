// SPDX-License-Identifier: MIT
// make_world FILE: a small world for tests of programs that run under an emulator, where karst-bake is not.
#include <cstdio>
#include <fstream>

#include "tests/support/test_world.h"

int main(int argc, char** argv) {
  using namespace karst::test;
  if (argc != 2) return 2;
  TestWorld world = TestWorld::hills();
  world.roughen(2, 9, 500);
  const std::vector<std::byte> bytes = world.file();
  std::ofstream file(argv[1], std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file.good() ? 0 : 1;
}
