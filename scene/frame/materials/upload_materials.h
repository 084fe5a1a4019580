// SPDX-License-Identifier: MIT
// What the ground is made of, onto the GPU: all of it at the start, and what edits have painted since.
#pragma once

#include "karst/status.h"
#include "renderer/renderer.h"
#include "scene/world/world_object.h"

namespace karst::core {

// Materials, their textures and the blend map as it is now. Errors of reading.
Status upload_materials(WorldObject& world, Renderer& gl);

// What was painted since it was called last (EditorObject::unshown).
Status show_paint(WorldObject& world, Renderer& gl);

}  // namespace karst::core
