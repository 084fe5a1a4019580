// SPDX-License-Identifier: MIT
// Material files: what is read, and every way in which they can be wrong.
#include "bake/materials/material_json.h"

#include "tests/support/process.h"

#include <gtest/gtest.h>

#include <string>

namespace karst::bake {
namespace {

std::string error_of(const std::string& text) {
  MaterialFile file;
  return parse_material_file(text, "ground.json", file).text();
}

MaterialFile parsed(const std::string& text, const std::string& name) {
  MaterialFile file;
  EXPECT_EQ(parse_material_file(text, name, file).text(), "");
  return file;
}

TEST(MaterialJson, ReadsAllFields) {
  const MaterialFile file = parsed(R"({
    "side": 128, "format": "rgba8", "repeat": 3.5,
    "materials": [
      {"name": "base", "sample": "rock"},
      {"name": "moss", "albedo": "a.png", "height": "h.png", "normal": "n.png", "roughness": "r.png",
       "relief": 0.05, "slope": [0.7, null], "slope_soft": 0.2, "elevation": [null, 900],
       "elevation_soft": 40, "cave": 0.25, "fray": 0.5},
      {"name": "clay", "albedo": "c.png", "roughness": 0.4}],
    "paint": [{"center": [1, 2, 3], "size": [4, 5, 6], "material": "clay"}],
    "lights": [{"position": [7, 8, 9], "radius": 30, "color": [1, 0.5, 0.25]}]})",
                                   "ground.json");
  EXPECT_EQ(file.side, 128);
  EXPECT_EQ(file.format, TextureFormat::rgba8);
  EXPECT_EQ(file.repeat_m, 3.5);
  ASSERT_EQ(file.materials.size(), 3u);
  EXPECT_EQ(file.materials[0].sample, "rock");
  EXPECT_FALSE(file.materials[0].slope || file.materials[0].cave || file.materials[0].fray);
  const MaterialSpec& moss = file.materials[1];
  EXPECT_EQ(moss.albedo + moss.height + moss.normal + moss.roughness, "a.pngh.pngn.pngr.png");
  EXPECT_EQ(moss.relief, 0.05);
  EXPECT_EQ((*moss.slope)[0], 0.7);
  EXPECT_FALSE((*moss.slope)[1].has_value());
  EXPECT_EQ(moss.slope_soft, 0.2);
  EXPECT_FALSE((*moss.elevation)[0].has_value());
  EXPECT_EQ((*moss.elevation)[1], 900);
  EXPECT_EQ(moss.elevation_soft, 40);
  EXPECT_EQ(moss.cave, 0.25);
  EXPECT_EQ(moss.fray, 0.5);
  EXPECT_EQ(file.materials[2].roughness_value, 0.4);
  ASSERT_EQ(file.paint.size(), 1u);
  EXPECT_EQ(file.paint[0].centre_m, glm::dvec3(1, 2, 3));
  EXPECT_EQ(file.paint[0].size_m, glm::dvec3(4, 5, 6));
  ASSERT_EQ(file.lights->size(), 1u);
  EXPECT_EQ((*file.lights)[0].radius_m, 30);
  EXPECT_EQ((*file.lights)[0].colour, glm::dvec3(1, 0.5, 0.25));
}

TEST(MaterialJson, EverythingMayBeMissing) {
  const MaterialFile file = parsed("{}", "ground.json");
  EXPECT_TRUE(file.materials.empty());
  EXPECT_FALSE(file.lights.has_value());
  EXPECT_TRUE(parsed(R"({"lights": []})", "ground.json").lights->empty());
}

