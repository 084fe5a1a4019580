// SPDX-License-Identifier: MIT
#include "app/files/png_file.h"

#include <csetjmp>

#include <png.h>

namespace karst::app {
namespace {

// zlib's 6 takes three times as long as 3 for 5 % less.
constexpr int kCompression = 4;

struct Sink {
  std::vector<std::byte>* bytes;
  std::string error;
};

void append(png_structp png, png_bytep data, std::size_t size) {
  auto* sink = static_cast<Sink*>(png_get_io_ptr(png));
  const auto* first = reinterpret_cast<const std::byte*>(data);
  sink->bytes->insert(sink->bytes->end(), first, first + size);
}

void flush(png_structp) {}

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  static_cast<Sink*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

// What longjmp may leave: no object with a destructor lives in this function.
bool write(png_structp png, png_infop info, std::span<const std::uint8_t> rgba, int width, int height) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_compression_level(png, kCompression);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  png_set_filler(png, 0, PNG_FILLER_AFTER);
  for (int y = 0; y < height; ++y) {
    png_write_row(png, rgba.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) * 4);
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

Error encode_png(std::span<const std::uint8_t> rgba, int width, int height, std::vector<std::byte>& png) {
  png.clear();
  Sink sink{&png, {}};
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, on_error, on_warning);
  if (writer == nullptr) return "libpng: no memory";
  png_infop info = png_create_info_struct(writer);
  bool ok = false;
  if (info != nullptr) {
    png_set_write_fn(writer, &sink, append, flush);
    ok = write(writer, info, rgba, width, height);
  }
  png_destroy_write_struct(&writer, &info);
  if (ok) return {};
  png.clear();
  return "libpng: " + (sink.error.empty() ? std::string("no memory") : sink.error);
}

Error decode_png(std::span<const std::byte> png, int most_side, std::uint64_t most_bytes,
                 PngPicture& picture) {
  picture = {};
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) {
    return std::string("not a PNG picture: ") + image.message;
  }
  const auto most = static_cast<png_uint_32>(most_side);
  image.format = PNG_FORMAT_RGBA;
  const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels";
  const std::uint64_t bytes = std::uint64_t{image.width} * image.height * 4;
  Error error;
  if (image.width > most || image.height > most) {
    error = size + ", more than " + std::to_string(most_side) + " a side";
  } else if (bytes > most_bytes) {
    error = size + ", which take " + std::to_string(bytes >> 20) + " MiB of memory";
  }
  if (!error.ok()) {
    png_image_free(&image);
    return error;
  }
  picture.rgba.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr) == 0) {
    picture = {};
    return std::string("a damaged PNG picture: ") + image.message;
  }
  picture.width = static_cast<int>(image.width);
  picture.height = static_cast<int>(image.height);
  return {};
}

}  // namespace karst::app
