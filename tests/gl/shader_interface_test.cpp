// SPDX-License-Identifier: MIT
// C++ and the linked programs agree on everything in interface.glsl.
#include <array>
#include <cstddef>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/input/shader_interface.h"
#include "renderer/passes/programs.h"
#include "renderer/resources/material_textures.h"
#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::GlContext;

#define KARST_FIELD(name, type)                \
  {                                            \
#name, {                                   \
      offsetof(shader::FrameBlock, name), type \
    }                                          \
  }
#define KARST_MATERIAL(name, text)                         \
  {                                                        \
    text, {                                                \
      offsetof(shader::MaterialBlock, name), GL_FLOAT_VEC4 \
    }                                                      \
  }
#define KARST_ARRAY(name, type)                \
  {                                            \
#name "[0]", {                             \
      offsetof(shader::FrameBlock, name), type \
    }                                          \
  }
struct Field {
  std::size_t offset;
  GLenum type;
};
const std::map<std::string, Field> kFields = {KARST_FIELD(clip_from_lattice, GL_FLOAT_MAT4),
                                              KARST_FIELD(camera_voxel, GL_INT_VEC4),
                                              KARST_FIELD(camera_fine, GL_FLOAT_VEC4),
                                              KARST_FIELD(first_rows, GL_INT_VEC4),
                                              KARST_FIELD(morph_view, GL_FLOAT_VEC4),
                                              KARST_FIELD(ray_right, GL_FLOAT_VEC4),
                                              KARST_FIELD(ray_up, GL_FLOAT_VEC4),
                                              KARST_FIELD(ray_forward, GL_FLOAT_VEC4),
                                              KARST_FIELD(sun_direction, GL_FLOAT_VEC4),
                                              KARST_FIELD(sun_light, GL_FLOAT_VEC4),
                                              KARST_FIELD(sky_light, GL_FLOAT_VEC4),
                                              KARST_FIELD(ground_light, GL_FLOAT_VEC4),
                                              KARST_FIELD(sky_zenith, GL_FLOAT_VEC4),
                                              KARST_FIELD(sky_horizon, GL_FLOAT_VEC4),
                                              KARST_FIELD(view_scale, GL_FLOAT_VEC4),
                                              KARST_FIELD(sky_scale, GL_FLOAT_VEC4),
                                              KARST_FIELD(sky_octrees, GL_INT_VEC4),
                                              KARST_ARRAY(sky_corner, GL_FLOAT_VEC4),
                                              KARST_ARRAY(sky_box, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_x, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_y, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_z, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_box_0, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_box_1, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_box_2, GL_FLOAT_VEC4),
                                              KARST_FIELD(shadow_scale, GL_FLOAT_VEC4),
                                              KARST_FIELD(drape_place, GL_FLOAT_VEC4),
                                              KARST_FIELD(water, GL_FLOAT_VEC4),
                                              KARST_ARRAY(water_wave, GL_FLOAT_VEC4),
                                              KARST_FIELD(plain, GL_FLOAT_VEC4),
                                              KARST_FIELD(level_x, GL_FLOAT_VEC4),
                                              KARST_FIELD(level_y, GL_FLOAT_VEC4),
                                              KARST_FIELD(level_z, GL_FLOAT_VEC4),
                                              KARST_FIELD(level_eye, GL_FLOAT_VEC4),
                                              KARST_FIELD(level_top, GL_FLOAT_VEC4),
                                              KARST_FIELD(level_air, GL_FLOAT_VEC4),
                                              KARST_FIELD(least_work, GL_INT_VEC4),
                                              KARST_FIELD(screen_place, GL_INT_VEC4),
                                              KARST_FIELD(screen_scale, GL_FLOAT_VEC4),
                                              KARST_FIELD(screen_depth, GL_FLOAT_VEC4),
                                              KARST_FIELD(image_centre, GL_INT_VEC4),
                                              KARST_FIELD(image_sizes, GL_INT_VEC4),
                                              KARST_FIELD(image_eye, GL_FLOAT_VEC4),
                                              KARST_FIELD(image_scale, GL_FLOAT_VEC4),
                                              KARST_FIELD(light_scale, GL_FLOAT_VEC4),
                                              KARST_ARRAY(light_place, GL_FLOAT_VEC4),
                                              KARST_ARRAY(light_colour, GL_FLOAT_VEC4)};
const std::map<std::string, Field> kMaterialFields = {
    KARST_MATERIAL(material_scale, "material_scale"),
    {"material_repeat", {offsetof(shader::MaterialBlock, material_repeat), GL_INT_VEC4}},
    KARST_MATERIAL(material_slope, "material_slope[0]"),
    KARST_MATERIAL(material_height, "material_height[0]"),
    KARST_MATERIAL(material_average, "material_average[0]"),
    KARST_MATERIAL(material_tint, "material_tint[0]"),
    KARST_MATERIAL(material_near, "material_near[0]"),
    KARST_MATERIAL(material_blend, "material_blend[0]"),
    KARST_MATERIAL(material_blend_place, "material_blend_place")};
