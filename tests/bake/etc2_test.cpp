// SPDX-License-Identifier: MIT
// How near the compressed images come to the originals, and what must hold for every block. That the decoder
// is right is for tests/gl/etc2_test.cpp, which asks the driver.
#include "etc2/etc2.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/vec2.hpp>

#include "bake/samples/noise.h"

namespace karst::bake {
using namespace etc2;
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Image {
  std::uint32_t width = 0, height = 0;
  Bytes rgba;

  // value(x, y, channel): 0..255, rounded and clamped here.
  template <class Value>
  Image(std::uint32_t w, std::uint32_t h, Value value) : width(w), height(h) {
    for (std::uint32_t y = 0; y < h; ++y) {
      for (std::uint32_t x = 0; x < w; ++x) {
        for (int c = 0; c < 4; ++c) {
          const double v = std::clamp(value(double(x), double(y), c), 0.0, 255.0);
          rgba.push_back(static_cast<std::uint8_t>(std::lround(v)));
        }
      }
    }
  }
};

Bytes encoded(const Image& image, const Etc2Settings& settings = {}) {
  Bytes blocks(etc2_bytes(image.width, image.height));
  const Status status = encode_etc2(image.rgba, image.width, image.height, blocks, settings);
  EXPECT_TRUE(status.ok()) << status.field() << ' ' << status.what();
  return blocks;
}

Bytes through(const Image& image, const Etc2Settings& settings = {}) {
  Bytes rgba(image.rgba.size());
  const Status status = decode_etc2(encoded(image, settings), image.width, image.height, rgba);
  EXPECT_TRUE(status.ok()) << status.field() << ' ' << status.what();
  return rgba;
}

// Sum over texels, of one channel.
std::uint64_t squared_error(const Bytes& a, const Bytes& b, std::size_t channel) {
  std::uint64_t sum = 0;
  for (std::size_t at = channel; at < a.size(); at += 4) {
    const int d = a[at] - b[at];
    sum += static_cast<std::uint64_t>(d * d);
  }
  return sum;
}
std::uint64_t colour_error(const Bytes& a, const Bytes& b) {
  return squared_error(a, b, 0) + squared_error(a, b, 1) + squared_error(a, b, 2);
}

double psnr_db(std::uint64_t error, std::size_t values) {
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(values) / static_cast<double>(error));
}
double colour_psnr_db(const Image& image, const Bytes& decoded) {
  return psnr_db(colour_error(image.rgba, decoded), image.rgba.size() / 4 * 3);
}

Image white_noise(std::uint32_t side) {
  std::mt19937 random(5);
  return {side, side, [&](double, double, int) { return static_cast<double>(random() >> 24); }};
}

// Octaves of noise from a period of texels down, each `gain` times as strong as the one before.
double octaves(double x, double y, std::uint32_t seed, int count, double period, double gain) {
  double sum = 0, size = 1;
  for (int k = 0; k < count; ++k, period /= 2, size *= gain)
    sum += size * noise(glm::dvec2(x, y) / period, seed + static_cast<std::uint32_t>(k));
  return sum;
}

// Like a rock: browns, height in alpha.
Image rock() {
  return {256, 256, [](double x, double y, int c) {
            const double grey = octaves(x, y, 1, 6, 64, 0.7), hue = octaves(x, y, 20, 6, 64, 0.6);
            const double base[4] = {130, 105, 80, 128}, tint[4] = {20, 4, -16, 0};
            return base[c] + (c == 3 ? 100 : 60) * grey + tint[c] * hue;
          }};
}

// Channels that do not go together: one in red and blue, one in green, one in alpha.
Image normals() {
  return {256, 256, [](double x, double y, int c) {
            const bool roughness = c == 0 || c == 2;
            const double v =
                octaves(x, y, roughness ? 40 : 60 + 10 * static_cast<std::uint32_t>(c), 5, 48, 0.75);
            return roughness ? 190 + 40 * v : 128 + 90 * v;
          }};
}

struct Floor {
  const char* name;
  Image image;
  double colour_db, alpha_db;
};

TEST(Etc2, ComesNearTheOriginal) {
  const Floor floors[] = {
      {"gradient",
       {128, 128, [](double x, double y, int c) { return x * (c + 1) / 4.1 + y * (4 - c) / 5.3; }},
       49,
       60},
      {"rock", rock(), 40, 45.5},
      {"normals", normals(), 35, 44},
      {"white noise", white_noise(128), 14.6, 31},
  };
  for (const Floor& floor : floors) {
    SCOPED_TRACE(floor.name);
    const std::clock_t start = std::clock();
    const Bytes decoded = through(floor.image);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const double colour = colour_psnr_db(floor.image, decoded);
    const double alpha = psnr_db(squared_error(floor.image.rgba, decoded, 3), decoded.size() / 4);
    std::printf("%-12s colour %.2f dB, alpha %.2f dB, %.0f us a block\n", floor.name, colour, alpha,
                1e6 * seconds * kEtc2BlockBytes / static_cast<double>(floor.image.rgba.size() / 4));
    EXPECT_GT(colour, floor.colour_db);
    EXPECT_GT(alpha, floor.alpha_db);
  }
}

