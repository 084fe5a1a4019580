// SPDX-License-Identifier: MIT
#include "bake/fields/field_materials_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string_view>

#include "bake/base/parallel.h"
#include "bake/base/print_text.h"
#include "bake/fields/field_file.h"
#include "bake/samples/noise.h"

namespace karst::bake {
using namespace core;
namespace {

std::string size_text(glm::ivec3 size) {
  std::string text;
  print(text, "%d x %d x %d", size.x, size.y, size.z);
  return text;
}

Error read(const FillMaterials& job, FieldGrid& grid) {
  ReadField read;
  read.path = job.path;
  std::ifstream file(job.path, std::ios::binary | std::ios::ate);
  if (!file) return job.path + ": it cannot be opened";
  const auto has = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  std::array<char, 4> head{};
  file.seekg(0);
  file.read(head.data(), head.size());
  if (std::string_view(head.data(), head.size()) != "NRRD") {
    const std::uint64_t wanted = static_cast<std::uint64_t>(job.size.x) *
                                 static_cast<std::uint64_t>(job.size.y) *
                                 static_cast<std::uint64_t>(job.size.z);
    if (has != wanted) {
      return job.path + ": it has " + std::to_string(has) + " bytes, and the field " + size_text(job.size) +
             " samples: a byte each is needed";
    }
    read.size = job.size;
    read.type = "uint8";
  }
  if (Error error = read.run(grid); !error.ok()) return error;
  if (grid.size == job.size) return {};
  return job.path + ": it has " + size_text(grid.size) + " samples, and the field " + size_text(job.size);
}

Error check(const FillMaterials& job, const FieldGrid& grid) {
  const auto count = static_cast<float>(job.materials->count);
  for (std::size_t n = 0; n < grid.values.size(); ++n) {
    const float value = grid.values[n];
    if (value >= 0 && value <= count && value == std::floor(value)) continue;
    const auto x = static_cast<std::size_t>(grid.size.x), y = static_cast<std::size_t>(grid.size.y);
    std::string text;
    print(text, ": sample %zu,%zu,%zu is %g, and there are %u materials, 1 to %u; 0 is by their rules", n % x,
          n / x % y, n / x / y, double{value}, job.materials->count, job.materials->count);
    return job.path + text;
  }
  return {};
}

// 1..count, of two layers that follow each other never the same where there are several.
unsigned material_of_layer(int layer, unsigned count) {
  const auto turn = [&](int n) { return hash_cell(0, n, 0, 5) % std::max(count - 1, 1u) + 1; };
  // Steps of 1 to count - 1 from one to the next.
  unsigned sum = 0;
  for (int n = 0; n <= layer; ++n) sum += turn(n);
  return sum % count + 1;
}

class Layers {
 public:
  Layers(glm::ivec3 size, unsigned count) : height_(std::max(4.0, size.y / 12.0)), warp_(1 / (4 * height_)) {
    for (std::size_t n = 0; n < material_.size(); ++n)
      material_[n] = static_cast<std::uint8_t>(material_of_layer(static_cast<int>(n), count));
  }
  // Over a cell, two are mixed.
  std::uint8_t code(glm::dvec3 at) const {
    const double h = at.y / height_ + 4 + fbm(at * warp_, 3, 11);
    const double border = std::floor(h + 0.5);
    const double above = std::clamp((h - border) * height_ + 0.5, 0.0, 1.0);
    const std::uint8_t low = layer(border - 1), high = layer(border);
    const int sevenths = static_cast<int>(std::floor(above * kMixShares + 0.5));
    if (low == high || sevenths == 0) return low;
    if (sevenths == kMixShares) return high;
    return low < high ? code_of({low, high, static_cast<std::uint8_t>(sevenths)})
                      : code_of({high, low, static_cast<std::uint8_t>(kMixShares - sevenths)});
  }

 private:
  std::uint8_t layer(double n) const {
    return material_[static_cast<std::size_t>(std::clamp(n, 0.0, static_cast<double>(material_.size() - 1)))];
  }
  double height_;
  double warp_;
  std::array<std::uint8_t, 24> material_{};
};

}  // namespace

Error FillMaterials::run(FieldBlocks& field) const {
  FieldGrid grid;
  const bool layers = path == kLayers;
  if (!layers) {
    if (Error error = read(*this, grid); !error.ok()) return error;
    if (Error error = check(*this, grid); !error.ok()) return error;
  }
  const Layers strata(size, std::max(materials->count, 1u));
  FieldMaterials& out = field.materials();
  const glm::ivec3 blocks = out.blocks();
  const auto count = static_cast<std::size_t>(blocks.x * blocks.y * blocks.z);
  const auto place = [&](std::size_t b) {
    const int n = static_cast<int>(b);
    return glm::ivec3(n % blocks.x, n / blocks.x % blocks.y, n / blocks.x / blocks.y);
  };
  // Slots are handed out in order; what is in them is made by all threads.
  for (std::size_t b = 0; b < count; ++b) static_cast<void>(out.open(place(b)));
  parallel_chunks(count, 8, threads, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t b = first; b < last; ++b) {
      const std::span<std::uint8_t> codes = out.open(place(b));
      for (int n = 0; n < static_cast<int>(codes.size()); ++n) {
        const glm::ivec3 at = glm::min(place(b) * 16 + glm::ivec3(n & 15, n >> 4 & 15, n >> 8), size - 1);
        codes[static_cast<std::size_t>(n)] =
            layers ? strata.code(glm::dvec3(at)) : static_cast<std::uint8_t>(grid.at(at.x, at.y, at.z));
      }
    }
  });
  for (std::size_t b = 0; b < count; ++b) out.close(place(b));
  return {};
}

}  // namespace karst::bake
