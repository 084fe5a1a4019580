// SPDX-License-Identifier: MIT
#include "app/stage/resource_counts.h"

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

namespace {

thread_local std::uint64_t calls = 0;

void* take(std::size_t size) {
  ++calls;
  void* block = std::malloc(size == 0 ? 1 : size);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

void* take(std::size_t size, std::align_val_t alignment) {
  ++calls;
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
namespace {

using Function = void (*)();
using MakeNames = void (*)(std::int32_t count, std::uint32_t* names);
using MakeProgram = std::uint32_t (*)();
using MakeShader = std::uint32_t (*)(std::uint32_t kind);

GlLoader driver;
std::uint64_t objects = 0;

// GL's functions have no context pointer, so what they count is global.
constexpr const char* kMakers[] = {"glGenBuffers",  "glGenFramebuffers", "glGenRenderbuffers",
                                   "glGenTextures", "glGenVertexArrays", "glGenQueriesEXT"};
constexpr std::size_t kMakerCount = sizeof kMakers / sizeof *kMakers;
MakeNames makers[kMakerCount] = {};
MakeProgram make_program = nullptr;
MakeShader make_shader = nullptr;

template <std::size_t kMaker>
void count_names(std::int32_t count, std::uint32_t* names) {
  objects += static_cast<std::uint64_t>(count);
  makers[kMaker](count, names);
}

template <std::size_t... kMaker>
constexpr MakeNames counting_maker(std::size_t n, std::index_sequence<kMaker...>) {
  constexpr MakeNames kCounting[] = {count_names<kMaker>...};
  return kCounting[n];
}

std::uint32_t count_program() {
  ++objects;
  return make_program();
}

std::uint32_t count_shader(std::uint32_t kind) {
  ++objects;
  return make_shader(kind);
}

Function load_counting(void*, const char* name) {
  const Function found = driver.load(driver.user, name);
  if (found == nullptr) return nullptr;
  for (std::size_t n = 0; n < kMakerCount; ++n) {
    if (std::strcmp(name, kMakers[n]) != 0) continue;
    makers[n] = reinterpret_cast<MakeNames>(found);
    return reinterpret_cast<Function>(counting_maker(n, std::make_index_sequence<kMakerCount>()));
  }
  if (std::strcmp(name, "glCreateProgram") == 0) {
    make_program = reinterpret_cast<MakeProgram>(found);
    return reinterpret_cast<Function>(count_program);
  }
  if (std::strcmp(name, "glCreateShader") == 0) {
    make_shader = reinterpret_cast<MakeShader>(found);
    return reinterpret_cast<Function>(count_shader);
  }
  return found;
}

}  // namespace

std::uint64_t heap_calls() {
  return calls;
}

GlLoader counting_loader(const GlLoader& loader) {
  driver = loader;
  return {load_counting, nullptr};
}

std::uint64_t gl_objects_made() {
  return objects;
}

}  // namespace karst::app