#undef KARST_MATERIAL
#undef KARST_ARRAY
#undef KARST_FIELD

class ShaderInterface : public testing::Test {
 protected:
  void SetUp() override {
    constexpr ProgramSettings kSettings[] = {
        {.materials = 3, .blend_map = true, .imagery = true, .shadows = true},
        {.materials = 3, .deferred = true, .blend_map = true, .imagery = true, .shadows = true},
        {.drape = true}};
    for (std::size_t n = 0; n < std::size(kSettings); ++n) {
      const Status status = sets_[n].create(context_.gl(), kSettings[n], log_);
      ASSERT_TRUE(status.ok()) << status.what() << ' ' << log_.data();
    }
  }
  void TearDown() override {
    for (Programs& set : sets_) set.destroy(context_.gl());
    EXPECT_EQ(context_.gl().GetError(), GLenum{GL_NO_ERROR});
  }

  // The program of a renderer that needs it.
  GLuint program_of(ShaderVariant variant) const {
    GLuint program = 0;
    for (const Programs& set : sets_) program = program != 0 ? program : set[variant];
    return program;
  }

  GLint program_value(GLuint program, GLenum name) {
    GLint value = 0;
    context_.gl().GetProgramiv(program, name, &value);
    return value;
  }

  void check_block(ShaderVariant variant, const char* block_name, const std::map<std::string, Field>& fields,
                   std::size_t bytes, GLint expected_binding) {
    const auto get_uniform = context_.function<PFNGLGETACTIVEUNIFORMPROC>("glGetActiveUniform");
    const auto get_uniforms = context_.function<PFNGLGETACTIVEUNIFORMSIVPROC>("glGetActiveUniformsiv");
    const auto get_block = context_.function<PFNGLGETACTIVEUNIFORMBLOCKIVPROC>("glGetActiveUniformBlockiv");
    const GLuint program = program_of(variant);
    const GLuint block = context_.gl().GetUniformBlockIndex(program, block_name);
    ASSERT_NE(block, GL_INVALID_INDEX);
    GLint size = 0;
    get_block(program, block, GL_UNIFORM_BLOCK_DATA_SIZE, &size);
    EXPECT_EQ(static_cast<std::size_t>(size), bytes);
    GLint binding = -1;
    get_block(program, block, GL_UNIFORM_BLOCK_BINDING, &binding);
    EXPECT_EQ(binding, expected_binding);
    std::size_t members = 0;
    for (GLint i = 0; i < program_value(program, GL_ACTIVE_UNIFORMS); ++i) {
      const auto index = static_cast<GLuint>(i);
      GLint in_block = -1;
      get_uniforms(program, 1, &index, GL_UNIFORM_BLOCK_INDEX, &in_block);
      if (in_block != static_cast<GLint>(block)) continue;
      char name[64];
      GLint count = 0;
      GLenum type = 0;
      get_uniform(program, index, sizeof name, nullptr, &count, &type, name);
      const auto field = fields.find(name);
      ASSERT_NE(field, fields.end()) << name;
      GLint offset = -1;
      get_uniforms(program, 1, &index, GL_UNIFORM_OFFSET, &offset);
      EXPECT_EQ(static_cast<std::size_t>(offset), field->second.offset) << name;
      EXPECT_EQ(type, field->second.type) << name;
      ++members;
    }
    EXPECT_EQ(members, fields.size());
  }

  GlContext& context_ = GlContext::get();
  Programs sets_[3];  // what renderers of three kinds need
  std::array<char, 2048> log_{};
};

TEST_F(ShaderInterface, EveryVariantCompilesAndIsNamedOnce) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kShaderVariants; ++i) {
    EXPECT_NE(program_of(static_cast<ShaderVariant>(i)), 0u) << kShaderTexts[i].name;
    EXPECT_TRUE(names.insert(kShaderTexts[i].name).second) << kShaderTexts[i].name;
    EXPECT_EQ(std::string(kShaderTexts[i].vertex).rfind("#version 300 es\n", 0), 0u);
    EXPECT_EQ(std::string(kShaderTexts[i].fragment).rfind("#version 300 es\n", 0), 0u);
  }
  EXPECT_STREQ(kShaderTexts[static_cast<std::size_t>(ShaderVariant::terrain)].name, "terrain");
}

