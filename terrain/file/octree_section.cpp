// SPDX-License-Identifier: MIT
// Both directions walk the tree recursively; the depth, at most kMaxDepth, bounds the recursion and the
// number of nodes that the section's length allows bounds the walk.
#include "terrain/file/octree_section.h"

#include <algorithm>
#include <array>

namespace karst::core {
namespace {

constexpr unsigned kEmptyLeaf = 0;
constexpr unsigned kFilledLeaf = 1;
constexpr unsigned kInternal = 2;

constexpr std::uint64_t node_count(std::uint32_t octets) {
  return 1 + 8 * std::uint64_t{octets};
}

bool inside(glm::ivec3 corner, std::int32_t size, glm::ivec3 extent) {
  return corner.x + size <= extent.x && corner.y + size <= extent.y && corner.z + size <= extent.z;
}

glm::ivec3 child_corner(glm::ivec3 corner, std::int32_t half, int octant) {
  return {corner.x + (octant & 1 ? half : 0), corner.y + (octant & 2 ? half : 0),
          corner.z + (octant & 4 ? half : 0)};
}

class Decoder {
 public:
  Decoder(std::span<const std::byte> bytes, std::uint32_t octets, glm::ivec3 extent, Octree& tree)
      : bytes_(bytes), nodes_(node_count(octets)), extent_(extent), tree_(tree) {}

  Status read(glm::ivec3 corner, std::int32_t size, Octree::Node& result) {
    if (at_ == nodes_) return corrupt("the octree has more nodes than its octets hold");
    const unsigned code = std::to_integer<unsigned>(bytes_[at_ / 4]) >> (at_ % 4 * 2) & 3u;
    if (code == kEmptyLeaf) {
      result = Octree::kEmpty;
    } else if (code == kFilledLeaf) {
      if (!inside(corner, size, extent_)) return corrupt("a voxel outside the extent is filled");
      result = Octree::kFilled;
    } else if (code == kInternal) {
      if (size == 1) return corrupt("the octree is deeper than its depth");
      return read_children(corner, size / 2, result);
    } else {
      return corrupt("a node of the octree is of no kind");
    }
    ++at_;
    return {};
  }

  // After the root: all nodes were read, and the rest of the last byte is unused.
  Status finish() {
    if (at_ != nodes_) return corrupt("the octree has fewer nodes than its octets hold");
    if (std::to_integer<unsigned>(bytes_.back()) >> 2 != 0)
      return corrupt("unused bits of the octree are not 0");
    return {};
  }

 private:
  Status read_children(glm::ivec3 corner, std::int32_t half, Octree::Node& result) {
    const std::uint64_t own = at_++;
    Octree::Octet octet;
    for (int octant = 0; octant < 8; ++octant) {
      const Status status = read(child_corner(corner, half, octant), half, octet.child[octant]);
      if (!status.ok()) return status;
    }
    const Status status = tree_.make_node(octet, result);
    if (status.ok() && Octree::is_leaf(result)) {
      at_ = own;
      return corrupt("eight equal leaves are not collapsed");
    }
    return status;
  }

  Status corrupt(const char* what) const {
    return {StatusCode::corrupt, what, "octree", std::min<std::uint64_t>(at_ / 4, bytes_.size() - 1)};
  }

  std::span<const std::byte> bytes_;
  std::uint64_t nodes_;
  std::uint64_t at_ = 0;
  glm::ivec3 extent_;
  Octree& tree_;
};

class Encoder {
 public:
  Encoder(const Octree& tree, std::uint32_t octets, glm::ivec3 extent, const ByteSink& sink)
      : tree_(tree), nodes_(node_count(octets)), extent_(extent), sink_(sink) {}

  Status write(Octree::Node node, glm::ivec3 corner, std::int32_t size) {
    if (at_ == nodes_) return invalid("the octree has more octets than stated");
    if (Octree::is_leaf(node)) {
      const bool filled = Octree::is_filled(node);
      if (filled && !inside(corner, size, extent_)) return invalid("a voxel outside the extent is filled");
      return put(filled ? kFilledLeaf : kEmptyLeaf);
    }
    if (size == 1) return invalid("the octree is deeper than its depth");
    if (const Status status = put(kInternal); !status.ok()) return status;
    const Octree::Octet octet = tree_.children(node);
    if (Octree::equal_leaves(octet)) return invalid("eight equal leaves are not collapsed");
    for (int octant = 0; octant < 8; ++octant) {
      const Status status = write(octet.child[octant], child_corner(corner, size / 2, octant), size / 2);
      if (!status.ok()) return status;
    }
    return {};
  }

  Status finish() { return at_ == nodes_ ? flush() : invalid("the octree has fewer octets than stated"); }

 private:
  static constexpr std::size_t kBuffer = 512;  // bytes

  Status put(unsigned code) {
    const std::size_t byte = at_ / 4 % kBuffer;
    const unsigned shift = static_cast<unsigned>(at_ % 4) * 2;
    const unsigned before = shift == 0 ? 0 : std::to_integer<unsigned>(buffer_[byte]);
    buffer_[byte] = static_cast<std::byte>(before | code << shift);
    ++at_;
    return at_ % (4 * kBuffer) == 0 ? flush() : Status();
  }

  // What was put since the last time. The number of nodes is 1 + 8n, so the last flush is never empty.
  Status flush() {
    const std::size_t bytes = (at_ - 1) / 4 % kBuffer + 1;
    if (sink_.write(sink_.context, std::span(buffer_).first(bytes))) return {};
    return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
  }

  static Status invalid(const char* what) { return {StatusCode::invalid_argument, what, "octree"}; }

  const Octree& tree_;
  std::uint64_t nodes_;
  std::uint64_t at_ = 0;
  glm::ivec3 extent_;
  const ByteSink& sink_;
  std::array<std::byte, kBuffer> buffer_;
};

}  // namespace

Status decode_octree(std::span<const std::byte> bytes, std::uint32_t octets, glm::ivec3 extent,
                     Octree& tree) {
  Status status = tree.reset(tree.depth());
  if (!status.ok()) return status;
  if (bytes.size() != octree_section_bytes(octets)) {
    return {StatusCode::corrupt, "the octree's section does not fit its octets", "octree"};
  }
  if (octets > tree.max_octets()) {
    return {StatusCode::limit_reached, "the octree does not fit its pool", "max_octets", octets};
  }
  Decoder decoder(bytes, octets, extent, tree);
  Octree::Node root = Octree::kEmpty;
  status = decoder.read(glm::ivec3(0), tree.size(), root);
  if (status.ok()) status = decoder.finish();
  if (status.ok()) {
    tree.set_root(root);
    return status;
  }
  const Status emptied = tree.reset(tree.depth());
  return emptied.ok() ? status : emptied;
}

Status encode_octree(const Octree& tree, std::uint32_t octets, glm::ivec3 extent, const ByteSink& sink) {
  Encoder encoder(tree, octets, extent, sink);
  const Status status = encoder.write(tree.root(), glm::ivec3(0), tree.size());
  return status.ok() ? encoder.finish() : status;
}

}  // namespace karst::core
