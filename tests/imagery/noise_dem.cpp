// SPDX-License-Identifier: MIT
// Makes an elevation of any size, for measuring what large ones take: ranges of hills over seven octaves, in
// whole metres, as an ENVI file at 30 m in UTM.
//
//   karst-noise-dem OUT.raw SIDE
//
// SIDE: samples along and down, 2..65536. OUT.raw has two bytes each; OUT.hdr lies beside it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

constexpr int kOctaves = 7;
constexpr int kCoarsest = 4096;  // samples between values of the first octave
constexpr float kRelief = 1'400;

float hashed(int x, int y) {
  std::uint64_t h = static_cast<std::uint32_t>(x) * 0x9e3779b97f4a7c15u + static_cast<std::uint32_t>(y);
  h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 29)) * 0x94d049bb133111ebu;
  return static_cast<float>(h >> 40) * 0x1p-24f;
}

// Adds an octave to a row of heights: values a spacing apart, smooth between them.
void add_octave(int row, int spacing, float height, std::vector<float>& heights) {
  const int k = row / spacing;
  const float v = static_cast<float>(row % spacing) / static_cast<float>(spacing);
  const float t = v * v * (3 - 2 * v);
  const int side = static_cast<int>(heights.size());
  const auto value = [&](int i) { return std::lerp(hashed(i, k), hashed(i, k + 1), t); };
  float left = value(0);
  for (int first = 0; first < side; first += spacing) {
    const float right = value(first / spacing + 1);
    for (int x = first; x < std::min(first + spacing, side); ++x) {
      const float u = static_cast<float>(x - first) / static_cast<float>(spacing);
      heights[static_cast<std::size_t>(x)] += height * (left + (right - left) * u * u * (3 - 2 * u));
    }
    left = right;
  }
}

}  // namespace

int main(int count, char** words) {
  const int side = count == 3 ? std::atoi(words[2]) : 0;
  if (side < 2 || side > 65'536) {
    std::fprintf(stderr, "karst-noise-dem: OUT.raw SIDE, of 2 to 65536 samples\n");
    return 2;
  }
  const std::string path = words[1];
  const std::string head = path.substr(0, path.rfind('.')) + ".hdr";
  std::FILE* const text = std::fopen(head.c_str(), "w");
  std::FILE* const raw = std::fopen(path.c_str(), "w");
  bool written = text != nullptr && raw != nullptr;
  if (written) {
    written = std::fprintf(text,
                           "ENVI\nsamples = %d\nlines = %d\nbands = 1\nheader offset = 0\n"
                           "file type = ENVI Standard\ndata type = 2\ninterleave = bsq\nbyte order = 0\n"
                           "map info = {UTM, 1, 1, 300000, 4600000, 30, 30, 11, North, WGS-84}\n",
                           side, side) > 0;
  }
  std::vector<float> heights(static_cast<std::size_t>(side));
  std::vector<std::int16_t> samples(heights.size());
  for (int row = 0; row < side && written; ++row) {
    std::fill(heights.begin(), heights.end(), 0.0f);
    float height = kRelief;
    int spacing = kCoarsest;
    for (int octave = 0; octave < kOctaves; ++octave, spacing /= 3, height *= 0.42f)
      add_octave(row, spacing, height, heights);
    for (std::size_t x = 0; x < samples.size(); ++x)
      samples[x] = static_cast<std::int16_t>(std::lround(heights[x]));
    written = std::fwrite(samples.data(), 2, samples.size(), raw) == samples.size();
  }
  for (std::FILE* file : {text, raw}) written = file != nullptr && std::fclose(file) == 0 && written;
  if (written) return 0;
  std::fprintf(stderr, "karst-noise-dem: %s cannot be written\n", path.c_str());
  return 1;
}
