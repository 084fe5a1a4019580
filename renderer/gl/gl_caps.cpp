// SPDX-License-Identifier: MIT
#include "renderer/gl/gl_caps.h"

#include <cstddef>
#include <cstdio>
#include <cstring>

namespace karst::core {
namespace {

template <std::size_t size>
void copy_string(const Gl& gl, GLenum name, char (&out)[size]) {
  const GLubyte* text = gl.GetString(name);
  std::snprintf(out, size, "%s", text == nullptr ? "" : reinterpret_cast<const char*>(text));
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// 10 times the version, 0 where the text does not begin with "3.2".
std::int32_t version_number(const char* text) {
  if (!is_digit(text[0]) || text[1] != '.' || !is_digit(text[2])) return 0;
  return (text[0] - '0') * 10 + (text[2] - '0');
}

// "OpenGL ES 3.2 Mesa 22.3.6": ES 3.0 prescribes the prefix. "4.5 (Core Profile) Mesa 22.3.6" is OpenGL. It
// is asked before anything that only these know.
std::int32_t version_of(const char* version, bool desktop) {
  constexpr const char* kPrefix = "OpenGL ES ";
  const std::size_t length = std::strlen(kPrefix);
  const bool es = std::strncmp(version, kPrefix, length) == 0;
  if (es == desktop) return 0;
  return version_number(desktop ? version : version + length);
}

// What is not kept by itself.
struct Found {
  bool es3 = false;  // ARB_ES3_compatibility
  bool anisotropy = false;
};

// All that extensions add.
void read_extension(const char* name, GlCaps& caps, Found& found) {
  const struct {
    const char* name;
    bool* flag;
  } kKnown[] = {{"GL_KHR_debug", &caps.debug},
                {"GL_EXT_disjoint_timer_query", &caps.timer_query},
                {"GL_ARB_timer_query", &caps.timer_query},
                {"GL_EXT_clip_control", &caps.clip_control},
                {"GL_ARB_clip_control", &caps.clip_control},
                {"GL_EXT_depth_clamp", &caps.depth_clamp},
                {"GL_EXT_sRGB_write_control", &caps.srgb_switch},
                {"GL_NV_polygon_mode", &caps.polygon_mode},
                {"GL_EXT_multisample_compatibility", &caps.multisample_switch},
                {"GL_EXT_texture_filter_anisotropic", &found.anisotropy},
                {"GL_ARB_texture_filter_anisotropic", &found.anisotropy},
                {"GL_ARB_ES3_compatibility", &found.es3}};
  for (const auto& known : kKnown) {
    if (std::strcmp(name, known.name) == 0) *known.flag = true;
  }
}

bool has_clip_distances(const char* name) {
  return std::strcmp(name, "GL_EXT_clip_cull_distance") == 0 ||
         std::strcmp(name, "GL_APPLE_clip_distance") == 0;
}

// An extension that is advertised and has no functions is none.
void require_functions(const Gl& gl, GlCaps& caps) {
  caps.debug = caps.debug && gl.DebugMessageCallbackKHR != nullptr && gl.DebugMessageControlKHR != nullptr &&
               gl.ObjectLabelKHR != nullptr && gl.PushDebugGroupKHR != nullptr &&
               gl.PopDebugGroupKHR != nullptr;
  caps.timer_query = caps.timer_query && gl.GenQueriesEXT != nullptr && gl.DeleteQueriesEXT != nullptr &&
                     gl.BeginQueryEXT != nullptr && gl.EndQueryEXT != nullptr &&
                     gl.GetQueryObjectuivEXT != nullptr && gl.GetQueryObjectui64vEXT != nullptr;
  caps.clip_control = caps.clip_control && gl.ClipControlEXT != nullptr;
  caps.polygon_mode = caps.polygon_mode && gl.PolygonModeNV != nullptr;
}

}  // namespace

Status query_gl_caps(const Gl& gl, bool desktop, GlCaps& caps) {
  copy_string(gl, GL_VENDOR, caps.vendor);
  copy_string(gl, GL_RENDERER, caps.renderer);
  copy_string(gl, GL_VERSION, caps.version);
  caps.desktop = desktop;
  caps.number = version_of(caps.version, desktop);
  if (caps.number < (desktop ? 43 : 30)) {
    return {StatusCode::unsupported,
            desktop ? "the context is not OpenGL 4.3 or later" : "the context is not OpenGL ES 3",
            "GL_VERSION"};
  }

  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &caps.max_texture_size);
  gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, caps.max_viewport);
  gl.GetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &caps.max_texture_units);
  gl.GetIntegerv(GL_MAX_UNIFORM_BUFFER_BINDINGS, &caps.max_uniform_bindings);
  GLint64 index = 0;
  gl.GetInteger64v(GL_MAX_ELEMENT_INDEX, &index);
  caps.max_element_index = index;

  Found found;
  bool clip_distances = desktop;
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const GLubyte* text = gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
    if (text == nullptr) continue;
    const char* name = reinterpret_cast<const char*>(text);
    read_extension(name, caps, found);
    clip_distances = clip_distances || has_clip_distances(name);
  }
  if (desktop) {
    if (!found.es3)
      return {StatusCode::unsupported, "the driver lacks an extension", "GL_ARB_ES3_compatibility"};
    caps.depth_clamp = caps.srgb_switch = caps.polygon_mode = caps.multisample_switch = true;
    if (gl.ProvokingVertex == nullptr) {
      return {StatusCode::unsupported, "the driver lacks a function of OpenGL", "glProvokingVertex"};
    }
  }
  caps.sample_mask = desktop || caps.number >= 31;
  caps.sample_shading = desktop || caps.number >= 32;
  if (clip_distances) gl.GetIntegerv(GL_MAX_CLIP_DISTANCES_EXT, &caps.max_clip_distances);
  if (found.anisotropy) gl.GetIntegerv(GL_MAX_TEXTURE_MAX_ANISOTROPY_EXT, &caps.max_anisotropy);
  require_functions(gl, caps);
  constexpr const char* kSoftware[] = {"llvmpipe", "softpipe", "SwiftShader"};
  for (const char* name : kSoftware) {
    caps.software = caps.software || std::strstr(caps.renderer, name) != nullptr;
  }
  caps.first_timer_result_is_wrong = caps.culls_unrounded = std::strncmp(caps.renderer, "llvmpipe", 8) == 0;
  return {};
}

}  // namespace karst::core