TEST(MaterialJson, NamesFileEntryAndField) {
  const struct {
    std::string text, mentions;
  } cases[] = {
      {"", "not JSON"},
      {"[]", "not an object"},
      {std::string(50'000, '['), "ground.json: "},
      {R"({"size": 3})", "size: unknown field"},
      {R"({"side": 100})", "side: not a power of two"},
      {R"({"side": 64.5})", "side: not a power of two"},
      {R"({"side": 8})", "side: not a number in 16"},
      {R"({"side": 2048})", "side: not a number in 16"},
      {R"({"repeat": 0})", "repeat: not a number in 1e-06"},
      {R"({"format": "png"})", "format: not one of etc2, rgba8"},
      {R"({"materials": {}})", "materials: not a list"},
      {R"({"materials": []})", "materials: an empty list"},
      {R"({"materials": [0]})", "material 0: not an object"},
      {R"({"materials": [{"sample": "rock"}]})", "material 0: name: missing"},
      {R"({"materials": [{"name": "", "sample": "rock"}]})", "name: not text of 1 to 15"},
      {R"({"materials": [{"name": "sixteen letters.", "sample": "rock"}]})", "name: not text of 1 to 15"},
      {R"({"materials": [{"name": "a\nb", "sample": "rock"}]})", "name: not printable"},
      {R"({"materials": [{"name": "a"}]})", "albedo: missing"},
      {R"({"materials": [{"name": "a", "sample": "lava"}]})", "sample: not one of grass, rock"},
      {R"({"materials": [{"name": "a", "sample": "rock", "albedo": "x"}]})", "albedo: not beside sample"},
      {R"({"materials": [{"name": "a", "albedo": 3}]})", "albedo: not text"},
      {R"({"materials": [{"name": "a", "albedo": "x", "roughness": 2}]})", "roughness: not a number in 0"},
      {R"({"materials": [{"name": "a", "sample": "rock", "slope": 1}]})", "slope: not two limits"},
      {R"({"materials": [{"name": "a", "sample": "rock", "slope": [0.5, 0.4]}]})", "slope: the first limit"},
      {R"({"materials": [{"name": "a", "sample": "rock", "slope": [0, 7]}]})", "slope: not a number in -1"},
      {R"({"materials": [{"name": "a", "sample": "rock", "slope_soft": 0}]})", "slope_soft: not a number"},
      {R"({"materials": [{"name": "a", "sample": "rock", "elevation": [0, "x"]}]})", "elevation: not a num"},
      {R"({"materials": [{"name": "a", "sample": "rock", "cave": 1.5}]})", "cave: not a number in 0"},
      {R"({"materials": [{"name": "a", "sample": "rock"}, {"name": "a", "sample": "sand"}]})",
       "material 1: name: the same"},
      {R"({"paint": [{"center": [0, 0], "size": [1, 1, 1], "material": "rock"}]})", "paint 0: center"},
      {R"({"paint": [{"center": [0, 0, 0], "size": [1, 0, 1], "material": "rock"}]})", "paint 0: size"},
      {R"({"paint": [{"center": [0, 0, 0], "size": [1, 1, 1]}]})", "paint 0: material: missing"},
      {R"({"lights": [{"position": [0, 0, 0], "radius": 0, "color": [1, 1, 1]}]})", "light 0: radius"},
      {R"({"lights": [{"position": [0, 0, 0], "radius": 1, "color": [1, 1, -1]}]})", "light 0: color"},
      {R"({"lights": [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]})", "lights: more than 16"},
  };
  for (const auto& c : cases) {
    const std::string message = error_of(c.text);
    EXPECT_EQ(message.rfind("ground.json: ", 0), 0u) << message;
    EXPECT_NE(message.find(c.mentions), std::string::npos) << c.text.substr(0, 200) << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  std::string nine = R"({"materials": [)";
  for (int k = 0; k < 9; ++k)
    nine += std::string(k > 0 ? "," : "") + R"({"name": "m)" + std::to_string(k) + R"(", "sample": "rock"})";
  EXPECT_NE(error_of(nine + "]}").find("materials: more than 8"), std::string::npos);
}

TEST(MaterialJson, FilesThatCannotBeRead) {
  const test::Folder folder;
  MaterialFile file;
  const Error error = read_material_file(folder.path("missing.json"), file);
  EXPECT_NE(error.text().find("missing.json"), std::string::npos);
}

// The page's example is one that works.
TEST(MaterialJson, TheDocumentedExampleIsRead) {
  const std::string page = test::read_text(std::string(KARST_SOURCE_DIR) + "/docs/materials.md");
  const std::size_t start = page.find("```json\n");
  ASSERT_NE(start, std::string::npos);
  const std::size_t end = page.find("```", start + 8);
  const MaterialFile file = parsed(page.substr(start + 8, end - start - 8), "materials.md");
  EXPECT_GE(file.materials.size(), 3u);
  EXPECT_FALSE(file.paint.empty());
  EXPECT_FALSE(file.lights->empty());
}

}  // namespace
}  // namespace karst::bake
