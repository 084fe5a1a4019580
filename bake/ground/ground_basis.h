// SPDX-License-Identifier: MIT
// What a ground lies on: from where elevation lies on the earth to a basis and a georeference, and elevation
// of a whole planet as the grid of a cube.
#pragma once

#include <cstdint>
#include <string>

#include "bake/base/scratch_grid.h"
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
  // Quads along an edge of a face, so that no sample of the elevation is left out, up to the most that there
  // may be.
  static Error face_quads(const Elevation& facts, int width, int height, const std::string& path,
                          std::int32_t& quads);

  int threads = 1;
  // Elevation, and faces, of more bytes lie in files in the folder while they are needed.
  std::uint64_t held_bytes = 400u << 20;
  std::string folder = ".";

  // Reads all. rows outlives nothing here. basis: finished, its heights' unit any. progress: of rows of all
  // faces; may be empty.
  Error open(GroundRows& rows, const Basis& basis, const ReportProgress& progress);
  // As GroundRows.
  void run(const GroundRows::Take& take) const;
  bool is_in_file() const { return faces_.is_file(); }

 private:
  // Of an elevation: where it lies, and its samples.
  struct Source {
    ElevationEarth earth;
    int width = 0, height = 0;
    ScratchGrid samples;

    float at(double longitude_deg, double latitude_deg) const;
  };
  void fill_row(const Source& source, const Basis& basis, int face, std::int64_t k);

  std::int64_t quads_ = 0;
  ScratchGrid faces_;  // one below the other, (quads + 1)^2 each
};

}  // namespace karst::bake