// Each mode alone, and what the rest gain by it.
TEST(Etc2, MoreModesAreNeverWorse) {
  const struct {
    const char* name;
    unsigned mode;
  } modes[] = {{"individual", kEtc2Individual},
               {"differential", kEtc2Differential},
               {"T", kEtc2T},
               {"H", kEtc2H},
               {"planar", kEtc2Planar}};
  const struct {
    const char* name;
    Image image;
  } subjects[] = {{"rock", rock()}, {"normals", normals()}, {"white noise", white_noise(64)}};
  for (const auto& subject : subjects) {
    const Image& image = subject.image;
    SCOPED_TRACE(subject.name);
    const Bytes all = through(image);
    std::printf("%s: all modes %.2f dB\n", subject.name, colour_psnr_db(image, all));
    for (const auto& mode : modes) {
      Etc2Settings alone, without;
      alone.modes = mode.mode;
      without.modes = kEtc2AllModes & ~mode.mode;
      const Bytes only = through(image, alone), rest = through(image, without);
      std::printf("  %-12s alone %.2f dB, without it %.2f dB\n", mode.name, colour_psnr_db(image, only),
                  colour_psnr_db(image, rest));
      // Block by block, not only on the whole.
      for (std::uint32_t y = 0; y < image.height; y += 4) {
        for (std::uint32_t x = 0; x < image.width; x += 4) {
          std::uint64_t error_all = 0, error_only = 0, error_rest = 0;
          for (std::uint32_t p = 0; p < 16; ++p) {
            for (std::size_t c = 0; c < 3; ++c) {
              const std::size_t at = (std::size_t{y + p / 4} * image.width + x + p % 4) * 4 + c;
              const auto square = [&](const Bytes& b) {
                const int d = b[at] - image.rgba[at];
                return static_cast<std::uint64_t>(d * d);
              };
              error_all += square(all);
              error_only += square(only);
              error_rest += square(rest);
            }
          }
          ASSERT_LE(error_all, error_only) << mode.name << " alone, block at " << x << ' ' << y;
          ASSERT_LE(error_all, error_rest) << "without " << mode.name << ", block at " << x << ' ' << y;
        }
      }
    }
  }
}

