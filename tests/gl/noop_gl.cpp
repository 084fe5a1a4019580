// SPDX-License-Identifier: MIT
#include "tests/gl/noop_gl.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "app/common/picture_target.h"

namespace karst::test {
namespace {

// A function of any GL type that does nothing.
template <class Function>
struct Nothing;
template <class Result, class... Arguments>
struct Nothing<Result(GL_APIENTRYP)(Arguments...)> {
  static Result GL_APIENTRY call(Arguments...) { return Result(); }
};

// What buffers hold, by name, and which one is bound to a target.
std::map<GLuint, std::vector<std::byte>> buffers;
std::map<GLenum, GLuint> bound;

void GL_APIENTRY make(GLsizei n, GLuint* names) {
  for (GLsizei i = 0; i < n; ++i) names[i] = static_cast<GLuint>(++NoopGl::get().objects_made);
}
void GL_APIENTRY remove(GLsizei n, const GLuint* names) {
  for (GLsizei i = 0; i < n; ++i) NoopGl::get().objects_deleted += names[i] != 0 ? 1 : 0;
}
GLuint make_one() {
  return static_cast<GLuint>(++NoopGl::get().objects_made);
}
void GL_APIENTRY remove_one(GLuint name) {
  NoopGl::get().objects_deleted += name != 0 ? 1 : 0;
}

std::uint64_t texel_bytes(GLenum format) {
  switch (format) {
    case GL_RG32UI:
      return 8;
    case GL_RGBA32UI:
      return 16;
    case GL_R8:
    case GL_R8UI:
      return 1;
    case GL_R16F:
    case GL_DEPTH_COMPONENT16:
      return 2;
    default:
      return 4;  // RGBA8, DEPTH_COMPONENT24
  }
}

void GL_APIENTRY texture_storage(GLenum, GLsizei levels, GLenum format, GLsizei width, GLsizei height) {
  for (GLsizei level = 0; level < levels; ++level) {
    NoopGl::get().object_bytes += texel_bytes(format) *
                                  static_cast<std::uint64_t>(std::max(width >> level, 1)) *
                                  static_cast<std::uint64_t>(std::max(height >> level, 1));
  }
}

const GLubyte* text(const char* s) {
  return reinterpret_cast<const GLubyte*>(s);
}

void fill_objects(Gl& gl) {
  gl.GenBuffers = make;
  gl.GenFramebuffers = make;
  gl.GenTextures = make;
  gl.GenVertexArrays = make;
  gl.GenQueriesEXT = make;
  gl.DeleteBuffers = remove;
  gl.DeleteFramebuffers = remove;
  gl.DeleteTextures = remove;
  gl.DeleteVertexArrays = remove;
  gl.DeleteQueriesEXT = remove;
  gl.CreateProgram = [] { return make_one(); };
  gl.CreateShader = [](GLenum) { return make_one(); };
  gl.DeleteProgram = remove_one;
  gl.DeleteShader = remove_one;
  gl.TexStorage2D = texture_storage;
  gl.TexParameteri = [](GLenum, GLenum name, GLint value) {
    if (name != GL_TEXTURE_MAX_ANISOTROPY_EXT) return;
    NoopGl::get().anisotropy = std::max(NoopGl::get().anisotropy, value);
    ++NoopGl::get().anisotropic_textures;
  };
  gl.TexStorage3D = [](GLenum, GLsizei levels, GLenum format, GLsizei width, GLsizei height, GLsizei depth) {
    for (GLsizei layer = 0; layer < depth; ++layer)
      texture_storage(GL_TEXTURE_2D, levels, format, width, height);
  };
  gl.BufferData = [](GLenum target, GLsizeiptr bytes, const void*, GLenum) {
    NoopGl::get().object_bytes += static_cast<std::uint64_t>(bytes);
    if (NoopGl::get().out_of_memory) NoopGl::get().error = GL_OUT_OF_MEMORY;
    buffers[bound[target]].resize(static_cast<std::size_t>(bytes));
  };
  // There is one vertex array with an element buffer, so that this binding may stand for all of them.
  gl.BindBuffer = [](GLenum target, GLuint name) { bound[target] = name; };
  gl.BufferSubData = [](GLenum, GLintptr, GLsizeiptr bytes, const void*) {
    NoopGl::get().uploads_bytes += static_cast<std::uint64_t>(bytes);
  };
}

NoopGl& ask() {
  ++NoopGl::get().questions;
  return NoopGl::get();
}

void fill_queries(Gl& gl) {
  gl.GetString = [](GLenum name) {
    ask();
    return text(name == GL_VERSION ? NoopGl::get().version : name == GL_RENDERER ? "no-op" : "karst tests");
  };
  gl.GetStringi = [](GLenum, GLuint index) {
    ask();
    constexpr const char* kNames[] = {"GL_KHR_debug", "GL_EXT_disjoint_timer_query",
                                      "GL_EXT_texture_filter_anisotropic"};
    return text(index < 3 ? kNames[index] : "");
  };
  gl.GetIntegerv = [](GLenum name, GLint* value) {
    const NoopGl& self = ask();
    *value = 0;
    if (name == GL_MAX_TEXTURE_SIZE) *value = self.max_texture_size;
    if (name == GL_MAX_RENDERBUFFER_SIZE) *value = self.max_renderbuffer_size;
    if (name == GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS) *value = 32;
    if (name == GL_MAX_TEXTURE_MAX_ANISOTROPY_EXT) *value = self.max_anisotropy;
    if (name == GL_MAX_UNIFORM_BUFFER_BINDINGS) *value = 24;
    if (name == GL_NUM_EXTENSIONS) *value = self.extensions ? 3 : 0;
    if (name == GL_MAX_VIEWPORT_DIMS) value[0] = value[1] = self.max_renderbuffer_size;
  };
  gl.GetInteger64v = [](GLenum, GLint64* value) { *value = ask().max_element_index; };
  gl.GetShaderiv = [](GLuint, GLenum, GLint* value) { *value = ask().compiles ? GL_TRUE : GL_FALSE; };
  gl.GetProgramiv = [](GLuint, GLenum, GLint* value) { *value = ask().compiles ? GL_TRUE : GL_FALSE; };
  gl.GetShaderInfoLog = [](GLuint, GLsizei size, GLsizei*, GLchar* log) {
    std::snprintf(log, static_cast<std::size_t>(size), "0:1: no-op cannot compile");
  };
  gl.CheckFramebufferStatus = [](GLenum) -> GLenum {
    return ask().framebuffers_complete ? GL_FRAMEBUFFER_COMPLETE : GL_FRAMEBUFFER_UNSUPPORTED;
  };
  gl.GetError = [] {
    const GLenum error = ask().error;
    NoopGl::get().error = GL_NO_ERROR;
    return error;
  };
  gl.GetQueryObjectuivEXT = [](GLuint, GLenum, GLuint* value) {
    ask();
    *value = GL_TRUE;
  };
  gl.GetQueryObjectui64vEXT = [](GLuint, GLenum, GLuint64* value) {
    ask();
    *value = 1'500'000;
  };
  gl.GetUniformLocation = [](GLuint, const GLchar*) {
    ask();
    return -1;
  };
  gl.GetUniformBlockIndex = [](GLuint, const GLchar*) -> GLuint {
    ask();
    return GL_INVALID_INDEX;
  };
}

}  // namespace

NoopGl& NoopGl::get() {
  static NoopGl self;
  return self;
}

namespace {

Gl all_functions() {
  Gl gl;
#define KARST_GL_NOTHING(name) gl.name = Nothing<decltype(gl.name)>::call;
  KARST_GL_CORE_FUNCTIONS(KARST_GL_NOTHING)
#undef KARST_GL_NOTHING
#define KARST_GL_NOTHING(name, type, es_name, desktop_name) gl.name = Nothing<type>::call;
  KARST_GL_EXTENSION_FUNCTIONS(KARST_GL_NOTHING)
#undef KARST_GL_NOTHING
  fill_objects(gl);
  fill_queries(gl);
  gl.DrawArrays = [](GLenum, GLint, GLsizei) { ++NoopGl::get().draws; };
  gl.DrawElements = [](GLenum, GLsizei, GLenum, const void*) { ++NoopGl::get().draws; };
  gl.MapBufferRange = [](GLenum target, GLintptr, GLsizeiptr, GLbitfield) -> void* {
    ++NoopGl::get().mapped;
    return buffers[bound[target]].data();
  };
  gl.UnmapBuffer = [](GLenum target) -> GLboolean {
    --NoopGl::get().mapped;
    return target == GL_ARRAY_BUFFER && NoopGl::get().loses_vertices ? GL_FALSE : GL_TRUE;
  };
  gl.FlushMappedBufferRange = [](GLenum, GLintptr, GLsizeiptr bytes) {
    NoopGl::get().uploads_bytes += static_cast<std::uint64_t>(bytes);
  };
  gl.TexSubImage2D = [](GLenum, GLint, GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, const void*) {
    ++NoopGl::get().texture_uploads;
  };
  gl.FenceSync = [](GLenum, GLbitfield) {
    static int fence;
    ++NoopGl::get().fences;
    NoopGl::get().most_fences = std::max(NoopGl::get().most_fences, NoopGl::get().fences);
    return reinterpret_cast<GLsync>(&fence);
  };
  gl.DeleteSync = [](GLsync) { --NoopGl::get().fences; };
  gl.ClientWaitSync = [](GLsync, GLbitfield, GLuint64) -> GLenum {
    ++NoopGl::get().waits;
    return GL_ALREADY_SIGNALED;
  };
  return gl;
}

}  // namespace

Gl NoopGl::reset() {
  get() = NoopGl();
  buffers.clear();
  bound.clear();
  // Binding takes no memory later.
  constexpr GLenum kTargets[] = {GL_ARRAY_BUFFER,       GL_ELEMENT_ARRAY_BUFFER, GL_UNIFORM_BUFFER,
                                 GL_COPY_READ_BUFFER,   GL_COPY_WRITE_BUFFER,    GL_PIXEL_PACK_BUFFER,
                                 GL_PIXEL_UNPACK_BUFFER};
  for (const GLenum target : kTargets) bound[target] = 0;
  return all_functions();
}

namespace {

using Function = void (*)();

// Functions that a target needs beyond karst's own.
std::map<std::string, Function> target_functions() {
  std::map<std::string, Function> found;
#define KARST_GL_NOTHING(name) \
  found["gl" #name] = reinterpret_cast<Function>(Nothing<decltype(&::gl##name)>::call);
  KARST_TARGET_FUNCTIONS(KARST_GL_NOTHING)
#undef KARST_GL_NOTHING
  const auto storage = [](GLenum, GLenum format, GLsizei width, GLsizei height) {
    texture_storage(GL_RENDERBUFFER, 1, format == GL_RGB565 ? GL_R16F : format, width, height);
  };
  found["glGenRenderbuffers"] = reinterpret_cast<Function>(make);
  found["glDeleteRenderbuffers"] = reinterpret_cast<Function>(remove);
  found["glRenderbufferStorage"] =
      reinterpret_cast<Function>(static_cast<decltype(&::glRenderbufferStorage)>(storage));
  return found;
}

}  // namespace

GlLoader NoopGl::loader() {
  static std::map<std::string, Function> functions;
  functions = target_functions();
  const Gl gl = all_functions();
#define KARST_GL_KEEP(name) functions["gl" #name] = reinterpret_cast<Function>(gl.name);
  KARST_GL_CORE_FUNCTIONS(KARST_GL_KEEP)
#undef KARST_GL_KEEP
#define KARST_GL_KEEP(name, type, es_name, desktop_name) \
  functions[es_name] = reinterpret_cast<Function>(gl.name);
  KARST_GL_EXTENSION_FUNCTIONS(KARST_GL_KEEP)
#undef KARST_GL_KEEP
  return {.load = [](void*, const char* name) {
    const auto found = functions.find(name);
    return found == functions.end() ? nullptr : found->second;
  }};
}

}  // namespace karst::test
