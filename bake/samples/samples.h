// SPDX-License-Identifier: MIT
// Procedural solids with overhangs, arches and caves. Deterministic to the bit: noise.h's hash is integer,
// and everything else is made of + - * / and sqrt, which IEEE 754 rounds exactly.
#pragma once

#include "bake/elevation/solid.h"

#include <memory>
#include <span>
#include <string_view>

namespace karst::bake {

struct SampleShape;

struct Sample {
  std::unique_ptr<Solid> solid;
  std::shared_ptr<const SampleShape> shape;  // that solid is made of
  Box content_m;                             // x and z: what is shown; y: the lowest and highest ground
  double voxel_m = 8;                        // that it is made for
  int level = 5;
};

struct SampleName {
  std::string_view name;
  std::string_view what;  // one clause, for --help
};
std::span<const SampleName> sample_names();

// solid is null for a name that is none of the above. The sample does not depend on threads.
Sample make_sample(std::string_view name, int threads);

}  // namespace karst::bake
