// SPDX-License-Identifier: MIT
#include "renderer/passes/programs.h"

#include <cstdio>
#include <cstring>

#include "renderer/input/shader_interface.h"
#include "renderer/passes/terrain_variants.h"

namespace karst::core {
namespace {

struct Sampler {
  const char* name;
  GLint unit;
};
// Names are the same in all shaders; a program that has no such sampler is left alone.
constexpr Sampler kSamplers[] = {
    {"page_table", KARST_UNIT_PAGE_TABLE},         {"morph_entries", KARST_UNIT_MORPH_ENTRIES},
    {"morph_rows", KARST_UNIT_MORPH_ROWS},         {"far_textures", KARST_UNIT_FAR_TEXTURES},
    {"near_textures", KARST_UNIT_NEAR_TEXTURES},   {"variation", KARST_UNIT_VARIATION},
    {"sky_visibility", KARST_UNIT_SKY_VISIBILITY}, {"drape", KARST_UNIT_DRAPE},
    {"shadow_maps", KARST_UNIT_SHADOW_MAPS},       {"geometry", KARST_UNIT_GEOMETRY},
    {"blend_map", KARST_UNIT_BLEND_MAP},           {"image_tiles", KARST_UNIT_IMAGE_TILES},
    {"image_table", KARST_UNIT_IMAGE_TABLE},       {"geometry_voxels", KARST_UNIT_GEOMETRY_VOXELS}};

constexpr Status kShaderFailed{StatusCode::unsupported, "the driver rejects a shader", "shader"};

// Begins the log with "terrain (vertex): " and returns the room behind it.
std::span<char> begin_log(std::span<char> log, const char* name, const char* stage) {
  const int used = std::snprintf(log.data(), log.size(), "%s (%s): ", name, stage);
  const std::size_t length = used < 0 ? 0 : static_cast<std::size_t>(used);
  return length < log.size() ? log.subspan(length) : std::span<char>();
}

// macros: the variant's; defines: the renderer's.
void compile(const Gl& gl, GLuint shader, const char* text, const char* macros, const char* defines) {
  // Nothing but comments may come before the version, which is the text's first line.
  const char* rest = std::strchr(text, '\n');
  rest = rest == nullptr ? text : rest + 1;
  const char* parts[] = {text, macros, defines, rest};
  const GLint lengths[] = {static_cast<GLint>(rest - text), -1, -1, -1};
  gl.ShaderSource(shader, 4, parts, lengths);
  gl.CompileShader(shader);
}

// Attaches a new shader, which the program keeps alive; its result is read after all are under way, because
// drivers may compile in the background.
void attach_shader(const Gl& gl, GLuint program, bool vertex, const ShaderText& text, const char* defines) {
  const GLuint shader = gl.CreateShader(vertex ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
  compile(gl, shader, vertex ? text.vertex : text.fragment, text.defines, defines);
  gl.AttachShader(program, shader);
  gl.DeleteShader(shader);
}

// Writes the first shader's log that has an error; a link error otherwise.
void describe_failure(const Gl& gl, GLuint program, const ShaderText& text, const char* defines,
                      std::span<char> log) {
  for (const bool vertex : {true, false}) {
    const GLuint shader = gl.CreateShader(vertex ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
    compile(gl, shader, vertex ? text.vertex : text.fragment, text.defines, defines);
    GLint ok = GL_FALSE;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok == GL_FALSE) {
      const std::span<char> room = begin_log(log, text.name, vertex ? "vertex shader" : "fragment shader");
      if (!room.empty()) gl.GetShaderInfoLog(shader, static_cast<GLsizei>(room.size()), nullptr, room.data());
    }
    gl.DeleteShader(shader);
    if (ok == GL_FALSE) return;
  }
  const std::span<char> room = begin_log(log, text.name, "linking");
  if (!room.empty()) gl.GetProgramInfoLog(program, static_cast<GLsizei>(room.size()), nullptr, room.data());
}

void connect(const Gl& gl, GLuint program, const ProgramSettings& settings) {
  const GLuint block = gl.GetUniformBlockIndex(program, "FrameBlock");
  if (block != GL_INVALID_INDEX) {
    gl.UniformBlockBinding(program, block, settings.first_block + KARST_BINDING_FRAME);
  }
  const GLuint materials = gl.GetUniformBlockIndex(program, "MaterialBlock");
  if (materials != GL_INVALID_INDEX) {
    gl.UniformBlockBinding(program, materials, settings.first_block + KARST_BINDING_MATERIALS);
  }
  gl.UseProgram(program);
  for (const Sampler& sampler : kSamplers) {
    const GLint location = gl.GetUniformLocation(program, sampler.name);
    if (location >= 0) gl.Uniform1i(location, sampler.unit + static_cast<GLint>(settings.first_unit));
  }
}

bool is_needed(ShaderVariant variant, const ProgramSettings& settings) {
  for (const ShaderVariant first : {ShaderVariant::terrain, ShaderVariant::screen}) {
    const int n = static_cast<int>(variant) - static_cast<int>(first);
    if (n < 0 || n >= kShadingVariants) continue;
    if (settings.drape || (!settings.shadows && (shading_of(n) & kShadeShadows) != 0)) return false;
    // Beside a G-buffer, what does not go by it takes the program that does everything.
    if (first == ShaderVariant::terrain && settings.deferred)
      return (shading_of(n) | kShadeShadows) == kShadeAll;
    return first == ShaderVariant::terrain || settings.deferred;
  }
  if (variant == ShaderVariant::geometry || variant == ShaderVariant::edge_geometry)
    return settings.deferred && !settings.drape;
  if (variant == ShaderVariant::edge || variant == ShaderVariant::edge_shadowed)
    return !settings.drape && (settings.shadows || variant == ShaderVariant::edge);
  return settings.drape || (variant != ShaderVariant::drape && variant != ShaderVariant::drape_linear);
}

}  // namespace

Status Programs::create(const Gl& gl, const ProgramSettings& settings, std::span<char> log) {
  std::snprintf(
      defines_, sizeof defines_,
      "#define KARST_MATERIALS %d\n#define KARST_DETAIL %d\n#define KARST_ANISOTROPY %d\n%s%s%s%s%s%s%s%s%s",
      settings.materials, settings.detail, settings.anisotropy,
      settings.high_precision ? "#define KARST_HIGH_PRECISION 1\n" : "",
      settings.edges ? "#define KARST_EDGES 1\n" : "",
      settings.share_depth ? "#define KARST_SHARE_DEPTH 1\n" : "",
      settings.water ? "#define KARST_WATER 1\n" : "", settings.curved ? "#define KARST_CURVED 1\n" : "",
      settings.blend_map ? "#define KARST_BLEND_MAP 1\n" : "",
      settings.imagery ? "#define KARST_IMAGERY 1\n" : "",
      settings.voxel_materials ? "#define KARST_VOXEL_MATERIALS 1\n" : "",
      settings.cull_pixels ? "#define KARST_CULL_PIXELS 1\n" : "");
  for (std::size_t i = 0; i < kShaderVariants; ++i) {
    if (!is_needed(static_cast<ShaderVariant>(i), settings)) continue;
    programs_[i] = gl.CreateProgram();
    attach_shader(gl, programs_[i], true, kShaderTexts[i], defines_);
    attach_shader(gl, programs_[i], false, kShaderTexts[i], defines_);
    gl.LinkProgram(programs_[i]);
  }
  const Status status = link_all(gl, settings, log);
  if (!status.ok()) destroy(gl);
  return status;
}

Status Programs::link_all(const Gl& gl, const ProgramSettings& settings, std::span<char> log) {
  for (std::size_t i = 0; i < kShaderVariants; ++i) {
    if (programs_[i] == 0) continue;
    GLint ok = GL_FALSE;
    gl.GetProgramiv(programs_[i], GL_LINK_STATUS, &ok);
    if (ok == GL_FALSE) {
      describe_failure(gl, programs_[i], kShaderTexts[i], defines_, log);
      return kShaderFailed;
    }
    connect(gl, programs_[i], settings);
    if (settings.label) gl.ObjectLabelKHR(GL_PROGRAM_KHR, programs_[i], -1, kShaderTexts[i].name);
  }
  shown_level_ = gl.GetUniformLocation((*this)[ShaderVariant::show_levels], "shown_level");
  gl.UseProgram(0);
  return {};
}

void Programs::destroy(const Gl& gl) {
  for (const GLuint program : programs_) {
    if (program != 0) gl.DeleteProgram(program);
  }
  forget();
}

void Programs::forget() {
  for (GLuint& program : programs_) program = 0;
  shown_level_ = -1;
}

}  // namespace karst::core