int most_difference(const Bytes& a, const Bytes& b) {
  int most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(Etc2, FlatColoursComeBack) {
  std::mt19937 random(3);
  int most = 0;
  for (int i = 0; i < 2000; ++i) {
    // Every third one has channels that 4 or 5 bits hold.
    const auto bits = random();
    const Image image(4, 4, [&](double, double, int c) {
      const int v = static_cast<int>(bits >> (8 * c) & 255);
      if (c == 3 || i % 3 == 0) return double(v);
      return i % 3 == 1 ? double(v / 17 * 17) : double((v & 0xf8) | v >> 5);
    });
    const Bytes decoded = through(image);
    ASSERT_EQ(squared_error(image.rgba, decoded, 3), 0u) << "alpha " << int{image.rgba[3]};
    const int difference = most_difference(image.rgba, decoded);
    ASSERT_LE(difference, 2) << i;
    most = std::max(most, difference);
  }
  std::printf("largest difference %d\n", most);
}

TEST(Etc2, RepresentableBlocksComeBackExactly) {
  // What decodes from random planar blocks has an error of 0 to be found.
  std::mt19937 random(11);
  int exact = 0, blocks = 0;
  for (int i = 0; i < 500; ++i) {
    const auto level = [&](int bits) {
      const int v = static_cast<int>(random() >> (32 - bits));
      return (v << (8 - bits) | v >> (2 * bits - 8)) & 255;
    };
    int corner[3][3];
    for (auto& c : corner) {
      c[0] = level(6);
      c[1] = level(7);
      c[2] = level(6);
    }
    const Image image(4, 4, [&](double x, double y, int c) {
      if (c == 3) return 77.0;
      const int o = corner[0][c], h = corner[1][c], v = corner[2][c];
      return double((static_cast<int>(x) * (h - o) + static_cast<int>(y) * (v - o) + 4 * o + 2) >> 2);
    });
    const Bytes decoded = through(image);
    ++blocks;
    exact += decoded == image.rgba ? 1 : 0;
    ASSERT_LE(most_difference(image.rgba, decoded), 3) << i;
  }
  std::printf("planes: %d of %d exact\n", exact, blocks);
  EXPECT_GT(exact, blocks * 9 / 10);
}

// Two colours far apart in turns, as no half along grey can hold them.
TEST(Etc2, TwoColoursNeedTOrH) {
  const Image image(64, 64, [](double x, double y, int c) {
    const bool odd = (int(x) * 7 + int(y) * 5 + int(x) * int(y)) % 3 == 0;
    const double a[4] = {221, 34, 51, 255}, b[4] = {17, 187, 204, 0};
    return odd ? a[c] : b[c];
  });
  Etc2Settings halves;
  halves.modes = kEtc2Individual | kEtc2Differential | kEtc2Planar;
  const double with = colour_psnr_db(image, through(image)),
               without = colour_psnr_db(image, through(image, halves));
  std::printf("two colours: %.2f dB, without T and H %.2f dB\n", with, without);
  EXPECT_GT(with, 60.0);
  EXPECT_LT(without, 20.0);
}

TEST(Etc2, WeightsMoveTheError) {
  const Image image = normals();
  Etc2Settings green;
  green.weights = {1, 6, 1};
  const Bytes plain = through(image), weighted = through(image, green);
  const std::size_t texels = image.rgba.size() / 4;
  for (std::size_t c = 0; c < 3; ++c) {
    std::printf("channel %zu: %.2f dB, with weights 1 6 1 %.2f dB\n", c,
                psnr_db(squared_error(image.rgba, plain, c), texels),
                psnr_db(squared_error(image.rgba, weighted, c), texels));
  }
  EXPECT_LT(squared_error(image.rgba, weighted, 1), squared_error(image.rgba, plain, 1));
  EXPECT_GT(squared_error(image.rgba, weighted, 0), squared_error(image.rgba, plain, 0));
  // Alpha is apart, and scaling all weights changes nothing.
  EXPECT_EQ(squared_error(image.rgba, weighted, 3), squared_error(image.rgba, plain, 3));
  Etc2Settings most;
  most.weights = {32, 32, 32};
  EXPECT_EQ(through(image, most), plain);
}

// A smaller image is the corner of one whose missing texels repeat the nearest.
TEST(Etc2, SmallImagesRepeatTheirBorder) {
  for (const std::uint32_t width : {1u, 2u, 3u, 5u}) {
    for (const std::uint32_t height : {1u, 2u, 6u}) {
      const auto value = [&](double x, double y, int c) {
        return 60 + 40 * c + 9 * std::min(x, width - 1.0) + 5 * std::min(y, height - 1.0);
      };
      const Image small(width, height, value);
      const Image whole((width + 3) & ~3u, (height + 3) & ~3u, value);
      EXPECT_EQ(encoded(small), encoded(whole)) << width << " x " << height;
    }
  }
}

TEST(Etc2, SaysWhatIsWrong) {
  const Bytes rgba(64);
  Bytes blocks(16);
  const auto field = [&](std::span<const std::uint8_t> image, std::uint32_t width, std::uint32_t height,
                         const Etc2Settings& settings) {
    const Status status = encode_etc2(image, width, height, blocks, settings);
    EXPECT_EQ(status.code() == StatusCode::ok, status.ok());
    return std::string(status.ok() ? "" : status.field());
  };
  EXPECT_EQ(field(rgba, 4, 4, {}), "");
  EXPECT_EQ(field(rgba, 0, 4, {}), "width");
  EXPECT_EQ(field(rgba, 4, kEtc2MostSide + 1, {}), "height");
  EXPECT_EQ(field(std::span(rgba).first(63), 4, 4, {}), "rgba");
  EXPECT_EQ(field(rgba, 2, 8, {}), "blocks");
  Etc2Settings settings;
  settings.weights = {0, 0, 0};
  EXPECT_EQ(field(rgba, 4, 4, settings), "weights");
  settings.weights = {1, 33, 1};
  EXPECT_EQ(field(rgba, 4, 4, settings), "weights");
  settings = {};
  settings.modes = 0;
  EXPECT_EQ(field(rgba, 4, 4, settings), "modes");
  settings.modes = 32;
  EXPECT_EQ(field(rgba, 4, 4, settings), "modes");
  Bytes out(60);
  EXPECT_STREQ(decode_etc2(blocks, 4, 4, out).field(), "rgba");
  out.resize(64);
  EXPECT_STREQ(decode_etc2(std::span(blocks).first(15), 4, 4, out).field(), "blocks");
}

// FNV-1a (Fowler, Noll, Vo) of the blocks: the same bits everywhere.
TEST(Etc2, GivesTheSameBitsEverywhere) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const Image& image : {white_noise(32), Image(30, 18, [](double x, double y, int c) {
                               return 7 * x + 3 * y + 31 * c + ((int(x) ^ int(y)) & 7);
                             })}) {
    for (const std::uint8_t byte : encoded(image)) hash = (hash ^ byte) * 0x100000001b3u;
  }
  EXPECT_EQ(hash, 10767302025220930045u);
}

}  // namespace
}  // namespace karst::bake
