// SPDX-License-Identifier: MIT
// Writes what the layers look like into the current folder: for OGRE NAME_diffuse_specular.png and
// NAME_normal_height.png; for karst, the same texels, NAME_albedo.png, NAME_normal.png, NAME_height.png and
// layers.json. gen_layers SIDE: texels a side. Prints how much of the scene each layer covers.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <png.h>
#include <terrain_noise.h>

#include "tests/bench/peers/layers.h"
using namespace peer;

namespace {

using Bytes = std::vector<std::uint8_t>;

void write_png(const std::string& path, int side, int channels, const Bytes& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = static_cast<png_uint_32>(side);
  image.format = channels == 1 ? PNG_FORMAT_GRAY : channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  if (png_image_write_to_file(&image, path.c_str(), 0, bytes.data(), 0, nullptr) == 0) {
    std::fprintf(stderr, "gen_layers: cannot write %s\n", path.c_str());
    std::exit(1);
  }
}

// Gradient noise that repeats after so many cells.
double tile_noise(double x, double y, int cells_x, int cells_y, int seed) {
  const double fx = std::floor(x), fy = std::floor(y), a = x - fx, b = y - fy;
  const auto at = [&](int dx, int dy) {
    const int ix = (static_cast<int>(fx) + dx) % cells_x, iy = (static_cast<int>(fy) + dy) % cells_y;
    return grad2(ix + seed * 7919, iy + seed * 104729, a - dx, b - dy);
  };
  const double u = a * a * a * (a * (a * 6 - 15) + 10), v = b * b * b * (b * (b * 6 - 15) + 10);
  const double top = at(0, 0) + u * (at(1, 0) - at(0, 0)), bottom = at(0, 1) + u * (at(1, 1) - at(0, 1));
  return top + v * (bottom - top);
}

// 0..1, five octaves stretched to all of it.
std::vector<double> bumps(const Layer& layer, int side, int seed) {
  std::vector<double> height(static_cast<std::size_t>(side) * side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      double sum = 0, share = 1;
      int across = layer.cells, down = layer.cells * layer.stretch;
      for (int octave = 0; octave < 5; ++octave, share *= 0.6, across *= 2, down *= 2) {
        sum += share * tile_noise((x + 0.5) * across / side, (y + 0.5) * down / side, across, down, seed);
      }
      height[static_cast<std::size_t>(y) * side + x] = sum;
    }
  }
  const auto [low, high] = std::minmax_element(height.begin(), height.end());
  const double from = *low, span = *high - *low;
  for (double& h : height) h = (h - from) / span;
  return height;
}

std::uint8_t byte(double v) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 1.0) * 255));
}

void write_layer(const Layer& layer, int side, int seed) {
  const std::vector<double> height = bumps(layer, side, seed);
  const auto at = [&](int x, int y) {
    return height[static_cast<std::size_t>((y + side) % side) * side + (x + side) % side];
  };
  Bytes diffuse_specular, normal_height, albedo, normal, grey;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double h = at(x, y);
      for (int c = 0; c < 3; ++c) {
        albedo.push_back(byte((layer.dark[c] + (layer.bright[c] - layer.dark[c]) * h) / 255));
      }
      // Green is up, against y. Slopes are in repeats.
      const double nx = (at(x - 1, y) - at(x + 1, y)) * layer.bump * side / 2;
      const double ny = (at(x, y + 1) - at(x, y - 1)) * layer.bump * side / 2;
      const double length = std::sqrt(nx * nx + ny * ny + 1);
      for (const double v : {nx, ny, 1.0}) normal.push_back(byte(v / length * 0.5 + 0.5));
      grey.push_back(byte(h));
      diffuse_specular.insert(diffuse_specular.end(), albedo.end() - 3, albedo.end());
      diffuse_specular.push_back(byte(layer.specular));
      normal_height.insert(normal_height.end(), normal.end() - 3, normal.end());
      normal_height.push_back(byte(h));
    }
  }
  const std::string name = layer.name;
  write_png(name + "_diffuse_specular.png", side, 4, diffuse_specular);
  write_png(name + "_normal_height.png", side, 4, normal_height);
  write_png(name + "_albedo.png", side, 3, albedo);
  write_png(name + "_normal.png", side, 3, normal);
  write_png(name + "_height.png", side, 1, grey);
}

std::string limit(double v) {
  return std::fabs(v) < kNone ? std::to_string(v) : "null";
}

void write_json(int side) {
  std::FILE* file = std::fopen("layers.json", "w");
  if (file == nullptr) std::exit(1);
  std::fprintf(file, "{\"side\": %d, \"lights\": [], \"materials\": [", side);
  for (const Layer& layer : kLayer) {
    const char* n = layer.name;
    std::fprintf(file, "%s\n  {\"name\": \"%s\", \"albedo\": \"%s_albedo.png\",", &layer == kLayer ? "" : ",",
                 n, n);
    std::fprintf(file, " \"normal\": \"%s_normal.png\", \"height\": \"%s_height.png\",", n, n);
    std::fprintf(file, " \"roughness\": %g, \"slope\": [%s, %s], \"slope_soft\": %g,", layer.roughness,
                 limit(layer.slope_low).c_str(), limit(layer.slope_high).c_str(), kSlopeSoft);
    std::fprintf(file, " \"elevation\": [%s, %s], \"elevation_soft\": %g}", limit(layer.height_low).c_str(),
                 limit(layer.height_high).c_str(), kHeightSoft);
  }
  std::fprintf(file, "]}\n");
  std::fclose(file);
}

}  // namespace

int main(int argc, char** argv) {
  const int side = argc > 1 ? std::atoi(argv[1]) : 256;
  if (side < 16 || side > 1024) return 2;
  for (int n = 0; n < kLayers; ++n) write_layer(kLayer[n], side, n + 1);
  write_json(side);
  const Heightmap map = load_heightmap();
  double share[kLayers] = {};
  for (int j = 0; j < kN; ++j) {
    for (int i = 0; i < kN; ++i) {
      const double slope = normal_y(map, i, j), height = map.h(i, j);
      double rest = 1;
      for (int n = kLayers - 1; n >= 0; --n) {
        const double c = n == 0 ? 1 : cover(kLayer[n], slope, height);
        share[n] += rest * c;
        rest *= 1 - c;
      }
    }
  }
  for (int n = 0; n < kLayers; ++n) std::printf("%s %.1f %%\n", kLayer[n].name, 100 * share[n] / (kN * kN));
}
