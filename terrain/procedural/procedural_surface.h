// SPDX-License-Identifier: MIT
// Heights from noise and features: hills, mountains, dunes and rivers (S. Zaijer, "GPU Based Generation and
// Real-Time Rendering of Semi-Procedural Terrain Using Features", 2013, chapter 3). A height depends on its
// place alone, so grids of any place and size have the same bits where they share a vertex.
//
// Metres throughout: x to the east, z to the south, heights up.
#pragma once

#include <glm/vec2.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

inline constexpr int kMostOctaves = 12;

// A sum of octaves of simplex noise, each of half the wavelength of the one before and persistence times as
// strong; within base_m +- amplitude_m.
struct NoiseSum {
  double base_m = 0;
  double amplitude_m = 0;      // >= 0
  double wavelength_m = 1000;  // of the first octave, > 0
  double persistence = 0.5;    // > 0, <= 1
  int octaves = 6;             // 1..kMostOctaves
};

enum class FeatureKind : std::uint8_t { hill, mountain, dunes, river };

// Acts within radius_m of place_m; of a river within half its width and its valley.
struct Feature {
  FeatureKind kind = FeatureKind::hill;
  glm::dvec2 place_m{0};  // x and z
  double radius_m = 1;    // > 0
  double height_m = 0;    // of hills and mountains may be below 0
  double peakiness = 0;   // of a mountain: 0 a dome .. 1 a horn
  // Of dunes: from crest to crest, and where the wind blows to, a unit vector.
  double wavelength_m = 1;
  glm::dvec2 towards{1, 0};
  // Of a river, whose place and radius are a circle around all that it changes: its bed goes down to depth_m
  // below its level, and beside it the ground comes to its level over valley_m. Its pieces in
  // ProceduralSurface::pieces, one behind the other.
  double width_m = 0, depth_m = 0, valley_m = 0;  // > 0
  std::uint32_t first_piece = 0, pieces = 0;
};

// Of a river's middle, straight.
struct RiverPiece {
  glm::dvec2 from_m, to_m;
  float from_level_m, to_level_m;  // heights of the water
};

struct RiverPoint {
  glm::dvec2 place_m;
  double level_m;
};

// The uniform Catmull-Rom spline through points with its ends doubled (E. Catmull and R. Rom, "A class of
// local interpolating splines", 1974), as pieces that are off by tolerance_m at most; levels are straight
// from point to point. points: two or more. Returns how many pieces it has, and writes those that fit.
std::size_t river_pieces(std::span<const RiverPoint> points, double tolerance_m, std::span<RiverPiece> out);

// Features act in the order hills, mountains, dunes, rivers, those of a kind in theirs: order_features() has
// put them so. All spans outlive the surface.
struct ProceduralSurface {
  std::uint32_t seed = 0;
  NoiseSum noise;
  std::span<const Feature> features;
  std::span<const RiverPiece> pieces;
};
void order_features(std::span<Feature> features);

// Of a lattice with samples spacing_m apart, (0, 0) at the world's origin: every step-th sample from first
// on.
struct SampleRect {
  std::int64_t first_x = 0, first_z = 0;
  std::int64_t step = 1;
  int columns = 0, rows = 0;
  double spacing_m = 1;
};

// near: room for one more than the surface has pieces and twice its features together; what is in it does not
// matter. out: columns x rows, row by row. Preconditions: places less than 2^18 wavelengths from the origin.
void procedural_heights(const ProceduralSurface& surface, const SampleRect& rect,
                        std::span<std::uint32_t> near, std::span<float> out);

}  // namespace karst::core
