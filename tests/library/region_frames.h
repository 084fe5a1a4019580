// SPDX-License-Identifier: MIT
// Frames over magenta of a ground with regions: from inside of caves, across sides and from above, with what
// is missing while vertices are made and where memory is short. Whatever is missing, no pixel shows magenta.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "tests/library/host.h"

namespace karst::test {

// Metres, in the world's axes.
struct RegionSite {
  glm::dvec3 corner{0.0};
  glm::dvec3 size{0.0};
  glm::dvec3 chamber{0.0};  // of its cave, from which a shaft goes up to the east
};

struct RegionScene {
  std::span<const RegionSite> sites;
  double (*ground_height)(double x, double z) = nullptr;
  double lowest = 0, highest = 0;    // of it
  double low[2] = {}, high[2] = {};  // x and z that the ground reaches
};

struct Look {
  glm::dvec3 eye{0.0}, target{0.0};
  double fov = 60;
};

class RegionHostTest : public HostTest {
 protected:
  static constexpr int kWidth = 160;
  static constexpr int kHeight = 120;

  RegionHostTest() : HostTest(kWidth, kHeight) {}

  ViewState view(glm::dvec3 eye, glm::dvec3 target, double fov = 60) const;
  // Frames of the scene, shaded both ways, with each of these Needs::vertex_bytes; KARST_FRAMES sets how many
  // in all.
  void look_for_holes(const std::vector<std::byte>& file, const RegionScene& scene,
                      std::span<const std::uint64_t> vertex_bytes, unsigned seed, int frames);

  // The next of a sequence: by turns in a chamber, over a side, above.
  Look random_look(const RegionScene& scene, int kind, std::mt19937& random) const;

 private:
  // That no corner of the picture looks beyond the ground.
  bool ends_on_ground(const RegionScene& scene, const Look& look) const;
};

}  // namespace karst::test
