// SPDX-License-Identifier: MIT
// Fields of shapes for tests, filled block by block.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "terrain/isosurface/field_blocks.h"

namespace karst::test {
using namespace core;

// Samples' distance from the surface, below 0 in what is solid; about 1 long at the surface.
using FieldShape = std::function<double(glm::dvec3 sample)>;

inline constexpr double kFieldSteps = 64;  // a sample: eight bits reach two samples far

// All blocks of a field that was reset.
inline void fill_field(FieldBlocks& field, const FieldShape& shape) {
  const glm::ivec3 n = field.info().blocks;
  for (int z = 0; z < n.z; ++z) {
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x) {
        const glm::ivec3 block(x, y, z);
        const std::span<std::int8_t> out = field.bytes().open(block);
        ASSERT_FALSE(out.empty());
        for (int s = 0; s < static_cast<int>(out.size()); ++s) {
          const glm::ivec3 inside(s & 15, s >> 4 & 15, s >> 8);
          const double v = std::floor(kFieldSteps * shape(glm::dvec3(block * 16 + inside)));
          out[static_cast<std::size_t>(s)] = static_cast<std::int8_t>(std::clamp(v, -128.0, 127.0));
        }
        field.bytes().close(block);
      }
    }
  }
}

inline FieldInfo field_info(glm::ivec3 blocks, std::uint32_t stored) {
  FieldInfo info;
  info.blocks = blocks;
  info.stored = stored;
  return info;
}

inline FieldShape ball(glm::dvec3 centre, double radius) {
  return [=](glm::dvec3 p) { return glm::length(p - centre) - radius; };
}

// Rock around channels of a gyroid's, of this wavelength, within a ball.
inline FieldShape gyroid_cave(glm::dvec3 centre, double radius, double wave) {
  return [=](glm::dvec3 p) {
    const glm::dvec3 q = (p - centre) * (6.283185307179586 / wave);
    const double g =
        std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
    const double channel = g * wave / 6.283185307179586 / 1.5;
    return std::min(-channel, radius - glm::length(p - centre));
  };
}

}  // namespace karst::test
