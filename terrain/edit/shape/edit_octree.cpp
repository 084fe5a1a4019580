// SPDX-License-Identifier: MIT
#include "terrain/edit/shape/edit_octree.h"

#include <glm/common.hpp>

namespace karst::core {

Status EditOctree::run(Result& result) const {
  result = {};
  result.low = glm::ivec3(octree->size());
  return edit(octree->root(), glm::ivec3(0), octree->size(), result, result.root);
}

Status EditOctree::edit(Octree::Node node, glm::ivec3 origin, int size, Result& result,
                        Octree::Node& made) const {
  made = node;
  const Octree::Node wanted = filled ? Octree::kFilled : Octree::kEmpty;
  if (node == wanted) return {};
  const VoxelShape::Part part = shape->of(origin, size);
  if (part == VoxelShape::Part::none) return {};
  if (part == VoxelShape::Part::all) {
    result.low = glm::min(result.low, origin);
    result.high = glm::max(result.high, origin + size - 1);
    made = wanted;
    return {};
  }
  const Octree::Octet old = octree->children(node);
  Octree::Octet now = old;
  Status status;
  bool changes = false;
  for (int o = 0; o < 8 && status.ok(); ++o) {
    const glm::ivec3 at = origin + size / 2 * glm::ivec3(o & 1, o >> 1 & 1, o >> 2 & 1);
    status = edit(old.child[o], at, size / 2, result, now.child[o]);
    changes = changes || now.child[o] != old.child[o];
  }
  if (status.ok() && changes) status = octree->make_node(now, made);
  if (!status.ok()) {
    for (int o = 0; o < 8; ++o) release(*octree, now.child[o], old.child[o]);
    made = node;
  }
  return status;
}

void EditOctree::release(Octree& octree, Octree::Node gone, Octree::Node stays) {
  if (gone == stays || Octree::is_leaf(gone)) return;
  for (int o = 0; o < 8; ++o) release(octree, octree.child(gone, o), octree.child(stays, o));
  constexpr Octree::Octet kNone{{Octree::kEmpty, Octree::kEmpty, Octree::kEmpty, Octree::kEmpty,
                                 Octree::kEmpty, Octree::kEmpty, Octree::kEmpty, Octree::kEmpty}};
  octree.update_node(gone, kNone);
}

}  // namespace karst::core
