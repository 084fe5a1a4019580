// SPDX-License-Identifier: MIT
// What a ground lies on: from where elevation lies on the earth to a basis and a georeference, and elevation
// of a whole planet as the grid of a cube.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bake/ground/ground_rows.h"
#include "bake/pipeline/bake.h"
#include "terrain/basis/georeference.h"
#include "terrain/ground/ground.h"

namespace karst::bake {

// Of a plane: where its frame's origin lies, the middle of the samples. None where the files do not say it.
Georeference plane_earth(const Elevation& facts, int width, int height);

// Fills samples and, but for heights' unit and finish(), the basis; spacing_m: the most from one sample to
// the next at height 0. What goes once around closes: samples have one more column then, which is the first
// one. The error, one line, is of elevation that such a basis cannot have.
Error choose_basis(const Bake& job, const Elevation& facts, int width, int height, GroundInfo& info,
                   double (&spacing_m)[2]);

// Rows of the grid of a cube, sampled from elevation by longitude and latitude: linear between samples.
class CubeRows {
 public:
  // Quads along an edge of a face, so that no sample of the elevation is left out.
  static Error face_quads(const Elevation& facts, int width, int height, const std::string& path,
                          std::int32_t& quads);

  // Reads all. rows outlives nothing here. basis: finished, its heights' unit any.
  Error open(GroundRows& rows, const Basis& basis);
  // As GroundRows.
  void run(const GroundRows::Take& take) const;

 private:
  float at(const Elevation& facts, int width, int height, std::span<const float> all, double longitude_deg,
           double latitude_deg) const;

  std::int64_t quads_ = 0;
  std::vector<float> faces_;  // (quads + 1)^2 each
};

}  // namespace karst::bake
