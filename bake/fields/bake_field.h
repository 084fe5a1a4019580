// SPDX-License-Identifier: MIT
// From values on a grid, of a file, a shape or a sample, to a world that is an isosurface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/fields/field_grid.h"
#include "bake/materials/bake_materials.h"
#include "platform/base/error.h"
#include "terrain/file/world_file.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::bake {

// Distances to a shape, in metres, below 0 within: sphere, torus, gyroid, noise, or a sample's name
// (bake/samples). size: samples each way; spacing_m 0: 1, or so that the sample's content fits.
Error fill_shape(const std::string& shape, glm::ivec3 size, double spacing_m, int threads, FieldGrid& grid);

struct BakeField {
  std::string path;          // empty: none
  std::string shape;         // empty: none
  glm::ivec3 size{0};        // of a raw file or a shape
  std::string type;          // of a raw file
  double spacing_m = 0;      // 0: as the file says, or 1
  double iso = 0;            // where the surface is
  bool solid_above = false;  // what is solid: values above it, else below
  int sample_bits = 8;       // or 16
  double reach_cells = 2;    // how far from the surface samples tell distances
  // What samples are made of (field_materials_file.h); empty: all lies by the materials' rules.
  std::string materials_path;
  // The world's materials; with materials_path alone, procedural ones. None of both: one plain one.
  bool has_materials = false;
  MaterialOptions materials;
  int threads = 1;

  struct Report {
    core::WorldInfo info;
    core::FieldInfo field;
    glm::ivec3 size{0};
    double spacing_m = 0;
    double least = 0, most = 0;      // values
    std::uint64_t crossings = 0;     // edges between samples that the surface crosses
    std::uint64_t out_of_reach = 0;  // of them, with an end that is cut off: there the surface is moved
    std::uint32_t materials = 0;     // of the world
    double value_a_cell = 0;         // change of the value that stands for a cell's width
    std::vector<std::string> warnings;
  };

  // file: the bytes of the world file; nothing is written.
  Error run(Report& report, std::vector<std::byte>& file) const;
};

std::string field_report_text(const BakeField& job, const BakeField::Report& report, std::size_t bytes,
                              double seconds);
std::string field_report_json(const BakeField& job, const BakeField::Report& report, std::size_t bytes,
                              double seconds);

}  // namespace karst::bake
