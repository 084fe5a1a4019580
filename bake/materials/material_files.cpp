// SPDX-License-Identifier: MIT
#include "bake/materials/material_files.h"

#include "app/common/regular_file.h"
#include "bake/base/bake_error.h"
#include "bake/elevation/exr_header.h"
#include "bake/elevation/quiet_stderr.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string_view>
#include <vector>

namespace karst::bake {
namespace {

constexpr int kMostChannels = 16;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw BakeError(path + ": " + what);
}

// Texels of a file, three channels (of one: three times the same), row 0 at the image's top.
struct Pixels {
  int width = 0, height = 0;
  std::vector<float> rgb;
  bool linear = false;  // floats
};

// The OpenImageIO reader for a file, by its first bytes: a file is never handed to any other.
const char* reader_for(const std::string& path) {
  int descriptor = -1;
  std::uint64_t bytes = 0;
  if (const std::string error = app::open_regular_file(path, descriptor, bytes); !error.empty())
    throw BakeError(error);
  close(descriptor);
  char first[8] = {};
  std::ifstream(path, std::ios::binary).read(first, sizeof first);
  const std::string_view start(first, sizeof first);
  if (start == std::string_view("\x89PNG\r\n\x1a\n", 8)) return "png";
  if (start.substr(0, 3) == "\xff\xd8\xff") return "jpeg";
  for (const std::string_view tiff : {std::string_view("II*\0", 4), std::string_view("MM\0*", 4)}) {
    if (start.substr(0, 4) == tiff) return "tiff";
  }
  if (start.substr(0, 4) == "v/1\x01") return "openexr";
  fail(path, "not a PNG, JPEG, TIFF or OpenEXR image");
}

void check_spec(const std::string& path, const OIIO::ImageSpec& spec) {
  if (spec.width < 1 || spec.height < 1 || spec.width > kMostImageSide || spec.height > kMostImageSide) {
    fail(path, "size: " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                   " texels; the most is " + std::to_string(kMostImageSide) + " a side");
  }
  if (spec.depth > 1) fail(path, "depth: a volume, not an image");
  if (spec.nchannels < 1 || spec.nchannels > kMostChannels)
    fail(path, "channels: " + std::to_string(spec.nchannels) + "; an image has 1 to 4");
  if (spec.tile_width < 0 || spec.tile_height < 0 || spec.tile_width > kMostImageSide ||
      spec.tile_height > kMostImageSide)
    fail(path, "tiles: larger than any image");
}

[[noreturn]] void fail_reading(const std::string& path, OIIO::ImageInput& input) {
  std::string why = input.geterror();
  std::replace(why.begin(), why.end(), '\n', ' ');
  fail(path, "unreadable image: " + (why.empty() ? "truncated or damaged" : why));
}

// Rows [row, last). Scanlines one by one: elevation.cpp says why.
bool read_rows(OIIO::ImageInput& input, int row, int last, std::vector<float>& rows) {
  const OIIO::ImageSpec& spec = input.spec();
  const auto stride = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
  rows.resize(stride * static_cast<std::size_t>(last - row));
  if (spec.tile_width > 0) {
    return input.read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + row, spec.y + last, spec.z,
                            spec.z + 1, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, rows.data());
  }
  for (int k = row; k < last; ++k) {
    float* out = rows.data() + static_cast<std::size_t>(k - row) * stride;
    if (!input.read_scanline(spec.y + k, spec.z, OIIO::TypeDesc::FLOAT, out)) return false;
  }
  return true;
}

Pixels read_pixels(const std::string& path) {
  const char* reader = reader_for(path);
  if (std::string_view(reader) == "openexr") check_exr_header(path, kMostImageSide);
  const QuietStderr quiet;
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(reader);
  if (input == nullptr) fail(path, std::string("OpenImageIO has no reader for ") + reader);
  OIIO::ImageSpec spec;
  if (!input->open(path, spec)) fail_reading(path, *input);
  check_spec(path, spec);
  Pixels pixels{spec.width, spec.height, {}, spec.format.is_floating_point()};
  const int band = spec.tile_width > 0 ? spec.tile_height : 64;
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<float> rows;
  // Memory grows with what was read: a short file that claims to be large fails early.
  for (int row = 0; row < spec.height; row += band) {
    if (!read_rows(*input, row, std::min(row + band, spec.height), rows)) fail_reading(path, *input);
    for (std::size_t k = 0; k < rows.size(); k += channels) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = rows[k + (channels < 3 ? 0 : c)];
        if (!std::isfinite(value)) fail(path, "a texel is not a number");
        pixels.rgb.push_back(value);
      }
    }
  }
  return pixels;
}

void make_linear(Pixels& pixels) {
  if (pixels.linear) return;
  for (float& value : pixels.rgb) value = srgb_fraction_to_linear(value);
}