TEST_F(ShaderInterface, AttributesAreWhereCppPutsThem) {
  const auto get_location = context_.function<PFNGLGETATTRIBLOCATIONPROC>("glGetAttribLocation");
  const GLuint terrain = program_of(ShaderVariant::terrain);
  EXPECT_EQ(get_location(terrain, "position_normal"), KARST_LOCATION_POSITION);
  EXPECT_EQ(get_location(terrain, "morph_normal"), KARST_LOCATION_MORPH);
  // No attribute that the vertex array does not supply.
  for (std::size_t i = 0; i < kShaderVariants; ++i) {
    const GLuint program = program_of(static_cast<ShaderVariant>(i));
    const auto get_attribute = context_.function<PFNGLGETACTIVEATTRIBPROC>("glGetActiveAttrib");
    for (GLint a = 0; a < program_value(program, GL_ACTIVE_ATTRIBUTES); ++a) {
      char name[64];
      GLint size = 0;
      GLenum type = 0;
      get_attribute(program, static_cast<GLuint>(a), sizeof name, nullptr, &size, &type, name);
      if (std::strncmp(name, "gl_", 3) == 0) continue;  // gl_VertexID
      EXPECT_EQ(type, GLenum{GL_INT_VEC4}) << name;
      const GLint location = get_location(program, name);
      EXPECT_TRUE(location == KARST_LOCATION_POSITION || location == KARST_LOCATION_MORPH) << name;
    }
  }
}

TEST_F(ShaderInterface, BlocksHaveTheOffsetsOfTheStructs) {
  check_block(ShaderVariant::terrain_blend, "FrameBlock", kFields, sizeof(shader::FrameBlock),
              KARST_BINDING_FRAME);
  check_block(ShaderVariant::sky, "FrameBlock", kFields, sizeof(shader::FrameBlock), KARST_BINDING_FRAME);
  check_block(ShaderVariant::terrain_blend, "MaterialBlock", kMaterialFields, sizeof(shader::MaterialBlock),
              KARST_BINDING_MATERIALS);
}

TEST_F(ShaderInterface, SamplersReadTheirUnits) {
  const std::map<std::string, GLint> units = {
      {"page_table", KARST_UNIT_PAGE_TABLE},         {"morph_entries", KARST_UNIT_MORPH_ENTRIES},
      {"morph_rows", KARST_UNIT_MORPH_ROWS},         {"far_textures", KARST_UNIT_FAR_TEXTURES},
      {"near_textures", KARST_UNIT_NEAR_TEXTURES},   {"variation", KARST_UNIT_VARIATION},
      {"sky_visibility", KARST_UNIT_SKY_VISIBILITY}, {"drape", KARST_UNIT_DRAPE},
      {"shadow_maps", KARST_UNIT_SHADOW_MAPS},       {"geometry", KARST_UNIT_GEOMETRY},
      {"blend_map", KARST_UNIT_BLEND_MAP},           {"image_tiles", KARST_UNIT_IMAGE_TILES},
      {"image_table", KARST_UNIT_IMAGE_TABLE}};
  const auto get_uniform = context_.function<PFNGLGETACTIVEUNIFORMPROC>("glGetActiveUniform");
  const auto get_value = context_.function<PFNGLGETUNIFORMIVPROC>("glGetUniformiv");
  std::set<std::string> seen;
  for (std::size_t p = 0; p < kShaderVariants; ++p) {
    const GLuint program = program_of(static_cast<ShaderVariant>(p));
    for (GLint i = 0; i < program_value(program, GL_ACTIVE_UNIFORMS); ++i) {
      char name[64];
      GLint count = 0;
      GLenum type = 0;
      get_uniform(program, static_cast<GLuint>(i), sizeof name, nullptr, &count, &type, name);
      if (type != GL_SAMPLER_2D && type != GL_UNSIGNED_INT_SAMPLER_2D && type != GL_SAMPLER_2D_ARRAY_SHADOW &&
          type != GL_SAMPLER_2D_ARRAY && type != GL_SAMPLER_3D)
        continue;
      ASSERT_TRUE(units.contains(name)) << name;
      GLint unit = -1;
      get_value(program, context_.gl().GetUniformLocation(program, name), &unit);
      EXPECT_EQ(unit, units.at(name)) << name;
      seen.insert(name);
    }
  }
  EXPECT_EQ(seen.size(), units.size());
}

// Canyon, 10 m a voxel, and bigtujunga, 256 m: the widest repeat is 640 m of 410 m, and 8 km of 36 km.
TEST(MaterialBlock, ScalesGoOnUntilARepeatIsAsWideAsTheWorld) {
  const auto widest_log2 = [](int repeat_log2, glm::ivec3 extent) {
    MaterialSet set;
    set.count = 1;
    set.side = 256;
    set.repeat_log2 = repeat_log2;
    const glm::ivec4 repeat = make_material_block(set, extent).material_repeat;
    EXPECT_EQ(repeat.x, repeat_log2);
    return repeat.x + KARST_SCALE_LOG2 * (repeat.y + 1);
  };
  EXPECT_EQ(widest_log2(-2, {41, 27, 30}), 6);
  EXPECT_EQ(widest_log2(-7, {141, 11, 76}), 5);
  EXPECT_EQ(widest_log2(-16, {512, 12, 512}), 8);
  EXPECT_EQ(widest_log2(5, {8, 8, 8}), 9);
}

}  // namespace
}  // namespace karst::core
