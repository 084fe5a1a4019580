// SPDX-License-Identifier: MIT
// Indices of what is drawn, written anew for each pass.
#pragma once

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/frame_counts.h"
#include "renderer/input/settings.h"
#include "terrain/draw/expand_indices.h"

namespace karst::core {

// What a view or a shadow map draws. out is left empty.
template <class Input>
ExpandIndices expand_of(const RendererSettings& settings, const Input& input) {
  MeshPages mesh_pages = input.mesh_pages;
  mesh_pages.first_vertex_page = settings.vertex_pages + settings.family_pages;
  return {.table = input.index_table,
          .items = input.items,
          .pages = input.pages,
          .out = {},
          .nodes = input.nodes,
          .first_node_page = settings.vertex_pages,
          .node_pages = settings.family_pages,
          .belts = input.belts,
          .meshes = input.meshes,
          .mesh_pages = mesh_pages};
}

// Draws the items, nodes and belts with the program in use, in as many calls as the stream is too short for;
// counts what it did. expand.out is filled in here. max_level: of the items. invalid_argument names what is
// wrong with them; limit_reached where the driver cannot map the stream.
Status draw_items(const GlDevice& device, ExpandIndices expand, int max_level, FrameCounts& counts);

}  // namespace karst::core
