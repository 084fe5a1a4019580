// SPDX-License-Identifier: MIT
#include "tests/bake/bake_files.h"

#include "bake/base/image_threads.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#if defined(__SANITIZE_ADDRESS__)
#define KARST_LEAK_CHECK 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define KARST_LEAK_CHECK 1
#endif
#endif
#ifdef KARST_LEAK_CHECK
#include <sanitizer/lsan_interface.h>
#endif

namespace karst::bake {
namespace {

template <class T>
void append(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

}  // namespace

#ifdef KARST_LEAK_CHECK
IgnoreLeaks::IgnoreLeaks() {
  __lsan_disable();
}
IgnoreLeaks::~IgnoreLeaks() {
  __lsan_enable();
}
#else
IgnoreLeaks::IgnoreLeaks() = default;
IgnoreLeaks::~IgnoreLeaks() = default;
#endif

TiffBuilder::TiffBuilder(std::uint32_t width, std::uint32_t height, int bits, int sample_format,
                         std::string pixels)
    : pixels_(std::move(pixels)) {
  const auto one_long = [&](std::uint16_t tag, std::uint32_t value) {
    std::string data;
    append(data, value);
    add(tag, 4, 1, data);
  };
  one_long(256, width);
  one_long(257, height);
  shorts(258, {static_cast<std::uint16_t>(bits)});
  shorts(259, {1});       // not compressed
  shorts(262, {1});       // black is zero
  one_long(273, 8);       // pixels follow the file's header
  shorts(277, {1});       // samples a pixel
  one_long(278, height);  // all rows in one strip
  one_long(279, static_cast<std::uint32_t>(pixels_.size()));
  shorts(339, {static_cast<std::uint16_t>(sample_format)});
}

TiffBuilder& TiffBuilder::add(std::uint16_t tag, std::uint16_t type, std::uint32_t count, std::string data) {
  entries_.push_back({tag, type, count, std::move(data)});
  return *this;
}

TiffBuilder& TiffBuilder::shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values) {
  return add(tag, 3, static_cast<std::uint32_t>(values.size()), std::string(bytes_of(values)));
}

TiffBuilder& TiffBuilder::doubles(std::uint16_t tag, const std::vector<double>& values) {
  return add(tag, 12, static_cast<std::uint32_t>(values.size()), std::string(bytes_of(values)));
}

TiffBuilder& TiffBuilder::ascii(std::uint16_t tag, const std::string& text) {
  return add(tag, 2, static_cast<std::uint32_t>(text.size() + 1), text + '\0');
}

TiffBuilder& TiffBuilder::geo_keys(const std::vector<std::uint16_t>& key_value_pairs) {
  std::vector<std::uint16_t> directory = {1, 1, 0, static_cast<std::uint16_t>(key_value_pairs.size() / 2)};
  for (std::size_t k = 0; k + 1 < key_value_pairs.size(); k += 2) {
    directory.insert(directory.end(), {key_value_pairs[k], 0, 1, key_value_pairs[k + 1]});
  }
  return shorts(34735, directory);
}

TiffBuilder& TiffBuilder::compressed() {
  for (Entry& entry : entries_) {
    if (entry.tag == 259) entry.data = std::string("\10\0", 2);
  }
  return *this;
}

std::string TiffBuilder::bytes() const {
  std::vector<Entry> entries = entries_;
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
  std::string pixels = pixels_;
  if (pixels.size() % 2 == 1) pixels += '\0';
  std::string out("II*\0", 4);
  append(out, static_cast<std::uint32_t>(8 + pixels.size()));
  out += pixels;
  const std::size_t directory_bytes = 2 + 12 * entries.size() + 4;
  std::string directory, extra;
  append(directory, static_cast<std::uint16_t>(entries.size()));
  for (const Entry& e : entries) {
    append(directory, e.tag);
    append(directory, e.type);
    append(directory, e.count);
    if (e.data.size() <= 4) {
      std::string inline_data = e.data;
      inline_data.resize(4);
      directory += inline_data;
    } else {
      append(directory, static_cast<std::uint32_t>(out.size() + directory_bytes + extra.size()));
      extra += e.data;
      if (extra.size() % 2 == 1) extra += '\0';
    }
  }
  append(directory, std::uint32_t{0});
  return out + directory + extra;
}

void write_image(const std::string& path, int width, int height, std::span<const float> samples,
                 const std::string& type, int tile, int channels) {
  keep_image_threads_away();
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc(type));
  spec.tile_width = spec.tile_height = tile;
  if (path.ends_with(".tif")) spec.attribute("compression", "none");
  const auto out = OIIO::ImageOutput::create(path);
  ASSERT_NE(out, nullptr) << path;
  ASSERT_TRUE(out->open(path, spec)) << out->geterror();
  // Integers go out as they are: OpenImageIO would stretch floats over the integer's range.
  bool ok = false;
  if (type == "uint16") {
    const std::vector<std::uint16_t> native(samples.begin(), samples.end());
    ok = out->write_image(OIIO::TypeDesc::UINT16, native.data());
  } else if (type == "int16") {
    const std::vector<std::int16_t> native(samples.begin(), samples.end());
    ok = out->write_image(OIIO::TypeDesc::INT16, native.data());
  } else if (type == "uint8") {
    const std::vector<std::uint8_t> native(samples.begin(), samples.end());
    ok = out->write_image(OIIO::TypeDesc::UINT8, native.data());
  } else {
    ok = out->write_image(OIIO::TypeDesc::FLOAT, samples.data());
  }
  ASSERT_TRUE(ok && out->close()) << out->geterror();
}

std::string error_of(const ReadElevation& read) {
  Elevation elevation;
  return read.run(elevation).text();
}

Elevation elevation_of(const ReadElevation& read) {
  Elevation elevation;
  EXPECT_EQ(read.run(elevation).text(), "");
  return elevation;
}

}  // namespace karst::bake
