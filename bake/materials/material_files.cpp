// SPDX-License-Identifier: MIT
#include "bake/materials/material_files.h"

#include "app/files/regular_file.h"
#include "bake/base/byte_message.h"
#include "bake/base/child.h"
#include "bake/base/image_threads.h"
#include "bake/elevation/exr_header.h"

#include <sys/stat.h>
#include <unistd.h>

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace karst::bake {
namespace {

constexpr int kMostChannels = 4;
constexpr std::uint64_t kMostBandBytes = 64u << 20;  // of rows that are decoded together, as floats
constexpr std::uint64_t kMemoryAByte = 32;           // for readers that hold all of a file decoded
constexpr int kMostScans = 64;                       // of a JPEG; each may go over all of the image

Error failure(const std::string& path, const std::string& what) {
  return path + ": " + what;
}

// What an image is made of, three channels (of one: three times the same), row 0 at the top.
struct Pixels {
  int width = 0, height = 0;
  std::vector<float> rgb;
};

// What is done with texels as they are read: colours are made linear (linear: floats are it), normals slopes.
enum class Use : std::uint32_t { colour, value, normal };
void change_row(Use use, std::span<float> rgb, bool linear);

// What a child is asked for; the path follows.
struct Asked {
  std::uint64_t bytes = 0;  // of the file
  std::int32_t side = 0;
  Use use = Use::colour;
  std::uint32_t channels = 0;
  TexelBudget budget{};
};

// What a child begins its result with.
struct Head {
  std::uint64_t texels = 0;             // of the image as it is in the file
  std::uint32_t width = 0, height = 0;  // of what follows
};

// Along one axis: how much of each texel goes into a texel of the result and how much into the next one.
class Shares {
 public:
  Shares(int from, int to) : shares_(static_cast<std::size_t>(from)) {
    const double scale = static_cast<double>(to) / from;
    for (int k = 0; k < from; ++k) {
      Share& share = shares_[static_cast<std::size_t>(k)];
      const double start = k * scale, end = k + 1 == from ? to : (k + 1) * scale;
      share.into = std::min(static_cast<int>(start), to - 1);
      const double here = std::min(end, share.into + 1.0) - start;
      share.here = static_cast<float>(here);
      share.next = share.into + 1 < to ? static_cast<float>(end - start - here) : 0.0f;
    }
  }
  struct Share {
    int into = 0;
    float here = 1, next = 0;
  };
  const Share& operator[](int k) const { return shares_[static_cast<std::size_t>(k)]; }

 private:
  std::vector<Share> shares_;
};

void add_scaled(std::span<const float> row, float weight, float* out) {
  if (weight == 0) return;
  for (std::size_t k = 0; k < row.size(); ++k) out[k] += weight * row[k];
}

// Takes rows from the top. What is at least twice as wide and high as `side` is averaged to it, what is more
// than twice as wide or high to twice, so that memory depends on the texture and not on the image.
class ReduceRows {
 public:
  ReduceRows(int width, int height, int side, Pixels& pixels)
      : width_(width),
        pixels_(pixels),
        across_(width, reduced(width, std::min(width, height), side)),
        down_(height, reduced(height, std::min(width, height), side)) {
    pixels = {
        reduced(width, std::min(width, height), side), reduced(height, std::min(width, height), side), {}};
    pixels.rgb.assign(stride() * static_cast<std::size_t>(pixels.height), 0.0f);
  }

  void take(int row, std::span<const float> rgb) {
    if (pixels_.width < width_) {
      narrow_.assign(stride() + 3, 0.0f);
      for (int x = 0; x < width_; ++x) {
        const Shares::Share& share = across_[x];
        const float* texel = rgb.data() + 3 * static_cast<std::size_t>(x);
        float* out = narrow_.data() + 3 * static_cast<std::size_t>(share.into);
        for (int c = 0; c < 3; ++c) out[c] += share.here * texel[c];
        for (int c = 0; c < 3; ++c) out[c + 3] += share.next * texel[c];
      }
      rgb = std::span<const float>(narrow_).first(stride());
    }
    const Shares::Share& share = down_[row];
    float* out = pixels_.rgb.data() + stride() * static_cast<std::size_t>(share.into);
    add_scaled(rgb, share.here, out);
    add_scaled(rgb, share.next, out + (share.next > 0 ? stride() : 0));
  }

 private:
  static int reduced(int size, int smaller, int side) {
    return smaller >= 2 * side ? side : std::min(size, 2 * side);
  }
  std::size_t stride() const { return 3 * static_cast<std::size_t>(pixels_.width); }

  int width_;
  Pixels& pixels_;
  Shares across_, down_;
  std::vector<float> narrow_;
};

// The OpenImageIO reader for a file, by its first bytes: a file is never handed to any other.
Error reader_for(const std::string& path, const char*& reader) {
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

// A JPEG of many scans over a large image takes long in few bytes. Inside of scans FF is followed by 0.
Error check_scans(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  int scans = 0;
  bool marker = false;
  char block[1 << 16];
  while (file.read(block, sizeof block), file.gcount() > 0) {
    for (const char c : std::string_view(block, static_cast<std::size_t>(file.gcount()))) {
      if (marker && c == '\xda') ++scans;
      marker = c == '\xff';
    }
  }
  if (scans <= kMostScans) return {};
  return failure(path, std::to_string(scans) + " scans; the most is " + std::to_string(kMostScans));
}

Error check_spec(const std::string& path, const OIIO::ImageSpec& spec, const Asked& asked) {
  const std::string size = std::to_string(spec.width) + " x " + std::to_string(spec.height) + " texels";
  if (spec.width < 1 || spec.height < 1 || spec.width > kMostImageSide || spec.height > kMostImageSide)
    return failure(path, "size: " + size + "; the most is " + std::to_string(kMostImageSide) + " a side");
  if (spec.depth > 1) return failure(path, "depth: a volume, not an image");
  if (spec.nchannels < 1 || spec.nchannels > kMostChannels)
    return failure(path, "channels: " + std::to_string(spec.nchannels) + "; an image has 1 to 4");
  const std::uint64_t texels =
      static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (texels > asked.budget.left()) {
    return failure(path, "size: " + size + " in " + std::to_string(asked.bytes) + " bytes, where " +
                             std::to_string(asked.budget.left()) +
                             " are left; use a smaller image, or --max-texels " +
                             std::to_string(asked.budget.enough(texels)));
  }
  if (spec.tile_width <= 0) return {};
  const std::uint64_t band = static_cast<std::uint64_t>(std::max(spec.width, spec.tile_width)) *
                             static_cast<std::uint64_t>(std::max(spec.tile_height, 0)) *
                             static_cast<std::uint64_t>(spec.nchannels) * sizeof(float);
  if (spec.tile_width > kMostImageSide || spec.tile_height < 1 || spec.tile_height > kMostImageSide ||
      band > kMostBandBytes) {
    return failure(path, "tiles: " + std::to_string(spec.tile_width) + " x " +
                             std::to_string(spec.tile_height) + " texels; save it with tiles of 256 a side");
  }
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

// In a child: calls take(row, values, floats) for rows from the top, channel by channel; floats: of the
// file's samples. begin(spec) comes first.
template <class Begin, class Take>
Error read_rows_of(const std::string& path, const Asked& asked, const Begin& begin, const Take& take) {
  keep_image_threads_away();
  const char* reader = nullptr;
  if (Error error = reader_for(path, reader); !error.ok()) return error;
  if (std::string_view(reader) == "openexr") {
    if (Error error = check_exr_header(path, kMostImageSide); !error.ok()) return error;
  }
  if (std::string_view(reader) == "jpeg") {
    if (Error error = check_scans(path); !error.ok()) return error;
  }
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(reader);
  if (input == nullptr) return failure(path, std::string("OpenImageIO has no reader for ") + reader);
  OIIO::ImageSpec spec, wanted;
  wanted["oiio:UnassociatedAlpha"] = 1;  // values as they are, whatever alpha is
  if (!input->open(path, spec, wanted)) return reading_failure(path, *input);
  if (Error error = check_spec(path, spec, asked); !error.ok()) return error;
  begin(spec);
  const int band = spec.tile_width > 0 ? spec.tile_height : 64;
  const std::size_t stride = static_cast<std::size_t>(spec.nchannels) * static_cast<std::size_t>(spec.width);
  std::vector<float> rows;
  for (int row = 0; row < spec.height; row += band) {
    const int last = std::min(row + band, spec.height);
    if (!read_rows(*input, row, last, rows)) return reading_failure(path, *input);
    if (!std::all_of(rows.begin(), rows.end(), [](float v) { return std::isfinite(v); }))
      return failure(path, "a texel is not a number");
    for (int k = row; k < last; ++k) {
      take(k, std::span<const float>(rows).subspan(static_cast<std::size_t>(k - row) * stride, stride),
           spec.format.is_floating_point());
    }
  }
  return {};
}

// is_reduced: they are asked.side a side, which the image is not. texels: of the image.
Error read_pixels(const std::string& path, const Asked& asked, Pixels& pixels, bool& is_reduced,
                  std::uint64_t& texels) {
  std::optional<ReduceRows> reduce;
  std::size_t channels = 0;
  std::vector<float> rgb;
  const auto begin = [&](const OIIO::ImageSpec& spec) {
    channels = static_cast<std::size_t>(spec.nchannels);
    texels = spec.image_pixels();
    rgb.resize(3 * static_cast<std::size_t>(spec.width));
    reduce.emplace(spec.width, spec.height, asked.side, pixels);
    is_reduced = spec.width >= 2 * asked.side && spec.height >= 2 * asked.side;
  };
  return read_rows_of(path, asked, begin, [&](int row, std::span<const float> values, bool floats) {
    for (std::size_t x = 0; 3 * x < rgb.size(); ++x) {
      for (std::size_t c = 0; c < 3; ++c) rgb[3 * x + c] = values[channels * x + (channels < 3 ? 0 : c)];
    }
    change_row(asked.use, rgb, floats);
    reduce->take(row, rgb);
  });
}

// From the lowest row up.
void flip(const Pixels& pixels, std::vector<float>& texels) {
  texels.clear();
  const auto stride = 3 * static_cast<std::size_t>(pixels.width);
  for (std::size_t row = pixels.rgb.size(); row > 0; row -= stride) {
    texels.insert(texels.end(), pixels.rgb.begin() + static_cast<std::ptrdiff_t>(row - stride),
                  pixels.rgb.begin() + static_cast<std::ptrdiff_t>(row));
  }
}

// To side x side texels. The image is repeated around its borders, so that the filter sees what tiling shows
// there. Row 0 of the result is the image's lowest.
Error resize(Pixels& pixels, const std::string& path, int side, std::vector<float>& texels) {
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
  pixels.rgb = {};
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

void change_row(Use use, std::span<float> rgb, bool linear) {
  if (use == Use::colour && !linear) {
    for (float& value : rgb) value = srgb_fraction_to_linear(value);
  }
  if (use != Use::normal) return;
  for (std::size_t k = 0; k < rgb.size(); k += 3) {
    float* n = rgb.data() + k;
    const float up = std::max(n[2] * 2 - 1, 0.05f);
    n[0] = -(n[0] * 2 - 1) / up;
    n[1] = -(n[1] * 2 - 1) / up;
    n[2] = 0;
  }
}

std::string path_in_request(std::span<const std::byte> request, Asked& asked) {
  std::string path;
  ReadMessage message(request);
  message.take(asked);
  message.take_text(path);
  return path;
}

// Fills asked.bytes and asked.budget. result: what follows the head, wanted_bytes(head) long.
template <class Wanted>
Error ask_child(const ChildTask& task, const std::string& path, Asked asked, TexelBudget& budget,
                std::size_t most_bytes, const Wanted& wanted_bytes, Head& head,
                std::vector<std::byte>& result) {
  asked.budget = budget;
  int descriptor = -1;
  if (Error error = app::open_regular_file(path, descriptor, asked.bytes); !error.ok()) return error;
  close(descriptor);
  ChildLimits limits;
  limits.memory_bytes += kMemoryAByte * asked.bytes;
  limits.result_bytes = sizeof head + most_bytes;
  std::vector<std::byte> request;
  WriteMessage message(request);
  message.put(asked);
  message.put_text(path);
  if (Error error = run_in_child(path, limits, task, request, result); !error.ok()) return error;
  ReadMessage read(result);
  read.take(head);
  if (!read.whole() || head.texels > budget.left() || result.size() != sizeof head + wanted_bytes(head))
    return failure(path, "its reader stopped early");
  budget.use(head.texels);
  result.erase(result.begin(), result.begin() + sizeof head);
  return {};
}

// In a child: all of OpenImageIO's work on an image.
Error read_in_child(std::span<const std::byte> request, std::vector<std::byte>& result) {
  Asked asked;
  const std::string path = path_in_request(request, asked);
  Pixels pixels;
  bool is_reduced = false;
  Head head;
  if (Error error = read_pixels(path, asked, pixels, is_reduced, head.texels); !error.ok()) return error;
  std::vector<float> resized;
  if (is_reduced) {
    flip(pixels, resized);
  } else if (Error error = resize(pixels, path, asked.side, resized); !error.ok()) {
    return error;
  }
  pixels = {};
  const auto sent = std::as_bytes(std::span(resized));
  result.reserve(sizeof head + sent.size());
  WriteMessage(result).put(head);
  result.insert(result.end(), sent.begin(), sent.end());
  return {};
}

// In a child: a map of weights, at most kMostBlendSide a side, each texel the mean of what it stands for.
Error read_map_in_child(std::span<const std::byte> request, std::vector<std::byte>& result) {
  Asked asked;
  const std::string path = path_in_request(request, asked);
  std::optional<Shares> across, down;
  std::size_t channels = 0, width = 0;
  std::vector<float> sums;
  Head head;
  const auto begin = [&](const OIIO::ImageSpec& spec) {
    channels = static_cast<std::size_t>(spec.nchannels);
    head = {spec.image_pixels(), std::min(static_cast<std::uint32_t>(spec.width), kMostBlendSide),
            std::min(static_cast<std::uint32_t>(spec.height), kMostBlendSide)};
    width = head.width;
    across.emplace(spec.width, static_cast<int>(head.width));
    down.emplace(spec.height, static_cast<int>(head.height));
    sums.assign((std::size_t{head.width} * head.height + head.width + 1) * kBlendTexelBytes, 0.0f);
  };
  const auto take = [&](int row, std::span<const float> values, bool) {
    const Shares::Share& y = (*down)[row];
    for (std::size_t k = 0; k < values.size(); ++k) {
      const Shares::Share& x = (*across)[static_cast<int>(k / channels)];
      const std::size_t at =
          (static_cast<std::size_t>(y.into) * width + static_cast<std::size_t>(x.into)) * kBlendTexelBytes +
          k % channels;
      const float value = std::clamp(values[k], 0.0f, 1.0f);
      sums[at] += value * x.here * y.here;
      sums[at + kBlendTexelBytes] += value * x.next * y.here;
      sums[at + width * kBlendTexelBytes] += value * x.here * y.next;
      sums[at + (width + 1) * kBlendTexelBytes] += value * x.next * y.next;
    }
  };
  if (Error error = read_rows_of(path, asked, begin, take); !error.ok()) return error;
  if (channels < asked.channels) {
    return failure(path, "has " + std::to_string(channels) + (channels == 1 ? " channel" : " channels") +
                             ", and " + std::to_string(asked.channels) + " materials are named");
  }
  const std::size_t count = width * head.height * kBlendTexelBytes;
  result.reserve(sizeof head + count);
  WriteMessage(result).put(head);
  for (std::size_t k = 0; k < count; ++k)
    result.push_back(static_cast<std::byte>(std::lround(sums[k] * 255.0f)));
  return {};
}

// An image's texels at the texture's side.
Error read_texels(const std::string& path, int side, Use use, TexelBudget& budget,
                  std::vector<float>& texels) {
  const std::size_t count = 3 * static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  const std::size_t bytes = count * sizeof(float);
  std::vector<std::byte> result;
  Head head;
  const Asked asked{.side = side, .use = use};
  const auto wanted = [bytes](const Head&) { return bytes; };
  if (Error error = ask_child(kReadMaterialImage, path, asked, budget, bytes, wanted, head, result);
      !error.ok())
    return error;
  texels.resize(count);
  std::memcpy(texels.data(), result.data(), result.size());
  return {};
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

const ChildTask kReadMaterialImage{"material image", read_in_child};
const ChildTask kReadBlendMap{"blend map", read_map_in_child};

std::string path_in(const std::string& folder, const std::string& path) {
  return path.front() == '/' || folder.empty() ? path : folder + "/" + path;
}

TexelBudget::TexelBudget(std::span<const std::string> paths, std::uint64_t allowed)
    : images_(std::max<std::size_t>(paths.size(), 1)) {
  std::set<std::pair<dev_t, ino_t>> files;
  for (const std::string& path : paths) {
    struct stat file {};
    if (stat(path.c_str(), &file) != 0 || !files.emplace(file.st_dev, file.st_ino).second) continue;
    most_ += kTexelsAByte * static_cast<std::uint64_t>(file.st_size);
  }
  most_ = std::max(most_, allowed);
}

void TexelBudget::use(std::uint64_t texels) {
  used_ += texels;
  if (read_ + 1 < images_) ++read_;
}

Error read_material_image(const MaterialSpec& spec, const std::string& folder, int side, TexelBudget& budget,
                          MaterialImage& image) {
  image = MaterialImage(side);
  std::vector<float> texels;
  const auto read = [&](const std::string& name, Use use) {
    return read_texels(path_in(folder, name), side, use, budget, texels);
  };
  const auto clamped = [](float value) { return std::clamp(value, 0.0f, 1.0f); };

  if (Error error = read(spec.albedo, Use::colour); !error.ok()) return error;
  for (std::size_t k = 0; k < image.count(); ++k) {
    for (int c = 0; c < 3; ++c) image.albedo[k][c] = clamped(texels[3 * k + static_cast<std::size_t>(c)]);
  }
  if (spec.height.empty()) {
    brightness_as_height(image, texels);
  } else {
    if (Error error = read(spec.height, Use::value); !error.ok()) return error;
    for (std::size_t k = 0; k < image.count(); ++k) image.height[k] = clamped(texels[3 * k]);
  }
  if (spec.normal.empty()) {
    image.derive_slopes(static_cast<float>(spec.relief));
  } else {
    if (Error error = read(spec.normal, Use::normal); !error.ok()) return error;
    for (std::size_t k = 0; k < image.count(); ++k) image.slope[k] = {texels[3 * k], texels[3 * k + 1]};
  }
  std::fill(image.roughness.begin(), image.roughness.end(), static_cast<float>(spec.roughness_value));
  if (!spec.roughness.empty()) {
    if (Error error = read(spec.roughness, Use::value); !error.ok()) return error;
    for (std::size_t k = 0; k < image.count(); ++k) image.roughness[k] = clamped(texels[3 * k]);
  }
  return {};
}

Error read_blend_map(const std::string& path, std::size_t wanted, TexelBudget& budget, BlendMap& map,
                     std::vector<std::byte>& texels) {
  constexpr std::size_t kMost = kBlendTexelBytes * kMostBlendSide * kMostBlendSide;
  const Asked asked{.channels = static_cast<std::uint32_t>(wanted)};
  const auto bytes = [](const Head& head) {
    return std::size_t{head.width} * head.height * kBlendTexelBytes;
  };
  Head head;
  if (Error error = ask_child(kReadBlendMap, path, asked, budget, kMost, bytes, head, texels); !error.ok())
    return error;
  map.width = head.width;
  map.depth = head.height;
  return {};
}

}  // namespace karst::bake
