// SPDX-License-Identifier: MIT
#include "scene/resource_counts.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local std::uint64_t heap_calls = 0;

void* take(std::size_t size) {
  ++heap_calls;
  void* block = std::malloc(size == 0 ? 1 : size);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

void* take(std::size_t size, std::align_val_t alignment) {
  ++heap_calls;
  const auto align = static_cast<std::size_t>(alignment);
  void* block = std::aligned_alloc(align, (size + align - 1) / align * align);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

}  // namespace

// The array and nothrow forms of the standard library call these.
void* operator new(std::size_t size) {
  return take(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return take(size, alignment);
}
void operator delete(void* block) noexcept {
  std::free(block);
}
void operator delete(void* block, std::size_t) noexcept {
  std::free(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
  std::free(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
  std::free(block);
}

namespace karst::app {
using namespace core;
namespace {

Gl driver;
std::uint64_t objects = 0;

// GL's functions have no context pointer, so what they count is global.
template <auto Gl::*kFunction>
void GL_APIENTRY count_names(GLsizei count, GLuint* names) {
  objects += static_cast<std::uint64_t>(count);
  (driver.*kFunction)(count, names);
}

GLuint GL_APIENTRY count_program() {
  ++objects;
  return driver.CreateProgram();
}

GLuint GL_APIENTRY count_shader(GLenum type) {
  ++objects;
  return driver.CreateShader(type);
}

}  // namespace

HeapCount::HeapCount(std::uint64_t& total) : total_(total), before_(heap_calls) {}

HeapCount::~HeapCount() {
  total_ += heap_calls - before_;
}

void count_gl_objects(Gl& gl) {
  driver = gl;
  gl.GenBuffers = count_names<&Gl::GenBuffers>;
  gl.GenFramebuffers = count_names<&Gl::GenFramebuffers>;
  gl.GenTextures = count_names<&Gl::GenTextures>;
  gl.GenVertexArrays = count_names<&Gl::GenVertexArrays>;
  if (gl.GenQueriesEXT != nullptr) gl.GenQueriesEXT = count_names<&Gl::GenQueriesEXT>;
  gl.CreateProgram = count_program;
  gl.CreateShader = count_shader;
}

std::uint64_t gl_objects_made() {
  return objects;
}

}  // namespace karst::app
