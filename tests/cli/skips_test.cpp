// SPDX-License-Identifier: MIT
// What is skipped changes no pixel: flights through halls in rock, and over them, with and without each skip.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Folder;
using test::ProcessResult;
using test::Random;
using test::read_text;

constexpr glm::ivec3 kExtent{34, 24, 34};
constexpr int kFrames = 24;

bool is_rock(glm::ivec3 v) {
  if (v.y > kExtent.y - 4) return false;
  return v.y < 2 || test::value_noise(21, glm::dvec3(v) / 6.5) > -0.25;
}

// Several frames beside each other from each of some places in the air; metres are voxels.
std::string flight() {
  Random random{601};
  std::string text;
  for (int n = 0; n < kFrames;) {
    const glm::dvec3 p = glm::dvec3(kExtent) * glm::dvec3(random.unit(), random.unit(), random.unit());
    bool is_air = true;
    for (int k = 0; k < 27; ++k) {
      is_air = is_air && !is_rock(glm::ivec3(p) + glm::ivec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
    }
    if (!is_air) continue;
    const double yaw = 360 * random.unit();
    for (int step = 0; step < 2; ++step, ++n) {
      char line[128];
      std::snprintf(line, sizeof line, "%.3f %.3f %.3f %.2f %.2f\n", p.x, p.y, p.z, yaw + 3 * step,
                    -20.0 + 30 * random.unit());
      text += line;
    }
  }
  return text;
}

double mean_in(const std::string& stats, const std::string& name) {
  const std::size_t at = stats.find("\"" + name + "\": ");
  return at == std::string::npos ? -1.0 : std::stod(stats.substr(at + name.size() + 4));
}

TEST(Skips, ChangeNoPixel) {
  const Folder folder;
  test::TestWorld world(kExtent, is_rock);
  world.set_heights(3, [](glm::dvec3 p) {
    return 1800 * test::value_noise(5, p * 0.8) + 300 * test::value_noise(6, p * 6.0);
  });
  const std::string file = folder.write("halls.karst", world.file());
  const std::string path = folder.write("flight.txt", flight());
  const auto render = [&](const std::string& name) {
    std::vector<std::string> arguments = {"render",
                                          file,
                                          "--path",
                                          path,
                                          "--size",
                                          "160x90",
                                          "--error-px",
                                          "1",
                                          "--vertex-memory",
                                          "64",
                                          "-o",
                                          folder.path(name + "%04d.png"),
                                          "--stats",
                                          folder.path(name + ".json")};
    if (name != "all_skipped") arguments.insert(arguments.end(), {"--no-skip", name});
    const ProcessResult result = test::run_process(KARST_APP_PATH, arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return read_text(folder.path(name + ".json"));
  };
  const std::string skipping = render("all_skipped");
  // The flight sees what it is to test.
  EXPECT_GT(mean_in(skipping, "culled_occluded"), 50.0);
  EXPECT_GT(mean_in(skipping, "culled_backface"), 10.0);
  EXPECT_EQ(mean_in(skipping, "error_scale"), 1.0);
  for (const char* name : {"occlusion", "backface", "frustum", "cascades", "all"}) {
    const std::string stats = render(name);
    EXPECT_EQ(mean_in(stats, "error_scale"), 1.0) << name;
    for (int n = 0; n < kFrames; ++n) {
      char number[16];
      std::snprintf(number, sizeof number, "%04d.png", n);
      EXPECT_TRUE(read_text(folder.path("all_skipped" + std::string(number))) ==
                  read_text(folder.path(name + std::string(number))))
          << "frame " << n << " without skipping: " << name;
    }
  }
}

}  // namespace
}  // namespace karst::core
