// SPDX-License-Identifier: MIT
#include "app/edit/edit_script.h"

#include <gtest/gtest.h>

#include <cstring>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/test_world.h"

namespace karst::app {
namespace {

// What is wrong with a script of one line.
std::string fault_of(const std::string& line) {
  std::vector<ScriptStep> steps;
  return parse_script(line, "a.json", steps).text();
}

ScriptStep step_of(const std::string& line) {
  ScriptStep step;
  EXPECT_EQ(parse_script_line(line, "a", step).text(), "");
  return step;
}

TEST(EditScript, LinesAndListsMeanTheSame) {
  const std::string one = R"({"tool": "clear", "shape": "sphere", "place_m": [1, 2, -3.5], "radius_m": 4})";
  const std::string two = R"({"tool": "undo"})";
  for (const std::string& text :
       {one + "\n\n" + two + "\n", "[" + one + ",\n" + two + "]", "\xef\xbb\xbf" + one + "\r\n" + two}) {
    std::vector<ScriptStep> steps;
    ASSERT_EQ(parse_script(text, "a.json", steps).text(), "");
    ASSERT_EQ(steps.size(), 2u);
    EXPECT_EQ(steps[0].what.tool, EditTool::clear);
    EXPECT_EQ(steps[0].what.place.z, -3.5);
    EXPECT_EQ(steps[0].what.radius_m, 4);
    EXPECT_EQ(steps[1].kind, ScriptStep::undo);
  }
  std::vector<ScriptStep> none{{}};
  EXPECT_EQ(parse_script("\n  \n", "a.json", none).text(), "");
  EXPECT_TRUE(none.empty());
}

TEST(EditScript, FaultsAreNamed) {
  EXPECT_EQ(fault_of(R"({"tool": "explode", "place_m": [0, 0, 0]})"),
            "a.json: line 1: tool: not one of clear, fill, extrude, smooth, noise, flatten, level, paint, "
            "undo, redo");
  EXPECT_EQ(fault_of(R"({"tool": "clear"})"), "a.json: line 1: place_m: missing");
  EXPECT_EQ(fault_of(R"({"tool": "clear", "place_m": [0, 1e99, 0]})"),
            "a.json: line 1: place_m: not a number in -1000000000.0 to 1000000000.0");
  EXPECT_EQ(fault_of(R"({"tool": "clear", "place_m": [0, 0, 0], "radius": 3})"),
            "a.json: line 1: radius: unknown field");
  EXPECT_EQ(fault_of(R"({"tool": "clear", "shape": "capsule", "place_m": [0, 0, 0]})"),
            "a.json: line 1: to_m: missing");
  EXPECT_EQ(fault_of(R"({"tool": "clear", "shape": "voxel", "place_m": [0, 0, 0], "octree_level": 2.5})"),
            "a.json: line 1: octree_level: not a whole number");
  EXPECT_EQ(fault_of(R"({"tool": "clear", "place_m": [0, 0, 0], "radius_m": -1})"),
            "a.json: line 1: radius_m: not a number in 0.001 to 1000000.0");
  EXPECT_EQ(fault_of("\n{\"tool\": "), "a.json: line 2: line 1, byte 8: not JSON");
  EXPECT_EQ(fault_of("[3]"), "a.json: edit 0: not an object");
  EXPECT_NE(fault_of(R"({"tool": "clear", "place_m": [0, 0, NaN]})"), "");
}

TEST(EditScript, ALineMeansTheSameBits) {
  test::Random random{9};
  for (int n = 0; n < 2'000; ++n) {
    ScriptStep step;
    const auto length = [&] { return std::ldexp(random.unit() + 0.001, random.below(18)) + 0.001; };
    const auto place = [&] { return Vec3{length() - length(), length() - length(), length() - length()}; };
    step.what.tool = static_cast<EditTool>(random.below(8));
    step.what.shape = static_cast<BrushShape>(random.below(5));
    step.what.place = step.what.to = place();
    if (step.what.shape == BrushShape::capsule) step.what.to = place();
    if (step.what.shape == BrushShape::box) step.what.half_m = {length(), length(), length()};
    if (step.what.shape == BrushShape::voxel)
      step.what.octree_level = static_cast<std::uint8_t>(random.below(10));
    if (step.what.tool == EditTool::paint) step.what.material = static_cast<std::uint8_t>(random.below(256));
    if (step.what.tool == EditTool::flatten) step.what.up = place();
    step.what.radius_m = length();
    step.what.strength_m = length() - length();
    step.what.amount = random.unit();
    step.what.hardness = random.unit();
    step.what.wave_m = length();
    step.what.seed = static_cast<std::uint32_t>(random.next());
    step.joined = random.below(2) == 1;
    const std::string line = script_line(step);
    const ScriptStep again = step_of(line);
    EXPECT_EQ(script_line(again), line);
    EXPECT_EQ(again.joined, step.joined);
    const Edit &a = again.what, &b = step.what;
    EXPECT_EQ(std::tie(a.tool, a.shape, a.octree_level, a.material, a.radius_m, a.strength_m, a.amount,
                       a.hardness, a.wave_m, a.seed),
              std::tie(b.tool, b.shape, b.octree_level, b.material, b.radius_m, b.strength_m, b.amount,
                       b.hardness, b.wave_m, b.seed));
    for (const auto member : {&Edit::place, &Edit::to, &Edit::half_m, &Edit::up}) {
      const Vec3 &v = a.*member, &w = b.*member;
      EXPECT_EQ(std::tie(v.x, v.y, v.z), std::tie(w.x, w.y, w.z));
    }
  }
}

// By name or by number, and none by either.
TEST(EditScript, MaterialsAreFoundByName) {
  WorldInfo info;
  info.materials = 2;
  std::strcpy(info.material_names[0], "rock");
  std::strcpy(info.material_names[1], "grass");
  std::vector<ScriptStep> steps;
  const char* const script =
      R"({"tool": "paint", "place_m": [1, 2, 3], "material": "grass"}
{"tool": "paint", "place_m": [1, 2, 3], "material": 0}
{"tool": "paint", "place_m": [1, 2, 3], "material": "none"}
{"tool": "clear", "place_m": [1, 2, 3]})";
  ASSERT_TRUE(parse_script(script, "a.json", steps).ok());
  ASSERT_TRUE(find_materials(info, "a.json", steps).ok());
  ASSERT_EQ(steps.size(), 4u);
  EXPECT_EQ(steps[0].what.material, 1);
  EXPECT_EQ(steps[1].what.material, 0);
  EXPECT_EQ(steps[2].what.material, kNoMaterial);
  info.materials = 1;
  EXPECT_EQ(find_materials(info, "a.json", steps).text(),
            "a.json: edit 0: material: not one of the world's: none, rock");
  for (const char* const wrong : {R"({"tool": "paint", "place_m": [1, 2, 3]})",
                                  R"({"tool": "paint", "place_m": [1, 2, 3], "material": 2.5})",
                                  R"({"tool": "paint", "place_m": [1, 2, 3], "material": ""})",
                                  R"({"tool": "paint", "place_m": [1, 2, 3], "material": [1]})"}) {
    EXPECT_NE(parse_script(wrong, "a.json", steps).text().find("material"), std::string::npos) << wrong;
  }
}

}  // namespace
}  // namespace karst::app
