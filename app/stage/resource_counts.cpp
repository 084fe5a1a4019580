// SPDX-License-Identifier: MIT
#include "app/stage/resource_counts.h"

#include <dirent.h>

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

using DeleteNames = void (*)(std::int32_t count, const std::uint32_t* names);
using DeleteOne = void (*)(std::uint32_t name);

GlLoader driver;
std::uint64_t objects = 0;
std::uint64_t alive = 0;

// GL's functions have no context pointer, so what they count is global.
constexpr const char* kMakers[] = {"glGenBuffers",  "glGenFramebuffers", "glGenRenderbuffers",
                                   "glGenTextures", "glGenVertexArrays", "glGenQueriesEXT"};
constexpr std::size_t kMakerCount = sizeof kMakers / sizeof *kMakers;
MakeNames makers[kMakerCount] = {};
constexpr const char* kDeleters[] = {"glDeleteBuffers",  "glDeleteFramebuffers", "glDeleteRenderbuffers",
                                     "glDeleteTextures", "glDeleteVertexArrays", "glDeleteQueriesEXT"};
DeleteNames deleters[kMakerCount] = {};
MakeProgram make_program = nullptr;
MakeShader make_shader = nullptr;
DeleteOne delete_program = nullptr;
DeleteOne delete_shader = nullptr;

template <std::size_t kMaker>
void count_names(std::int32_t count, std::uint32_t* names) {
  objects += static_cast<std::uint64_t>(count);
  alive += static_cast<std::uint64_t>(count);
  makers[kMaker](count, names);
}

template <std::size_t... kMaker>
constexpr MakeNames counting_maker(std::size_t n, std::index_sequence<kMaker...>) {
  constexpr MakeNames kCounting[] = {count_names<kMaker>...};
  return kCounting[n];
}

// GL ignores the name 0.
template <std::size_t kDeleter>
void count_deleted(std::int32_t count, const std::uint32_t* names) {
  for (std::int32_t n = 0; n < count; ++n) alive -= names[n] != 0 ? 1 : 0;
  deleters[kDeleter](count, names);
}

template <std::size_t... kDeleter>
constexpr DeleteNames counting_deleter(std::size_t n, std::index_sequence<kDeleter...>) {
  constexpr DeleteNames kCounting[] = {count_deleted<kDeleter>...};
  return kCounting[n];
}

void count_deleted_program(std::uint32_t name) {
  alive -= name != 0 ? 1 : 0;
  delete_program(name);
}

void count_deleted_shader(std::uint32_t name) {
  alive -= name != 0 ? 1 : 0;
  delete_shader(name);
}

std::uint32_t count_program() {
  ++objects;
  ++alive;
  return make_program();
}

std::uint32_t count_shader(std::uint32_t kind) {
  ++objects;
  ++alive;
  return make_shader(kind);
}

// Keeps the driver's function, and returns the one that counts and calls it.
template <class T>
Function count_with(Function found, T& kept, T counting) {
  kept = reinterpret_cast<T>(found);
  return reinterpret_cast<Function>(counting);
}

Function load_counting(void*, const char* name) {
  const Function found = driver.load(driver.user, name);
  if (found == nullptr) return nullptr;
  const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
  constexpr auto kEach = std::make_index_sequence<kMakerCount>();
  for (std::size_t n = 0; n < kMakerCount; ++n) {
    if (is(kMakers[n])) return count_with(found, makers[n], counting_maker(n, kEach));
    if (is(kDeleters[n])) return count_with(found, deleters[n], counting_deleter(n, kEach));
  }
  if (is("glCreateProgram")) return count_with(found, make_program, &count_program);
  if (is("glCreateShader")) return count_with(found, make_shader, &count_shader);
  if (is("glDeleteProgram")) return count_with(found, delete_program, &count_deleted_program);
  if (is("glDeleteShader")) return count_with(found, delete_shader, &count_deleted_shader);
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

std::uint64_t gl_objects_alive() {
  return alive;
}

void gl_objects_lost() {
  alive = 0;
}

std::uint64_t open_descriptors() {
  DIR* const folder = opendir("/proc/self/fd");
  if (folder == nullptr) return 0;
  std::uint64_t count = 0;
  while (const dirent* entry = readdir(folder)) count += entry->d_name[0] != '.' ? 1 : 0;
  closedir(folder);
  return count - 1;  // the folder itself
}

}  // namespace karst::app
