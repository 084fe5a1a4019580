// SPDX-License-Identifier: MIT
#include "bake/imagery/image_file.h"

#include "bake/base/byte_message.h"

namespace karst::bake {
namespace {

constexpr std::uint64_t kMemoryBytes = 320u << 20;  // GDAL's cache and what it warps at a time included
constexpr std::uint64_t kWords = 1 << 20;           // bytes of names and messages that come back
constexpr std::uint64_t kTexelsASecond = 1 << 18;   // of the slowest compression and projection

void put_grid(const GroundGrid& ground, const std::string& path, WriteMessage& message) {
  message.put_text(path);
  message.put(ground.samples);
  message.put(ground.placed);
  for (const double value : {ground.west, ground.north, ground.step_x, ground.step_z}) message.put(value);
  message.put_text(ground.crs);
  message.put(ground.face_quads);
  message.put(ground.radius_m);
  message.put(ground.flattening);
}

void take_grid(ReadMessage& message, GroundGrid& ground, std::string& path) {
  message.take_text(path);
  message.take(ground.samples);
  message.take(ground.placed);
  for (double* value : {&ground.west, &ground.north, &ground.step_x, &ground.step_z}) message.take(*value);
  message.take_text(ground.crs);
  message.take(ground.face_quads);
  message.take(ground.radius_m);
  message.take(ground.flattening);
}

// In a child.
Error describe(std::span<const std::byte> request, std::vector<std::byte>& result) {
  GroundGrid ground;
  std::string path;
  ReadMessage message(request);
  take_grid(message, ground, path);
  ImageFacts facts;
  if (Error error = describe_image_here(ground, path, facts); !error.ok()) return error;
  WriteMessage out(result);
  out.put(facts.width);
  out.put(facts.height);
  out.put(facts.low);
  out.put(facts.high);
  out.put(facts.face_low);
  out.put(facts.face_high);
  out.put(facts.pixel_samples);
  out.put(facts.is_opaque);
  out.put(facts.covers_all);
  out.put_text(facts.kind);
  out.put(facts.block_bytes);
  out.put_texts(facts.warnings);
  return {};
}

Error read_window(std::span<const std::byte> request, std::vector<std::byte>& result) {
  GroundGrid ground;
  std::string path;
  ReadMessage message(request);
  take_grid(message, ground, path);
  TexelWindow window;
  message.take(window);
  return read_image_window_here(ground, path, window, result);
}

}  // namespace

const ChildTask kDescribeImage{"describe image", describe, ChildTask::Library::gdal};
const ChildTask kReadImage{"read image", read_window, ChildTask::Library::gdal};

Error describe_image(const GroundGrid& ground, const std::string& path, ImageFacts& facts) {
  ChildLimits limits;
  limits.memory_bytes = kMemoryBytes;
  limits.result_bytes = kWords;
  std::vector<std::byte> request, result;
  WriteMessage words(request);
  put_grid(ground, path, words);
  if (Error error = run_in_child(path, limits, kDescribeImage, request, result); !error.ok()) return error;
  ReadMessage message(result);
  facts = {};
  message.take(facts.width);
  message.take(facts.height);
  message.take(facts.low);
  message.take(facts.high);
  message.take(facts.face_low);
  message.take(facts.face_high);
  message.take(facts.pixel_samples);
  message.take(facts.is_opaque);
  message.take(facts.covers_all);
  message.take_text(facts.kind);
  message.take(facts.block_bytes);
  message.take_texts(facts.warnings);
  return message.whole() ? Error() : Error(path + ": its reader stopped early");
}

Error read_image_window(const GroundGrid& ground, const std::string& path, const ImageFacts& facts,
                        const TexelWindow& window, std::vector<std::byte>& rgba) {
  const auto texels = static_cast<std::uint64_t>(window.width) * static_cast<std::uint64_t>(window.height);
  ChildLimits limits;
  limits.result_bytes = static_cast<std::size_t>(4 * texels);
  limits.memory_bytes = kMemoryBytes + 2 * limits.result_bytes + 2 * facts.block_bytes;
  limits.cpu_seconds += static_cast<unsigned>(texels / kTexelsASecond);
  std::vector<std::byte> request;
  WriteMessage words(request);
  put_grid(ground, path, words);
  words.put(window);
  if (Error error = run_in_child(path, limits, kReadImage, request, rgba); !error.ok()) return error;
  return rgba.size() == limits.result_bytes ? Error() : Error(path + ": its reader stopped early");
}

}  // namespace karst::bake
