// SPDX-License-Identifier: MIT
// What frames cost and drew, summarised as one JSON object (docs/formats.md, "Statistics").
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/renderer.h"
#include "terrain/world/residency.h"

namespace karst::app {
using namespace core;

class Scene;

struct FrameRecord {
  double frame_ms = 0;        // all of it, the GPU's work included
  double cull_lod_ms = 0;     // choosing levels and listing patches
  double generate_ms = 0;     // making vertices
  double upload_ms = 0;       // of vertices and thresholds
  double submit_ms = 0;       // GL calls
  double gpu_terrain_ms = 0;  // NaN: not known
  double gpu_shadow_ms = 0;   // of the last shadow map that was drawn; NaN: not known
  FrameCounts counts;
  ViewState::Selection selection;
  Governor::State pool;
  std::uint32_t blend_skipped = 0;     // patches drawn that have one material
  std::uint32_t cave_skipped = 0;      // and that are not in caves or lit by lamps
  std::uint32_t generated = 0;         // patches whose vertices were made
  std::uint32_t resident = 0;          // patches with vertices on the GPU
  std::uint64_t heap_calls = 0;        // of choosing and making vertices
  std::uint64_t gl_objects = 0;        // made since the scene was ready
  int cascades_skipped = 0;            // shadow maps that did not have to be drawn
  std::uint64_t shadow_triangles = 0;  // of those that were drawn
  double shadow_ms = 0;                // of finding out, and of drawing them
  std::uint32_t flags = 0;             // bits of FrameFlag
};

// Limits that a frame hit; the picture is valid and lacks detail or distant parts.
enum FrameFlag : std::uint32_t {
  kFlagDrawItems = 1,  // max_draw_items
  kFlagPool = 2,       // gpu_vertex_pages: the picture or what casts shadows is coarser
  kFlagGenerate = 4,   // generate_ms: drawn coarser until more vertices are made
};

// NaN for no values. Reorders values.
double median(std::vector<double>& values);
double percentile(std::vector<double>& values, double part);

// frames: at least one.
std::string statistics_json(Scene& scene, const std::vector<FrameRecord>& frames);

}  // namespace karst::app
