// SPDX-License-Identifier: MIT
#include "bake/materials/material_files.h"

#include "app/files/regular_file.h"
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

Error failure(const std::string& path, const std::string& what) {
  return path + ": " + what;
}

// Texels of a file, three channels (of one: three times the same), row 0 at the image's top.
struct Pixels {
  int width = 0, height = 0;
  std::vector<float> rgb;
  bool linear = false;  // floats
};

// The OpenImageIO reader for a file, by its first bytes: a file is never handed to any other.
Error reader_for(const std::string& path, const char*& reader) {
  int descriptor = -1;
  std::uint64_t bytes = 0;
  if (Error error = app::open_regular_file(path, descriptor, bytes); !error.ok()) return error;
  close(descriptor);
  char first[8] = {};
  std::ifstream(path, std::ios::binary).read(first, sizeof first);
  const std::string_view start(first, sizeof first);
  reader = nullptr;
  if (start == std::string_view("\x89PNG\r\n\x1a\n", 8)) reader = "png";
  if (start.substr(0, 3) == "\xff\xd8\xff") reader = "jpeg";
  for (const std::string_view tiff : {std::string_view("II*\0", 4), std::string_view("MM\0*", 4)}) {
    if (start.substr(0, 4) == tiff) reader = "tiff";
  }
  if (start.substr(0, 4) == "v/1\x01") reader = "openexr";
  if (reader == nullptr) return failure(path, "not a PNG, JPEG, TIFF or OpenEXR image");
  return {};
}

Error check_spec(const std::string& path, const OIIO::ImageSpec& spec) {
  if (spec.width < 1 || spec.height < 1 || spec.width > kMostImageSide || spec.height > kMostImageSide) {
    return failure(path, "size: " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                             " texels; the most is " + std::to_string(kMostImageSide) + " a side");
  }
  if (spec.depth > 1) return failure(path, "depth: a volume, not an image");
  if (spec.nchannels < 1 || spec.nchannels > kMostChannels)
    return failure(path, "channels: " + std::to_string(spec.nchannels) + "; an image has 1 to 4");
  if (spec.tile_width < 0 || spec.tile_height < 0 || spec.tile_width > kMostImageSide ||
      spec.tile_height > kMostImageSide)
    return failure(path, "tiles: larger than any image");
  return {};
}

Error reading_failure(const std::string& path, OIIO::ImageInput& input) {
  std::string why = input.geterror();
  std::replace(why.begin(), why.end(), '\n', ' ');
  return failure(path, "unreadable image: " + (why.empty() ? "truncated or damaged" : why));
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

Error read_pixels(const std::string& path, Pixels& pixels) {
  const char* reader = nullptr;
  if (Error error = reader_for(path, reader); !error.ok()) return error;
  if (std::string_view(reader) == "openexr") {
    if (Error error = check_exr_header(path, kMostImageSide); !error.ok()) return error;
  }
  const QuietStderr quiet;
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(reader);
  if (input == nullptr) return failure(path, std::string("OpenImageIO has no reader for ") + reader);
  OIIO::ImageSpec spec;
  if (!input->open(path, spec)) return reading_failure(path, *input);
  if (Error error = check_spec(path, spec); !error.ok()) return error;
  pixels = {spec.width, spec.height, {}, spec.format.is_floating_point()};
  const int band = spec.tile_width > 0 ? spec.tile_height : 64;
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<float> rows;
  // Memory grows with what was read: a short file that claims to be large fails early.
  for (int row = 0; row < spec.height; row += band) {
    if (!read_rows(*input, row, std::min(row + band, spec.height), rows))
      return reading_failure(path, *input);
    for (std::size_t k = 0; k < rows.size(); k += channels) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = rows[k + (channels < 3 ? 0 : c)];
        if (!std::isfinite(value)) return failure(path, "a texel is not a number");
        pixels.rgb.push_back(value);
      }
    }
  }
  return {};
}

void make_linear(Pixels& pixels) {
  if (pixels.linear) return;
  for (float& value : pixels.rgb) value = srgb_fraction_to_linear(value);
}

// To side x side texels. The image is repeated around its borders, so that the filter sees what tiling shows
// there. Row 0 of the result is the image's lowest.
Error resize(const Pixels& pixels, const std::string& path, int side, std::vector<float>& texels) {
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
  if (!OIIO::ImageBufAlgo::resize(target, source))
    return failure(path, "cannot be resized: " + target.geterror());
  texels.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 3, 0.0f);
  const auto stride = static_cast<std::size_t>(side) * 3 * sizeof(float);
  // From the last row up.
  float* last = texels.data() + static_cast<std::size_t>(side - 1) * static_cast<std::size_t>(side) * 3;
  if (!target.get_pixels(OIIO::ROI(0, side, 0, side, 0, 1, 0, 3), OIIO::TypeDesc::FLOAT, last,
                         OIIO::AutoStride, -static_cast<OIIO::stride_t>(stride)))
    return failure(path, "cannot be resized: " + target.geterror());
  return {};
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

}  // namespace

std::string path_in(const std::string& folder, const std::string& path) {
  return path.front() == '/' || folder.empty() ? path : folder + "/" + path;
}

Error read_material_image(const MaterialSpec& spec, const std::string& folder, int side,
                          MaterialImage& image) {
  image = MaterialImage(side);
  std::vector<float> texels;
  const auto read = [&](const std::string& name, auto&& change) -> Error {
    const std::string path = path_in(folder, name);
    Pixels pixels;
    if (Error error = read_pixels(path, pixels); !error.ok()) return error;
    change(pixels);
    return resize(pixels, path, side, texels);
  };
  const auto as_it_is = [](Pixels&) {};
  const auto clamped = [](float value) { return std::clamp(value, 0.0f, 1.0f); };

  if (Error error = read(spec.albedo, make_linear); !error.ok()) return error;
  for (std::size_t k = 0; k < image.count(); ++k) {
    for (int c = 0; c < 3; ++c) image.albedo[k][c] = clamped(texels[3 * k + static_cast<std::size_t>(c)]);
  }
  if (spec.height.empty()) {
    brightness_as_height(image, texels);
  } else {
    if (Error error = read(spec.height, as_it_is); !error.ok()) return error;
    for (std::size_t k = 0; k < image.count(); ++k) image.height[k] = clamped(texels[3 * k]);
  }
  if (spec.normal.empty()) {
    image.derive_slopes(static_cast<float>(spec.relief));
  } else {
    if (Error error = read(spec.normal, make_slopes); !error.ok()) return error;
    for (std::size_t k = 0; k < image.count(); ++k) image.slope[k] = {texels[3 * k], texels[3 * k + 1]};
  }
  std::fill(image.roughness.begin(), image.roughness.end(), static_cast<float>(spec.roughness_value));
  if (!spec.roughness.empty()) {
    if (Error error = read(spec.roughness, as_it_is); !error.ok()) return error;
    for (std::size_t k = 0; k < image.count(); ++k) image.roughness[k] = clamped(texels[3 * k]);
  }
  return {};
}

}  // namespace karst::bake