// To side x side texels. The image is repeated around its borders, so that the filter sees what tiling shows
// there. Row 0 of the result is the image's lowest.
std::vector<float> resized(const Pixels& pixels, const std::string& path, int side) {
  const auto reach = [side](int size) { return 4 * std::max(1, (size + side - 1) / side) + 4; };
  const int pad_x = reach(pixels.width), pad_y = reach(pixels.height);
  OIIO::ImageSpec spec(pixels.width + 2 * pad_x, pixels.height + 2 * pad_y, 3, OIIO::TypeDesc::FLOAT);
  spec.x = -pad_x;
  spec.y = -pad_y;
  spec.full_x = spec.full_y = 0;
  spec.full_width = pixels.width;
  spec.full_height = pixels.height;
  std::vector<float> padded;
  padded.reserve(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) * 3);
  const auto wrap = [](int k, int size) { return static_cast<std::size_t>(((k % size) + size) % size); };
  for (int y = -pad_y; y < pixels.height + pad_y; ++y) {
    const std::size_t row = wrap(y, pixels.height) * static_cast<std::size_t>(pixels.width);
    for (int x = -pad_x; x < pixels.width + pad_x; ++x) {
      const float* texel = pixels.rgb.data() + 3 * (row + wrap(x, pixels.width));
      padded.insert(padded.end(), texel, texel + 3);
    }
  }
  const OIIO::ImageBuf source(spec, padded.data());
  OIIO::ImageBuf target(OIIO::ImageSpec(side, side, 3, OIIO::TypeDesc::FLOAT));
  if (!OIIO::ImageBufAlgo::resize(target, source)) fail(path, "cannot be resized: " + target.geterror());
  std::vector<float> texels(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 3);
  const auto stride = static_cast<std::size_t>(side) * 3 * sizeof(float);
  // From the last row up.
  float* last = texels.data() + static_cast<std::size_t>(side - 1) * static_cast<std::size_t>(side) * 3;
  if (!target.get_pixels(OIIO::ROI(0, side, 0, side, 0, 1, 0, 3), OIIO::TypeDesc::FLOAT, last,
                         OIIO::AutoStride, -static_cast<OIIO::stride_t>(stride)))
    fail(path, "cannot be resized: " + target.geterror());
  return texels;
}

// Normals of the image as slopes, in place.
void make_slopes(Pixels& pixels) {
  for (std::size_t k = 0; k < pixels.rgb.size(); k += 3) {
    float* n = pixels.rgb.data() + k;
    const float up = std::max(n[2] * 2 - 1, 0.05f);
    n[0] = -(n[0] * 2 - 1) / up;
    n[1] = -(n[1] * 2 - 1) / up;
    n[2] = 0;
  }
}

float brightness(const float* rgb) {
  return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

void brightness_as_height(MaterialImage& image, const std::vector<float>& albedo) {
  for (std::size_t k = 0; k < image.count(); ++k) image.height[k] = brightness(albedo.data() + 3 * k);
  const auto [low, high] = std::minmax_element(image.height.begin(), image.height.end());
  const float least = *low, range = std::max(*high - *low, 1e-6f);
  for (float& height : image.height) height = (height - least) / range;
}

std::string path_in(const std::string& folder, const std::string& path) {
  return path.front() == '/' || folder.empty() ? path : folder + "/" + path;
}

}  // namespace

MaterialImage read_material_image(const MaterialSpec& spec, const std::string& folder, int side) {
  MaterialImage image(side);
  const auto read = [&](const std::string& name, auto&& change) {
    const std::string path = path_in(folder, name);
    Pixels pixels = read_pixels(path);
    change(pixels);
    return resized(pixels, path, side);
  };
  const auto as_it_is = [](Pixels&) {};
  const auto clamped = [](float value) { return std::clamp(value, 0.0f, 1.0f); };

  const std::vector<float> albedo = read(spec.albedo, make_linear);
  for (std::size_t k = 0; k < image.count(); ++k) {
    for (int c = 0; c < 3; ++c) image.albedo[k][c] = clamped(albedo[3 * k + static_cast<std::size_t>(c)]);
  }
  if (spec.height.empty()) {
    brightness_as_height(image, albedo);
  } else {
    const std::vector<float> height = read(spec.height, as_it_is);
    for (std::size_t k = 0; k < image.count(); ++k) image.height[k] = clamped(height[3 * k]);
  }
  if (spec.normal.empty()) {
    image.derive_slopes(static_cast<float>(spec.relief));
  } else {
    const std::vector<float> slopes = read(spec.normal, make_slopes);
    for (std::size_t k = 0; k < image.count(); ++k) image.slope[k] = {slopes[3 * k], slopes[3 * k + 1]};
  }
  std::fill(image.roughness.begin(), image.roughness.end(), static_cast<float>(spec.roughness_value));
  if (!spec.roughness.empty()) {
    const std::vector<float> roughness = read(spec.roughness, as_it_is);
    for (std::size_t k = 0; k < image.count(); ++k) image.roughness[k] = clamped(roughness[3 * k]);
  }
  return image;
}

}  // namespace karst::bake
