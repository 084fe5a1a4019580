// SPDX-License-Identifier: MIT
// Shapes that fill or empty parts of a solid, read from JSON (docs/formats.md, "carve JSON"). They are
// applied in the order of the file, to the voxels and to the solid that heights are fitted to alike.
#pragma once

#include "bake/elevation/solid.h"
#include "platform/base/error.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace karst::bake {

struct CarveShape {
  enum class Kind : std::uint8_t { box, sphere, capsule };
  static constexpr std::size_t kMostShapes = 10'000;
  static constexpr std::size_t kMostPoints = 100'000;  // of all capsules together
  static constexpr double kFarthestM = 1e9;            // |coordinate|
  static constexpr double kMaxRadiusM = 1e6;

  Kind kind = Kind::sphere;
  bool fill = false;                   // else empty
  glm::dvec3 centre_m{0.0};            // box, sphere
  glm::dvec3 half_m{0.0};              // box: half of its size
  double radius_m = 0;                 // sphere, capsule; box: of its edges
  double blend_m = 0;                  // width over which the shape and what was there flow into each other
  std::vector<glm::dvec3> points_m{};  // capsule: a tunnel along straight lines between these

  // Of the shape itself, without its blend.
  Box bounds() const;
};

// text: the JSON; name: the file, for messages. The error names file, shape and field.
Error parse_carve(std::string_view text, const std::string& name, std::vector<CarveShape>& shapes);
// Reads at most 16 MiB.
Error read_carve(const std::string& path, std::vector<CarveShape>& shapes);

// A solid with shapes applied. Shapes are looked up in a grid of columns: far from all of them the value is
// the base's.
class CarvedSolid final : public Solid {
 public:
  // base and shapes outlive the solid. build() comes before all else.
  CarvedSolid(const Solid& base, const std::vector<CarveShape>& shapes, const WorldGrid& grid);
  // An error where the shapes reach more columns of voxels together than are sensible, or than `allowed` and
  // what is free, 2^17 and 4 shapes a column of the world.
  Error build(std::size_t allowed = 0);
  double value_m(glm::dvec3 position_m) const override;

  // Whether a shape is within reach somewhere in the column of voxels that holds the place.
  bool touches(double x_m, double z_m) const { return !column(x_m, z_m).empty(); }

 private:
  struct Piece {  // a shape, or one segment of a capsule
    std::uint32_t shape;
    std::uint32_t segment;
  };
  struct Columns {  // that a piece reaches, both ends included
    int first_x = 0, last_x = -1, first_z = 0, last_z = -1;

    std::size_t count() const {
      const auto wide = [](int from, int to) { return static_cast<std::size_t>(std::max(to - from + 1, 0)); };
      return wide(first_x, last_x) * wide(first_z, last_z);
    }
  };
  const std::vector<Piece>& column(double x_m, double z_m) const;
  template <class Visit>
  bool each_piece(const Visit& visit) const;
  Columns columns_of(Piece piece, const Box& bounds) const;
  double distance_m(Piece piece, glm::dvec3 p) const;

  const Solid& base_;
  const std::vector<CarveShape>& shapes_;
  WorldGrid grid_;
  std::vector<std::vector<Piece>> columns_;  // index z * extent.x + x; in the order of shapes
};

}  // namespace karst::bake
