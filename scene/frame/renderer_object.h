// SPDX-License-Identifier: MIT
// karst::Renderer: a frame, from its views to GL calls.
#pragma once

#include <array>
#include <cstdint>

#include "karst/inspect.h"
#include "karst/renderer.h"
#include "renderer/gl/gl.h"
#include "renderer/renderer.h"
#include "scene/frame/ahead_frame.h"
#include "scene/frame/ground_frame.h"
#include "scene/frame/imagery_frame.h"
#include "scene/frame/meshes/mesh_frame.h"
#include "scene/frame/shadow_frame.h"
#include "scene/frame/vertex_work.h"
#include "scene/world/world_object.h"
#include "terrain/motion/eye_motion.h"

namespace karst::core {

struct RendererObject final : karst::Renderer {
  explicit RendererObject(WorldObject& owner) : world(owner) {}
  ~RendererObject() = default;

  Status open(const karst::GlLoader& loader, const GlOptions& options);
  Status begin(const FrameInput& input, FrameResult& result);
  Status draw_view(std::uint32_t view, const Target& target);
  Status end();
  Air air_of(std::uint32_t view) const;

  WorldObject& world;
  core::Renderer gl;
  Inspection inspection;
  FrameCosts costs;
  std::uint64_t gl_objects = 0;

 private:
  struct View {
    Camera camera;
    unsigned shading = 0;  // what any of its items needs
    EyeMotion motion;
  };

  Status surround();
  Status take_views(const FrameInput& input);
  Status take_light(const Sun& sun, std::uint32_t shadow_view);
  Status upload_skies();
  Status follow_edits(double work_ms);
  Status select(bool cuts);
  Status complete(bool cuts);
  void count_views();
  void fill_result(FrameResult& result);
  shader::FrameBlock block_of(std::uint32_t view) const;
  void forget_vertices();

  VertexWork work_;
  GroundFrame ground_;
  ImageryFrame imagery_;
  AheadFrame ahead_;
  MeshFrame meshes_;
  ShadowFrame shadows_;
  std::array<View, karst::kMostViews> views_{};
  std::array<ViewRequest, karst::kMostViews> requests_{};
  std::array<glm::dvec3, karst::kMostViews> motions_{};  // lattice steps a frame
  std::uint32_t view_count_ = 0;
  FrameLight light_;
  FrameSurroundings surroundings_;
  double work_ms_ = 0;
  std::uint32_t limits_ = 0;
  std::uint32_t made_ = 0;          // by the last end()
  std::uint64_t edit_version_ = 0;  // of the world, as it is on the GPU
  std::uint64_t sky_version_ = 0;
  bool first_frame_ = true;
};

}  // namespace karst::core
