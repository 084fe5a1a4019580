// SPDX-License-Identifier: MIT
// The shadow maps of a frame: which of them have to be drawn anew, and with what.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/inspect.h"
#include "karst/renderer.h"
#include "renderer/renderer.h"
#include "scene/frame/ground_frame.h"
#include "scene/frame/meshes/mesh_frame.h"
#include "scene/frame/vertex_work.h"
#include "terrain/lod/morph.h"
#include "terrain/shadow/cascades.h"
#include "terrain/world/terrain_parts.h"

namespace karst::core {

// What the host's own casters are drawn with.
struct HostCasters {
  void (*draw)(void* user, const double clip_from_world[16], Vec3 eye) = nullptr;
  void* user = nullptr;
  bool moved = true;
  Vec3 eye;                       // of the shadow view, in the simulator's frame
  glm::dvec3 eye_voxels{0.0};     // the same
  glm::dmat3 voxels_from_sim{1};  // directions, a metre to voxels
};

class ShadowFrame {
 public:
  // Borrowed for the object's life. settings.count: maps that the renderer has.
  void create(TerrainParts& terrain, Renderer& renderer, VertexWork& work, GroundFrame& ground,
              MeshFrame& meshes, const CascadeSettings& settings);
  // All maps are drawn anew.
  void forget();

  struct Input {
    std::span<ViewState> views;      // of the frame, selected
    std::uint32_t view = 0;          // whose place the maps are around
    const Camera* camera = nullptr;  // its
    FrameLight light;
    HostCasters casters;
    bool skip = true;   // maps that would not change
    bool wait = false;  // until nothing lacks, else for work_ms
    double work_ms = 0;
  };
  // Whether maps are drawn at all in that light.
  bool casts(const FrameLight& light) const;
  // Makes the frame's cascades, and draws the maps that changed.
  Status run(const Input& input, FrameCosts& costs, std::uint32_t& limits);

  // Of the frame; empty while the sun is down.
  std::span<const Cascade> cascades() const { return std::span(cascades_).first(count_); }
  const LightSpace& light_space() const { return light_space_; }

 private:
  LatticeBox box_around(const Camera& camera) const;

  // What a shadow map holds.
  struct Map {
    bool drawn = false;
    Cascade cascade;
    bool complete = false;         // nothing was lacking
    double error_texels = 0;       // SelectCasters
    std::uint64_t casters = 0;     // ShadowCasters::Result::hash
    std::uint64_t ground = 0;      // GroundView::hash
    std::uint64_t meshes = 0;      // Isosurface::List::hash
    std::uint32_t thresholds = 0;  // version that the casters were listed for
    ErrorScale scale;              // of those thresholds
  };

  std::uint32_t version(const Input& input) const;
  bool is_current(const Input& input, const Map& map, const Cascade& cascade) const;
  Status draw_map(const Input& input, int index, FrameCosts& costs, std::uint32_t& limits);
  Status make_casters(const Input& input, std::int64_t start, FrameCosts& costs);
  Status complete_casters(const Input& input, Map& map, const Cascade& cascade, std::uint32_t parts,
                          ShadowCasters::Result& casters, FrameCosts& costs, std::uint32_t& limits);

  TerrainParts* terrain_ = nullptr;
  Renderer* renderer_ = nullptr;
  VertexWork* work_ = nullptr;
  GroundFrame* ground_ = nullptr;
  MeshFrame* meshes_ = nullptr;
  CascadeSettings settings_;
  std::array<Map, kMostCascades> maps_{};
  LightSpace light_space_;
  std::array<Cascade, kMostCascades> cascades_{};
  std::size_t count_ = 0;
};

}  // namespace karst::core
