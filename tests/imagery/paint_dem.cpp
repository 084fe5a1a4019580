// SPDX-License-Identifier: MIT
// Makes a picture of a DEM as if seen from above, for tests and documentation: woods, grass, rock and snow by
// height and slope, fields where it is level, a road every few kilometres, and noise at all scales.
//
//   karst-paint-dem DEM OUT.tif PIXELS [--crop X,Z,W,H] [--plain]
//
// PIXELS of the picture lie along a sample of the DEM; both have the same place. --crop: samples of the DEM.
// --plain: a checker of samples, 16 of them a square, red and blue rising to the east and south instead.
#include <cpl_string.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

namespace {

double hashed(std::int64_t x, std::int64_t y) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u + static_cast<std::uint64_t>(y);
  h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 29)) * 0x94d049bb133111ebu;
  return static_cast<double>(h >> 40) * 0x1p-24;
}

double noise(double x, double y) {
  const double fx = std::floor(x), fy = std::floor(y);
  const double u = x - fx, v = y - fy;
  const double s = u * u * (3 - 2 * u), t = v * v * (3 - 2 * v);
  const auto at = [&](int i, int k) {
    return hashed(static_cast<std::int64_t>(fx) + i, static_cast<std::int64_t>(fy) + k);
  };
  return std::lerp(std::lerp(at(0, 0), at(1, 0), s), std::lerp(at(0, 1), at(1, 1), s), t);
}

using Colour = std::array<double, 3>;

Colour mixed(const Colour& a, const Colour& b, double t) {
  t = std::clamp(t, 0.0, 1.0);
  return {std::lerp(a[0], b[0], t), std::lerp(a[1], b[1], t), std::lerp(a[2], b[2], t)};
}

struct Dem {
  int width = 0, height = 0;
  double low = 0, high = 0;
  std::vector<float> heights;

  double at(double column, double row) const {
    const double x = std::clamp(column, 0.0, width - 1.0), y = std::clamp(row, 0.0, height - 1.0);
    const int i = std::min(static_cast<int>(x), width - 2), k = std::min(static_cast<int>(y), height - 2);
    const auto h = [&](int di, int dk) {
      return double{heights[static_cast<std::size_t>(k + dk) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(i + di)]};
    };
    return std::lerp(std::lerp(h(0, 0), h(1, 0), x - i), std::lerp(h(0, 1), h(1, 1), x - i), y - k);
  }
};

// At a place in samples; spacing: metres of one.
Colour colour_at(const Dem& dem, double column, double row, double spacing) {
  const double height = dem.at(column, row);
  const double east = (dem.at(column + 1, row) - dem.at(column - 1, row)) / (2 * spacing);
  const double south = (dem.at(column, row + 1) - dem.at(column, row - 1)) / (2 * spacing);
  const double slope = std::hypot(east, south);
  const double share = (height - dem.low) / std::max(dem.high - dem.low, 1.0);
  const double patches = 0.6 * noise(column / 9, row / 9) + 0.4 * noise(column / 2.3, row / 2.3);
  const double trees = noise(column * 4, row * 4) * noise(column * 9 + 31, row * 9);
  const double grain = noise(column * 23, row * 23);
  const Colour wood = mixed({38, 62, 30}, {72, 96, 48}, 1.6 * trees);
  const Colour grass = mixed({126, 128, 70}, {160, 148, 92}, patches);
  const Colour rock = mixed({122, 112, 102}, {166, 156, 142}, grain);
  Colour result = mixed(grass, wood, 5 * (patches - 0.45) + 3 * south);
  result = mixed(result, rock, 4 * (slope - 0.55) + 1.5 * (share - 0.8));
  result = mixed(result, {236, 238, 242}, 9 * (share - 0.88) + patches - 0.5);
  if (slope < 0.12 && share < 0.4) {
    // Fields, 5 samples by 3, each of one crop in rows.
    const double crop = hashed(static_cast<std::int64_t>(column / 5), static_cast<std::int64_t>(row / 3));
    const double furrow = std::fmod(column * 6 + row * 2, 1.0) < 0.5 ? 1.0 : 0.93;
    Colour field = mixed({150, 140, 70}, {86, 124, 52}, crop);
    for (double& c : field) c *= furrow;
    const bool hedge = std::fmod(column, 5) < 0.12 || std::fmod(row, 3) < 0.12;
    result = mixed(result, hedge ? Colour{50, 74, 38} : field, 12 * (0.12 - slope));
  }
  const double road = std::abs(std::fmod(row + 7 * noise(column / 40, 3.0), 90.0) - 45.0);
  if (road < 0.22) result = {176, 172, 166};
  // As dark as ground is seen from above.
  for (double& c : result) c *= 0.72 * (0.9 + 0.2 * grain);
  return result;
}

