// SPDX-License-Identifier: MIT
// Carve JSON: what is read, every way in which it can be wrong, and what the shapes do to a solid.
#include "bake/carve/carve.h"

#include "tests/bake/bake_jobs.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>

#include <cmath>

namespace karst::bake {
namespace {

// Solid below y = 0.
class Ground final : public Solid {
 public:
  double value_m(glm::dvec3 p) const override { return -p.y; }
};

WorldGrid grid() {
  return grid_around({{-100, -60, -100}, {100, 60, 100}}, 5);
}

std::string error_of(const std::string& text) {
  std::vector<CarveShape> shapes;
  return parse_carve(text, "shapes.json", shapes).text();
}

std::vector<CarveShape> shapes_of(const std::string& text) {
  std::vector<CarveShape> shapes;
  EXPECT_EQ(parse_carve(text, "shapes.json", shapes).text(), "");
  return shapes;
}

CarvedSolid carved(const Solid& base, const std::vector<CarveShape>& shapes) {
  CarvedSolid solid(base, shapes, grid());
  EXPECT_EQ(solid.build().text(), "");
  return solid;
}

TEST(CarveJson, ReadsAllShapes) {
  const auto shapes = shapes_of(R"([
    {"shape": "box", "op": "fill", "center": [1, 2, 3], "size": [4, 6, 8], "radius": 2, "blend": 0.5},
    {"shape": "sphere", "op": "empty", "center": [-1, -2, -3], "radius": 7},
    {"shape": "capsule", "op": "empty", "points": [[0, 0, 0], [10, 0, 0], [10, 5, 0]], "radius": 1.5}])");
  ASSERT_EQ(shapes.size(), 3u);
  EXPECT_EQ(shapes[0].kind, CarveShape::Kind::box);
  EXPECT_TRUE(shapes[0].fill);
  EXPECT_EQ(shapes[0].centre_m, glm::dvec3(1, 2, 3));
  EXPECT_EQ(shapes[0].half_m, glm::dvec3(2, 3, 4));
  EXPECT_EQ(shapes[0].radius_m, 2);
  EXPECT_EQ(shapes[0].blend_m, 0.5);
  EXPECT_EQ(shapes[1].kind, CarveShape::Kind::sphere);
  EXPECT_FALSE(shapes[1].fill);
  EXPECT_EQ(shapes[1].blend_m, 0);
  EXPECT_EQ(shapes[2].points_m.size(), 3u);
  EXPECT_EQ(shapes[2].bounds().max, glm::dvec3(11.5, 6.5, 1.5));
  EXPECT_TRUE(shapes_of("[]").empty());
}

TEST(CarveJson, NamesFileShapeAndField) {
  const std::string sphere = R"("shape": "sphere", "op": "empty", "center": [0, 0, 0])";
  const struct {
    std::string shape, field;
  } cases[] = {
      {R"({"op": "fill"})", "shape: missing"},
      {R"({"shape": "cone", "op": "fill"})", "shape: not one of box, sphere, capsule"},
      {R"({"shape": 3, "op": "fill"})", "shape: not one of"},
      {R"({"shape": "sphere"})", "op: missing"},
      {R"({"shape": "sphere", "op": "dig"})", "op: not one of fill, empty"},
      {"{" + sphere + "}", "radius: missing"},
      {"{" + sphere + R"(, "radius": 0})", "radius: not a number in"},
      {"{" + sphere + R"(, "radius": -1})", "radius: not a number in"},
      {"{" + sphere + R"(, "radius": 1e300})", "radius: not a number in"},
      {"{" + sphere + R"(, "radius": "4"})", "radius: not a number in"},
      {"{" + sphere + R"(, "radius": null})", "radius: not a number in"},
      {"{" + sphere + R"(, "radius": 4, "blend": -1})", "blend: not a number in"},
      {"{" + sphere + R"(, "radius": 4, "colour": 1})", "colour: unknown field"},
      {"{" + sphere + R"(, "radius": 4, "size": [1, 1, 1]})", "size: unknown field"},
      {R"({"shape": "sphere", "op": "fill", "center": [0, 0], "radius": 1})", "center: not three numbers"},
      {R"({"shape": "sphere", "op": "fill", "center": [0, 0, 1e10], "radius": 1})",
       "center: not a number in"},
      {R"({"shape": "box", "op": "fill", "center": [0, 0, 0]})", "size: missing"},
      {R"({"shape": "box", "op": "fill", "center": [0, 0, 0], "size": [1, 0, 1]})", "size: not a number in"},
      {R"({"shape": "box", "op": "fill", "center": [0, 0, 0], "size": [2, 4, 4], "radius": 1.1})",
       "radius: not a number"},
      {R"({"shape": "capsule", "op": "fill", "radius": 1})", "points: missing"},
      {R"({"shape": "capsule", "op": "fill", "radius": 1, "points": [[0, 0, 0]]})",
       "points: not a list of two"},
      {R"({"shape": "capsule", "op": "fill", "radius": 1, "points": [[0, 0, 0], [0, 0]]})",
       "points: not three numbers"},
      {"7", "not an object"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.shape);
    const std::string message = error_of(
        "[{\"shape\": \"sphere\", \"op\": \"fill\", \"center\": [0,0,0], \"radius\": 1}, " + c.shape + "]");
    EXPECT_EQ(message.rfind("shapes.json: shape 1: ", 0), 0u) << message;
    EXPECT_NE(message.find(c.field), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// Reading stops there: what follows is not looked at.
TEST(CarveJson, StopsAtTheFirstByteThatIsTooMuch) {
  EXPECT_EQ(error_of("[1,\n 2,]"), "shapes.json: line 2, byte 7: not JSON");
  EXPECT_EQ(error_of("[{\"op\": 1,\n\"op\": 2}, ?"), "shapes.json: line 2, byte 14: 'op' is given twice");
  EXPECT_EQ(error_of("[[[[[[[[[[[[ ?"),
            "shapes.json: line 1, byte 8: nested too deeply for a list of shapes");
  std::string values = "[";
  for (int k = 0; k < 500'000; ++k) values += "{},";
  EXPECT_EQ(error_of(values + " ?"),
            "shapes.json: line 1, byte 1499998: more than 500000 values, too many for a list of shapes");
  std::vector<CarveShape> shapes;
  EXPECT_EQ(parse_carve("\xef\xbb\xbf[]", "shapes.json", shapes).text(), "");
}

TEST(CarveJson, RefusesWhatIsNoListOfShapes) {
  EXPECT_NE(error_of("").find("not JSON"), std::string::npos);
  EXPECT_NE(error_of("[").find("not JSON"), std::string::npos);
  EXPECT_NE(error_of("[NaN]").find("not JSON"), std::string::npos);
  EXPECT_NE(error_of("{}").find("not a list"), std::string::npos);
  EXPECT_NE(error_of(std::string(100'000, '[')).find("shapes.json: "), std::string::npos);
  std::string many = "[0";
  for (std::size_t k = 0; k < CarveShape::kMostShapes; ++k) many += ",0";
  EXPECT_NE(error_of(many + "]").find("the most is 10000"), std::string::npos);
  std::string points = R"([{"shape": "capsule", "op": "fill", "radius": 1, "points": [[0,0,0])";
  for (std::size_t k = 0; k < CarveShape::kMostPoints; ++k) points += ",[0,0,0]";
  EXPECT_NE(error_of(points + "]}]").find("more than 100000 points"), std::string::npos);
}

TEST(CarveJson, FilesThatCannotBeRead) {
  const test::Folder folder;
  for (const std::string& path : {folder.path("missing.json"), folder.path("")}) {
    std::vector<CarveShape> shapes;
    const std::string text = read_carve(path, shapes).text();
    EXPECT_FALSE(text.empty()) << path;
    EXPECT_EQ(text.rfind(path, 0), 0u) << text;
  }
}

TEST(CarvedSolid, FillsAndEmptiesInOrder) {
  const Ground ground;
  const auto shapes = shapes_of(R"([
    {"shape": "box", "op": "fill", "center": [0, 10, 0], "size": [20, 20, 20]},
    {"shape": "sphere", "op": "empty", "center": [0, 10, 0], "radius": 6},
    {"shape": "sphere", "op": "fill", "center": [0, 10, 0], "radius": 2}])");
  const CarvedSolid solid = carved(ground, shapes);
  EXPECT_GT(solid.value_m({8, 10, 0}), 0);   // in the box
  EXPECT_LT(solid.value_m({4, 10, 0}), 0);   // in the hollow
  EXPECT_GT(solid.value_m({1, 10, 0}), 0);   // in the core
  EXPECT_LT(solid.value_m({12, 10, 0}), 0);  // beside the box
  EXPECT_GT(solid.value_m({50, -1, 0}), 0);  // the ground elsewhere
  EXPECT_EQ(solid.value_m({50, 3, 0}), -3);
  EXPECT_NEAR(solid.value_m({9, 10, 0}), 1, 1e-12);  // a distance
  EXPECT_TRUE(solid.touches(0, 0));
  EXPECT_FALSE(solid.touches(50, 0));
}

TEST(CarvedSolid, TunnelFollowsItsPoints) {
  const Ground ground;
  const auto shapes = shapes_of(R"([{"shape": "capsule", "op": "empty", "radius": 5,
    "points": [[-80, -30, -80], [0, -30, 0], [80, -30, 0]]}])");
  const CarvedSolid solid = carved(ground, shapes);
  for (const glm::dvec3& p : {glm::dvec3(-40, -30, -40), {0, -30, 0}, {40, -30, 0}, {40, -26, 2}}) {
    EXPECT_LT(solid.value_m(p), 0) << p.x;
  }
  EXPECT_NEAR(solid.value_m({40, -22, 0}), 3, 1e-12);
  EXPECT_GT(solid.value_m({-40, -30, 0}), 0);
}

TEST(CarvedSolid, RoundedBoxAndBlend) {
  const Ground ground;
  const auto sharp =
      shapes_of(R"([{"shape": "box", "op": "fill", "center": [0, 30, 0], "size": [20, 20, 20]}])");
  const auto round = shapes_of(
      R"([{"shape": "box", "op": "fill", "center": [0, 30, 0], "size": [20, 20, 20], "radius": 5}])");
  const glm::dvec3 corner(9.5, 39.5, 9.5);
  EXPECT_GT(carved(ground, sharp).value_m(corner), 0);
  EXPECT_LT(carved(ground, round).value_m(corner), 0);

  const auto blended =
      shapes_of(R"([{"shape": "sphere", "op": "fill", "center": [0, 0, 0], "radius": 10, "blend": 8}])");
  const CarvedSolid solid = carved(ground, blended);
  EXPECT_GT(solid.value_m({11, 0.5, 0}), 0);  // the fillet at the foot of the ball
  EXPECT_LT(solid.value_m({30, 0.5, 0}), 0);
}

TEST(CarvedSolid, ValueIsContinuousInsideTheReach) {
  const Ground ground;
  const auto shapes =
      shapes_of(R"([{"shape": "sphere", "op": "fill", "center": [0, 0, 0], "radius": 20, "blend": 6},
    {"shape": "capsule", "op": "empty", "radius": 6, "points": [[-90, 4, 3], [90, 4, -3]], "blend": 2}])");
  const CarvedSolid solid = carved(ground, shapes);
  double last = solid.value_m({-60, 12, 1});
  for (double x = -60; x < 60; x += 0.01) {
    const double value = solid.value_m({x, 12, 1});
    // Off the shapes only the sign counts; near a surface there is no jump.
    if (std::abs(value) < 4 && std::abs(last) < 4) {
      ASSERT_NEAR(value, last, 0.02) << x;
    }
    last = value;
  }
}

TEST(CarvedSolid, RefusesMoreColumnsThanMemory) {
  const Ground ground;
  const WorldGrid wide = grid_around({{-500, 0, -500}, {500, 10, 500}}, 2);
  std::string text = "[";
  for (int k = 0; k < 100; ++k) {
    text += std::string(k > 0 ? "," : "") +
            R"({"shape": "sphere", "op": "fill", "center": [0, 0, 0], "radius": 5000})";
  }
  const auto shapes = shapes_of(text + "]");
  EXPECT_EQ(CarvedSolid(ground, shapes, wide).build().text().rfind("--carve: shape ", 0), 0u);
}

// Each shape that is asked about in each column takes time: what is more than a world needs must be asked
// for.
TEST(CarvedSolid, ManyShapesOverEachOtherMustBeAskedFor) {
  const Ground ground;
  const WorldGrid small = grid_around({{-50, 0, -50}, {50, 10, 50}}, 2);
  const auto columns = static_cast<std::size_t>(small.extent.x * small.extent.z);
  const std::size_t most = (131'072 + 4 * columns) / columns;  // that are as wide as the world
  CarveShape sphere =
      shapes_of(R"([{"shape": "sphere", "op": "fill", "center": [0, 0, 0], "radius": 500}])")[0];
  std::vector<CarveShape> shapes(most, sphere);
  EXPECT_EQ(CarvedSolid(ground, shapes, small).build().text(), "");
  shapes.push_back(sphere);
  const std::string entries = std::to_string(shapes.size() * columns);
  const std::string error = CarvedSolid(ground, shapes, small).build().text();
  EXPECT_EQ(error.rfind("--carve: the shapes reach " + entries + " columns of voxels together, of ", 0), 0u);
  EXPECT_NE(error.find("--max-carve " + entries), std::string::npos) << error;
  CarvedSolid solid(ground, shapes, small);
  EXPECT_EQ(solid.build(shapes.size() * columns).text(), "");
  EXPECT_TRUE(solid.touches(0, 0));
  // Beside the world they cost nothing.
  sphere.centre_m.x = 1e5;
  EXPECT_EQ(CarvedSolid(ground, std::vector<CarveShape>(9'999, sphere), small).build().text(), "");
}

}  // namespace
}  // namespace karst::bake
