// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite shading`: what each part of shading costs a pixel, and what leaving out what a
// scene does not need saves; and how far the pictures differ.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/options/scene_options.h"
#include "platform/base/error.h"
#include "terrain/world/world.h"

namespace karst::bench {
using namespace app;

struct ShadingSuiteOptions {
  std::string world;
  SceneArguments look;  // vertex_bytes 0: everything stays resident
  int frames = 1;       // of each of three flights: low, oblique, high
  int rounds = 3;       // medians are over these
  std::string against;  // the same world baked another way, to be compared with; empty: none
  std::string json;     // file; "-": printed in place of the table; empty: none
};

// A frame's, mean of all views.
struct ShadingTime {
  double frame_ms = 0;  // from its beginning to its end
  double cpu_ms = 0;    // of all threads, a software driver's included: less moved by what else runs

  void add(const ShadingTime& other, double times) {
    frame_ms += times * other.frame_ms;
    cpu_ms += times * other.cpu_ms;
  }
};

// Two ways to draw the same pictures, which took turns.
struct ShadingComparison {
  std::string name;
  std::string on, off;                             // what each way is, in a word or two
  ShadingTime on_time, off_time;                   // medians of the rounds
  ShadingTime ratio;                               // on / off, medians of the rounds
  int most_difference = 0;                         // of any colour of any pixel, 0..255
  double mean_difference = 0;                      // of all colours of all pixels
  std::vector<ShadingTime> on_rounds, off_rounds;  // what the medians are of
};

// Texture data of two worlds with the same materials.
struct TextureComparison {
  bool made = false;  // false: there is no other world
  const char* on = "";
  const char* off = "";  // formats
  std::uint64_t on_bytes = 0, off_bytes = 0;
  // PSNR of the finest level, all layers, the peak being 1; infinite where they are the same.
  double albedo_db = 0, roughness_db = 0;  // of what is stored
  double brightness_db = 0, height_db = 0, slope_db = 0;
};

struct ShadingReport {
  int width = 0, height = 0, views = 0, rounds = 0;
  std::string renderer;                     // GL_RENDERER
  std::vector<ShadingComparison> skips;     // each alone, the last all together
  std::vector<ShadingComparison> flights;   // all together, by flight
  std::vector<ShadingComparison> features;  // what a picture has or is drawn with
  TextureComparison textures;
};

void print_shading(const ShadingReport& report);
std::string shading_json(const ShadingReport& report);

// Textures of both, which must have as many materials of the same size.
Error compare_textures(const core::World& on, const core::World& off, TextureComparison& result);

// Returns the exit code; errors go to stderr.
int run_shading_suite(const ShadingSuiteOptions& options);

}  // namespace karst::bench
