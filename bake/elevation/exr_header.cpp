// SPDX-License-Identifier: MIT
#include "bake/elevation/exr_header.h"

#include "bake/elevation/elevation.h"

#include <cstdint>
#include <fstream>
#include <string_view>

namespace karst::bake {
namespace {

constexpr std::size_t kMaxHeaderBytes =
    1 << 20;                                  // read at most; headers have a few hundred, previews some more
constexpr std::uint32_t kLeastTileSide = 16;  // samples; bounds the table of tiles to some MB
constexpr std::uint32_t kFlagsDeepOrMultipart = 0x1800;

// Past the end of the bytes it gives empty texts and zeros.
class Reader {
 public:
  Reader(const std::string& path, std::string_view bytes) : path_(path), rest_(bytes) {}

  std::string_view take(std::size_t count) {
    if (count > rest_.size()) {
      truncated_ = true;
      rest_ = {};
      return {};
    }
    const std::string_view result = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return result;
  }
  std::string_view take_name() {
    const std::string_view name = take(std::min(rest_.find('\0'), rest_.size()));
    take(1);
    return name;
  }
  static std::uint32_t u32(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      value |= std::uint32_t{static_cast<unsigned char>(bytes[at + k])} << (8 * k);
    }
    return value;
  }
  std::uint32_t take_u32() {
    const std::string_view bytes = take(4);
    return bytes.empty() ? 0 : u32(bytes, 0);
  }
  Error error() const {
    if (!truncated_) return {};
    return path_ + ": header: truncated or longer than 1 MiB";
  }

 private:
  const std::string& path_;
  std::string_view rest_;
  bool truncated_ = false;
};

Error check_data_window(const std::string& path, std::string_view box) {
  const auto corner = [&](std::size_t k) {
    return std::int64_t{static_cast<std::int32_t>(Reader::u32(box, 4 * k))};
  };
  const std::int64_t width = corner(2) - corner(0) + 1, height = corner(3) - corner(1) + 1;
  // Far-off corners overflow the library's own sums.
  constexpr std::int64_t kFarthest = 1 << 24;
  const bool far =
      corner(0) < -kFarthest || corner(1) < -kFarthest || corner(0) > kFarthest || corner(1) > kFarthest;
  if (far || width < 1 || height < 1 || width > kMaxElevationSide || height > kMaxElevationSide) {
    return path + ": dataWindow: " + std::to_string(width) + " x " + std::to_string(height) +
           " samples is out of range";
  }
  return {};
}

}  // namespace

Error check_exr_header(const std::string& path, int max_tile_side) {
  std::string bytes(kMaxHeaderBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  Reader reader(path, bytes);
  reader.take(4);  // magic, seen by the caller
  const std::uint32_t version = reader.take_u32();
  if (Error error = reader.error(); !error.ok()) return error;
  if ((version & kFlagsDeepOrMultipart) != 0) {
    return path + ": version: deep and multi-part files are not read";
  }
  bool has_window = false;
  for (std::string_view name = reader.take_name(); !name.empty(); name = reader.take_name()) {
    const std::string_view type = reader.take_name();
    const std::string_view value = reader.take(reader.take_u32());
    if (Error error = reader.error(); !error.ok()) return error;
    if (name == "dataWindow") {
      if (type != "box2i" || value.size() != 16) return path + ": dataWindow: not a box2i";
      if (Error error = check_data_window(path, value); !error.ok()) return error;
      has_window = true;
    } else if (name == "tiles") {
      if (type != "tiledesc" || value.size() != 9) return path + ": tiles: not a tiledesc";
      for (const std::size_t at : {std::size_t{0}, std::size_t{4}}) {
        const std::uint32_t side = Reader::u32(value, at);
        if (side < kLeastTileSide || side > static_cast<std::uint32_t>(max_tile_side)) {
          return path + ": tiles: " + std::to_string(side) + " a side is not in 16 to " +
                 std::to_string(max_tile_side);
        }
      }
    }
  }
  if (Error error = reader.error(); !error.ok()) return error;
  if (!has_window) return path + ": dataWindow: missing";
  return {};
}

}  // namespace karst::bake
