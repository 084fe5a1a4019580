// SPDX-License-Identifier: MIT
#include <EGL/egl.h>
#include <GLES3/gl3.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "platform/headless/headless_display.h"
#include "renderer/gl/gl_caps.h"
#include "tests/device/machine/probe.h"

namespace karst::device {
namespace {

using core::Gl;
using core::GlCaps;

// What karst uses where it is there, and what it could.
constexpr const char* kExtensions[] = {
    "GL_KHR_debug",
    "GL_EXT_disjoint_timer_query",
    "GL_EXT_clip_control",
    "GL_EXT_clip_cull_distance",
    "GL_EXT_depth_clamp",
    "GL_EXT_sRGB_write_control",
    "GL_EXT_color_buffer_float",
    "GL_EXT_color_buffer_half_float",
    "GL_EXT_texture_filter_anisotropic",
    "GL_EXT_texture_norm16",
    "GL_KHR_texture_compression_astc_ldr",
    "GL_EXT_multisampled_render_to_texture",
    "GL_EXT_shader_framebuffer_fetch",
    "GL_ARM_shader_framebuffer_fetch",
    "GL_ARM_shader_framebuffer_fetch_depth_stencil",
    "GL_EXT_shader_pixel_local_storage",
    "GL_QCOM_shading_rate",
    "GL_EXT_multi_draw_arrays",
    "GL_EXT_multi_draw_indirect",
    "GL_EXT_draw_elements_base_vertex",
    "GL_EXT_buffer_storage",
    "GL_OES_get_program_binary",
    "GL_KHR_parallel_shader_compile",
};

struct Limit {
  const char* key;
  GLenum name;
};
constexpr Limit kLimits[] = {{"max_3d_texture_size", GL_MAX_3D_TEXTURE_SIZE},
                             {"max_array_texture_layers", GL_MAX_ARRAY_TEXTURE_LAYERS},
                             {"max_texture_image_units", GL_MAX_TEXTURE_IMAGE_UNITS},
                             {"max_vertex_texture_image_units", GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS},
                             {"max_uniform_block_size", GL_MAX_UNIFORM_BLOCK_SIZE},
                             {"max_color_attachments", GL_MAX_COLOR_ATTACHMENTS},
                             {"max_samples", GL_MAX_SAMPLES},
                             {"subpixel_bits", GL_SUBPIXEL_BITS}};

std::string text_of(const char* text) {
  return text == nullptr ? "" : text;
}
std::string text_of(const GLubyte* text) {
  return text_of(reinterpret_cast<const char*>(text));
}

Json egl_strings(const Display& display) {
  const EGLDisplay egl = eglGetCurrentDisplay();
  return {{"display", display.name()},
          {"vendor", text_of(eglQueryString(egl, EGL_VENDOR))},
          {"version", text_of(eglQueryString(egl, EGL_VERSION))},
          {"client_extensions", text_of(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS))},
          {"extensions", text_of(eglQueryString(egl, EGL_EXTENSIONS))}};
}

Json limits_of(const Gl& gl, const GlCaps& caps) {
  Json limits = {{"max_texture_size", caps.max_texture_size},
                 {"max_viewport", {caps.max_viewport[0], caps.max_viewport[1]}},
                 {"max_element_index", caps.max_element_index},
                 {"max_combined_texture_units", caps.max_texture_units},
                 {"max_uniform_buffer_bindings", caps.max_uniform_bindings}};
  for (const Limit& limit : kLimits) {
    GLint value = 0;
    gl.GetIntegerv(limit.name, &value);
    limits[limit.key] = value;
  }
  return limits;
}

// Bits of a number's mantissa, by shader and precision: 23 is a whole float.
Json precisions_of(const Display& display) {
  const auto get = reinterpret_cast<void (*)(GLenum, GLenum, GLint*, GLint*)>(
      display.gl_function("glGetShaderPrecisionFormat"));
  Json bits;
  if (get == nullptr) return bits;
  GLint range[2] = {0, 0};
  const auto ask = [&](GLenum shader, GLenum precision) {
    GLint mantissa = 0;
    get(shader, precision, range, &mantissa);
    return mantissa;
  };
  bits["vertex_highp"] = ask(GL_VERTEX_SHADER, GL_HIGH_FLOAT);
  bits["fragment_highp"] = ask(GL_FRAGMENT_SHADER, GL_HIGH_FLOAT);
  bits["fragment_mediump"] = ask(GL_FRAGMENT_SHADER, GL_MEDIUM_FLOAT);
  return bits;
}

std::vector<std::string> extensions_of(const Gl& gl) {
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  std::vector<std::string> names;
  for (GLint i = 0; i < count; ++i) {
    names.push_back(text_of(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))));
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

Error probe_device(Json& device) {
  Error error;
  const std::unique_ptr<Display> display = open_headless_display({}, error);
  if (display == nullptr) return error;
  const GlLoader loader = {
      .load = [](void* user, const char* name) { return static_cast<Display*>(user)->gl_function(name); },
      .user = display.get()};
  Gl gl;
  GlCaps caps;
  if (const Status status = load_gl(loader, false, gl); !status.ok()) return {"OpenGL ES", status};
  if (const Status status = query_gl_caps(gl, false, caps); !status.ok()) return {"OpenGL ES", status};
  device["egl"] = egl_strings(*display);
  device["gl"] = {{"vendor", text_of(gl.GetString(GL_VENDOR))},
                  {"renderer", text_of(gl.GetString(GL_RENDERER))},
                  {"version", text_of(gl.GetString(GL_VERSION))},
                  {"shading_language", text_of(gl.GetString(GL_SHADING_LANGUAGE_VERSION))}};
  device["limits"] = limits_of(gl, caps);
  device["mantissa_bits"] = precisions_of(*display);
  const std::vector<std::string> names = extensions_of(gl);
  Json known;
  for (const char* name : kExtensions) known[name] = std::binary_search(names.begin(), names.end(), name);
  device["extensions"] = known;
  device["all_extensions"] = names;
  return {};
}

}  // namespace karst::device