Colour plain_at(const Dem& dem, double column, double row) {
  const auto square = [](double at) { return static_cast<int>(std::floor(at / 16)) & 1; };
  const double green = square(column) != square(row) ? 200 : 60;
  return {40 + 180 * column / dem.width, green, 40 + 180 * row / dem.height};
}

int fail(const char* what) {
  std::fprintf(stderr, "karst-paint-dem: %s\n", what);
  return 1;
}

}  // namespace

int main(int count, char** words) {
  if (count < 4) return fail("DEM OUT.tif PIXELS [--crop X,Z,W,H] [--plain]");
  GDALAllRegister();
  const int times = std::atoi(words[3]);
  bool plain = false;
  int crop[4] = {};
  for (int n = 4; n < count; ++n) {
    plain = plain || std::strcmp(words[n], "--plain") == 0;
    if (std::strcmp(words[n], "--crop") != 0 || n + 1 == count) continue;
    if (std::sscanf(words[n + 1], "%d,%d,%d,%d", &crop[0], &crop[1], &crop[2], &crop[3]) != 4)
      return fail("--crop: four whole numbers");
  }
  auto* const from = GDALDataset::FromHandle(GDALOpen(words[1], GA_ReadOnly));
  if (from == nullptr || times < 1) return fail("the DEM cannot be read, or PIXELS is no number");
  Dem dem;
  dem.width = from->GetRasterXSize();
  dem.height = from->GetRasterYSize();
  dem.heights.resize(static_cast<std::size_t>(dem.width) * static_cast<std::size_t>(dem.height));
  if (from->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, dem.width, dem.height, dem.heights.data(), dem.width,
                                       dem.height, GDT_Float32, 0, 0) != CE_None)
    return fail("the DEM cannot be read");
  for (float& h : dem.heights) h = h <= -9000.0f || h >= 9000.0f ? 0.0f : h;
  dem.low = double{*std::min_element(dem.heights.begin(), dem.heights.end())};
  dem.high = double{*std::max_element(dem.heights.begin(), dem.heights.end())};
  double place[6] = {0, 1, 0, 0, 0, -1};
  const bool placed = from->GetGeoTransform(place) == CE_None;
  const double spacing = std::abs(place[1]) < 0.1 ? 90.0 : std::abs(place[1]);
  if (crop[2] == 0) {
    crop[2] = dem.width;
    crop[3] = dem.height;
  }
  place[0] += crop[0] * place[1];
  place[3] += crop[1] * place[5];
  place[1] /= times;
  place[5] /= times;
  const int width = crop[2] * times, height = crop[3] * times;
  char** options = nullptr;
  options = CSLSetNameValue(options, "TILED", "YES");
  options = CSLSetNameValue(options, "COMPRESS", "DEFLATE");
  options = CSLSetNameValue(options, "PREDICTOR", "2");
  options = CSLSetNameValue(options, "ZLEVEL", "1");
  options = CSLSetNameValue(options, "BIGTIFF", "IF_SAFER");
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALDataset* const to = driver->Create(words[2], width, height, 3, GDT_Byte, options);
  CSLDestroy(options);
  if (to == nullptr) return fail("the picture cannot be written");
  if (placed) to->SetGeoTransform(place);
  if (from->GetSpatialRef() != nullptr) to->SetSpatialRef(from->GetSpatialRef());
  std::vector<std::uint8_t> row(static_cast<std::size_t>(width) * 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // The middle of a sample is at a whole number.
      const double column = crop[0] + (x + 0.5) / times - 0.5, line = crop[1] + (y + 0.5) / times - 0.5;
      const Colour c =
          plain ? plain_at(dem, column + 0.5, line + 0.5) : colour_at(dem, column, line, spacing);
      for (std::size_t k = 0; k < 3; ++k)
        row[static_cast<std::size_t>(x) * 3 + k] =
            static_cast<std::uint8_t>(std::clamp(c[k] + 0.5, 0.0, 255.0));
    }
    int bands[3] = {1, 2, 3};
    if (to->RasterIO(GF_Write, 0, y, width, 1, row.data(), width, 1, GDT_Byte, 3, bands, 3,
                     3 * GSpacing{width}, 1) != CE_None)
      return fail("the picture cannot be written");
  }
  GDALClose(to);
  GDALClose(from);
  return 0;
}
