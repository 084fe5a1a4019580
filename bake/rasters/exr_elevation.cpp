// SPDX-License-Identifier: MIT
// Elevation from OpenEXR images, through OpenImageIO: GDAL on Debian reads none.
#include "bake/rasters/elevation_file.h"

#include "bake/base/image_threads.h"
#include "bake/elevation/exr_header.h"
#include "bake/rasters/sample_sink.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <memory>

namespace karst::bake {
namespace {

constexpr int kMaxTileSide = 4'096;  // samples; a tile is read whole

using Input = std::unique_ptr<OIIO::ImageInput>;

Error reading_failure(const std::string& path, OIIO::ImageInput& input) {
  std::string why = input.geterror();
  std::replace(why.begin(), why.end(), '\n', ' ');
  return path + ": unreadable image: " + (why.empty() ? "truncated or damaged" : why);
}

Error open_exr(const ReadElevation& settings, const std::string& path, Input& input) {
  if (Error error = check_exr_header(path, kMaxTileSide); !error.ok()) return error;
  keep_image_threads_away();
  input = OIIO::ImageInput::create("openexr");
  if (input == nullptr) return path + ": OpenImageIO has no reader for openexr";
  OIIO::ImageSpec spec;
  if (!input->open(path, spec)) return reading_failure(path, *input);
  if (spec.depth > 1) return path + ": depth: a volume, not an image";
  if (spec.nchannels != 1 || settings.band > 1) {
    return path + ": bands: an OpenEXR image of elevation has one, and this " +
           std::to_string(spec.nchannels) + "; save it with one alone";
  }
  if (spec.format != OIIO::TypeDesc::HALF && spec.format != OIIO::TypeDesc::FLOAT)
    return path + ": sample type: " + spec.format.c_str() + " is not half or float";
  return {};
}

}  // namespace

Error describe_exr(const ReadElevation& settings, const std::string& path, ElevationGrid& grid) {
  Input input;
  if (Error error = open_exr(settings, path, input); !error.ok()) return error;
  grid = {};
  grid.width = input->spec().width;
  grid.height = input->spec().height;
  grid.files = {path};
  const int rows = std::max(1, input->spec().tile_height);
  grid.block_row_bytes =
      sizeof(float) * static_cast<std::uint64_t>(grid.width) * static_cast<std::uint64_t>(rows);
  return {};
}

Error read_exr(const ReadElevation& settings, const std::string& path, const Window& part,
               ElevationPart& result) {
  Input input;
  if (Error error = open_exr(settings, path, input); !error.ok()) return error;
  if (settings.pixel_size_m <= 0)
    return path + ": pixel size: the file does not say how large a sample is; give --pixel-size M";
  result.spacing_x_m = result.spacing_z_m = settings.pixel_size_m;
  const OIIO::ImageSpec& spec = input->spec();
  SampleFormat format;
  format.kind = std::string("EXR ") + spec.format.c_str();
  format.is_float = true;
  SampleSink sink(settings, path, format, result);
  const int band = std::max(1, spec.tile_height), end = part.row + part.height;
  const auto width = static_cast<std::size_t>(spec.width);
  std::vector<float> rows(width * static_cast<std::size_t>(band));
  std::vector<double> samples(static_cast<std::size_t>(part.width));
  for (int first = part.row - part.row % band; first < end; first += band) {
    const int last = std::min(first + band, spec.height);
    const bool read =
        spec.tile_width > 0
            ? input->read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + first, spec.y + last, spec.z,
                                spec.z + 1, 0, 1, OIIO::TypeDesc::FLOAT, rows.data())
            : input->read_scanline(spec.y + first, spec.z, OIIO::TypeDesc::FLOAT, rows.data());
    if (!read) return reading_failure(path, *input);
    for (int row = std::max(first, part.row); row < std::min(last, end); ++row) {
      const float* from = rows.data() + static_cast<std::size_t>(row - first) * width + part.column;
      std::copy(from, from + part.width, samples.begin());
      if (Error error = sink.take_row(row, part.column, samples, {}); !error.ok()) return error;
    }
  }
  return sink.finish();
}

}  // namespace karst::bake
