// SPDX-License-Identifier: MIT
// The octree as bytes of the world file: its nodes in pre-order, two bits a node, the first node in the
// lowest bits of the first byte: 0 an empty leaf, 1 a filled leaf, 2 a node followed by its eight children in
// octant order. Unused bits of the last byte are 0. A tree of n octets has 1 + 8n nodes, so its section is
// exactly 2n + 1 bytes long.
#pragma once

#include "karst/status.h"
#include "terrain/field/octree.h"
#include "terrain/file/byte_source.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

// trees: several lie one behind the other, octets are of all.
constexpr std::uint64_t octree_section_bytes(std::uint32_t octets, std::uint32_t trees = 1) {
  return 2 * std::uint64_t{octets} + trees;
}

// Replaces the contents of tree, whose depth must be set. bytes: untrusted, octree_section_bytes(octets) of
// them. corrupt ("octree", value: offset in bytes) where they are not a fully collapsed tree of that many
// octets, or fill a voxel outside the extent; limit_reached ("max_octets") where the pool is too small. The
// tree is empty on failure.
Status decode_octree(std::span<const std::byte> bytes, std::uint32_t octets, glm::ivec3 extent, Octree& tree);

// Writes octree_section_bytes(octets) bytes to the sink, a few hundred at a time. invalid_argument ("octree")
// where the tree has another number of octets, is not collapsed, or fills a voxel outside the extent; part of
// it may be written then. limit_reached ("sink") where the sink does not take them.
Status encode_octree(const Octree& tree, std::uint32_t octets, glm::ivec3 extent, const ByteSink& sink);

}  // namespace karst::core
