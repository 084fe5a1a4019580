// SPDX-License-Identifier: MIT
// What the renderer did.
#pragma once

#include <cstdint>

namespace karst::core {

// Of a frame: all of its views and shadow maps.
struct FrameCounts {
  std::uint64_t triangles = 0;  // submitted, all passes
  std::uint32_t draw_calls = 0;
  std::uint32_t left_out = 0;        // items without resident vertices; see ExpandIndices
  std::uint64_t uploaded_bytes = 0;  // vertices and texels
  // The driver lost the vertex buffer, which it may do where the screen's mode changes: all vertices have to
  // be uploaded again; no terrain was drawn.
  bool vertices_lost = false;
};

}  // namespace karst::core
