// SPDX-License-Identifier: MIT
// The golden pictures: worlds, cameras, and how far a picture may be from the stored one. golden_test.cpp
// bakes and draws them here, karst-device (tests/device) draws them on other machines.
#pragma once

#include <string>
#include <vector>

#include "tests/golden/picture.h"

namespace karst::test {

using Words = std::vector<std::string>;

// On other drivers than the pinned one; see README.md.
inline constexpr double kMostMean = 3.0;
inline constexpr double kMostFarApart = 0.02;

inline bool close_enough(const Difference& difference) {
  return difference.mean <= kMostMean && difference.far_apart <= kMostFarApart;
}

inline constexpr int kGoldenWidth = 320;  // pixels
inline constexpr int kGoldenHeight = 180;

struct GoldenView {
  const char* picture;  // images/PICTURE.png
  Words camera;         // options of karst render
};

struct GoldenWorld {
  const char* name;
  Words bake;  // arguments of karst-bake
  std::vector<GoldenView> views;
};

// Level 3: a sixteenth of the samples' vertices, and no difference to be seen at this size.
inline const GoldenWorld kGoldenWorlds[] = {
    {"canyon",
     {"--sample", "canyon", "--levels", "3"},
     {{"canyon", {}}, {"canyon_near", {"--camera", "60,70,60,85,5", "--sun", "200,30"}}}},
    {"caves",
     {"--sample", "caves", "--no-ground", "--levels", "3"},
     {{"caves", {}},
      {"caves_hall", {"--camera", "-90,50,-10,-20,-6"}},
      {"caves_mouth", {"--camera", "-45,30,210,0,5"}}}},
    {"arches",
     {"--sample", "arches", "--no-ground", "--levels", "3"},
     {{"arches", {}}, {"arches_near", {"--camera", "20,25,60,35,5", "--sun", "260,25"}}}},
    {"hills", {"--sample", "hills", "--levels", "3"}, {{"hills", {}}, {"hills_dusk", {"--sun", "285,4"}}}},
    {"lake",
     {"--sample", "hills", "--no-ground", "--levels", "3", "--water", "45"},
     {{"lake", {}},
      {"lake_night", {"--sun", "285,-30"}},
      {"lake_shore", {"--camera", "-30,49,60,150,-8", "--sun", "200,30"}}}},
    {"strata",
     {"--field-shape", "gyroid", "--field-size", "65,65,65", "--field-materials", "layers"},
     {{"strata", {"--camera", "8,32,20,25,-8", "--sun", "150,50"}}}},
    {"bigtujunga",
     {KARST_DATA_DIR "/bigtujunga.tif", "--voxel", "256", "--levels", "3"},
     {{"bigtujunga", {}}, {"bigtujunga_near", {"--camera", "-4000,2600,6000,30,-14"}}}},
};

// What karst render draws a golden picture with. Anisotropic lookups are not alike on all devices.
inline Words golden_words(const std::string& world, const GoldenView& view, const std::string& picture) {
  Words words{"render", world, "-o", picture, "--error-px", "1", "--anisotropy", "1", "--size"};
  words.push_back(std::to_string(kGoldenWidth) + "x" + std::to_string(kGoldenHeight));
  words.insert(words.end(), view.camera.begin(), view.camera.end());
  return words;
}

}  // namespace karst::test
