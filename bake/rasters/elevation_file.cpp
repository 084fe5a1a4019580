// SPDX-License-Identifier: MIT
#include "bake/rasters/elevation_file.h"

#include "bake/base/byte_message.h"

#include <fstream>
#include <string_view>

namespace karst::bake {
namespace {

constexpr std::uint64_t kMemoryBytes = 256u << 20;
constexpr std::uint64_t kWords = 1 << 20;            // bytes of names and messages that come back
constexpr std::uint64_t kSamplesASecond = 4u << 20;  // of the slowest compression, ten times over

bool is_exr(const std::string& path) {
  char first[4] = {};
  std::ifstream(path, std::ios::binary).read(first, sizeof first);
  return std::string_view(first, sizeof first) == "v/1\x01";
}

void put_settings(const ReadElevation& settings, const std::string& path, WriteMessage& message) {
  message.put_text(path);
  message.put(settings.pixel_size_m);
  message.put(settings.z_scale.has_value());
  message.put(settings.z_scale.value_or(1));
  message.put(settings.allow_8bit);
  message.put(settings.band);
  message.put_all(settings.nodata);
  message.put_text(settings.crs);
  message.put(settings.bounds.has_value());
  message.put(settings.bounds.value_or(std::array<double, 4>{}));
}

void take_settings(ReadMessage& message, ReadElevation& settings) {
  bool scaled = false;
  double scale = 1;
  message.take_text(settings.path);
  message.take(settings.pixel_size_m);
  message.take(scaled);
  message.take(scale);
  if (scaled) settings.z_scale = scale;
  message.take(settings.allow_8bit);
  message.take(settings.band);
  message.take_all(settings.nodata);
  message.take_text(settings.crs);
  bool bounded = false;
  std::array<double, 4> bounds{};
  message.take(bounded);
  message.take(bounds);
  if (bounded) settings.bounds = bounds;
}

// In a child.
Error describe(std::span<const std::byte> request, std::vector<std::byte>& result) {
  ReadElevation settings;
  ReadMessage message(request);
  take_settings(message, settings);
  ElevationGrid grid;
  if (Error error = describe_elevation_here(settings, settings.path, grid); !error.ok()) return error;
  WriteMessage out(result);
  out.put(grid.width);
  out.put(grid.height);
  out.put(grid.placed);
  for (const double value : {grid.west, grid.north, grid.step_x, grid.step_z}) out.put(value);
  out.put_text(grid.crs);
  out.put(grid.earth);
  out.put(grid.block_row_bytes);
  out.put_texts(grid.files);
  return {};
}

Error read_part(std::span<const std::byte> request, std::vector<std::byte>& result) {
  ReadElevation settings;
  Window whole, part;
  ReadMessage message(request);
  take_settings(message, settings);
  message.take(whole);
  message.take(part);
  ElevationPart read;
  if (Error error = read_elevation_part_here(settings, settings.path, whole, part, read); !error.ok())
    return error;
  result = std::move(read.heights);  // first, so that they are not copied
  WriteMessage out(result);
  out.put(read.spacing_x_m);
  out.put(read.spacing_z_m);
  out.put(read.unit_m);
  out.put_text(read.source);
  out.put_texts(read.warnings);
  return {};
}

}  // namespace

const ChildTask kDescribeRaster{"describe raster", describe, ChildTask::Library::gdal};
const ChildTask kReadRaster{"read raster", read_part, ChildTask::Library::gdal};
const ChildTask kDescribeExr{"describe exr", describe};
const ChildTask kReadExr{"read exr", read_part};

Error describe_elevation_here(const ReadElevation& settings, const std::string& path, ElevationGrid& grid) {
  return is_exr(path) ? describe_exr(settings, path, grid) : describe_raster(settings, path, grid);
}

Error read_elevation_part_here(const ReadElevation& settings, const std::string& path, const Window& whole,
                               const Window& part, ElevationPart& result) {
  const std::size_t samples = static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
  result.heights.reserve(samples * sizeof(float) + kWords);
  return is_exr(path) ? read_exr(settings, path, part, result)
                      : read_raster(settings, path, whole, part, result);
}

Error describe_elevation(const ReadElevation& settings, const std::string& path, ElevationGrid& grid) {
  ChildLimits limits;
  limits.memory_bytes = kMemoryBytes;
  limits.result_bytes = kWords;
  std::vector<std::byte> request, result;
  WriteMessage words(request);
  put_settings(settings, path, words);
  const ChildTask& task = is_exr(path) ? kDescribeExr : kDescribeRaster;
  if (Error error = run_in_child(path, limits, task, request, result); !error.ok()) return error;
  ReadMessage message(result);
  grid = {};
  message.take(grid.width);
  message.take(grid.height);
  message.take(grid.placed);
  for (double* value : {&grid.west, &grid.north, &grid.step_x, &grid.step_z}) message.take(*value);
  message.take_text(grid.crs);
  message.take(grid.earth);
  message.take(grid.block_row_bytes);
  message.take_texts(grid.files);
  return message.whole() ? Error() : Error(path + ": its reader stopped early");
}

Error read_elevation_part(const ReadElevation& settings, const std::string& path, const ElevationGrid& grid,
                          const Window& whole, const Window& part, ElevationPart& result) {
  const std::uint64_t samples =
      static_cast<std::uint64_t>(part.width) * static_cast<std::uint64_t>(part.height);
  ChildLimits limits;
  limits.result_bytes = static_cast<std::size_t>(samples * sizeof(float) + kWords);
  limits.memory_bytes = kMemoryBytes + limits.result_bytes + 2 * grid.block_row_bytes;
  limits.cpu_seconds += static_cast<unsigned>(samples / kSamplesASecond);
  std::vector<std::byte> request;
  WriteMessage words(request);
  put_settings(settings, path, words);
  words.put(whole);
  words.put(part);
  std::vector<std::byte>& bytes = result.heights;
  const ChildTask& task = is_exr(path) ? kReadExr : kReadRaster;
  if (Error error = run_in_child(path, limits, task, request, bytes); !error.ok()) return error;
  const auto heights = static_cast<std::size_t>(samples * sizeof(float));
  ReadMessage message(std::span<const std::byte>(bytes).subspan(std::min(heights, bytes.size())));
  message.take(result.spacing_x_m);
  message.take(result.spacing_z_m);
  message.take(result.unit_m);
  message.take_text(result.source);
  message.take_texts(result.warnings);
  if (bytes.size() < heights || !message.whole()) return path + ": its reader stopped early";
  bytes.resize(heights);
  return {};
}

}  // namespace karst::bake
