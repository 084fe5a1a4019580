// SPDX-License-Identifier: MIT
// A field with memory of its own, its world file, and all triangles of its finest level.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/file/world_writer.h"
#include "terrain/isosurface/extract_block.h"
#include "tests/support/field_shapes.h"

namespace karst::test {

struct OwnField {
  // All air; so many blocks may take samples.
  OwnField(FieldInfo info, std::uint32_t blocks_with_samples)
      : table(info.table_blocks()),
        samples(FieldBlocks::kBlockBytes * blocks_with_samples *
                static_cast<std::size_t>(info.sample_bits / 8)) {
    field.create({table, samples});
    info.stored = std::min(blocks_with_samples, static_cast<std::uint32_t>(table.size()));
    EXPECT_TRUE(field.reset(info).ok());
  }
  OwnField(const OwnField&) = delete;

  int at(glm::ivec3 s) const {
    return field.with([&](const auto& f) { return f.at(s); });
  }
  std::uint32_t free() const {
    return field.with([](const auto& f) { return f.free_blocks(); });
  }
  // All of a shape, a sample apart.
  template <class Sample>
  void fill(ScalarField<Sample>& f, const FieldShape& shape) {
    const double scale = -double{ScalarField<Sample>::kSolid} / double{field.info().reach_cells};
    const glm::ivec3 n = f.blocks();
    for (int b = 0; b < n.x * n.y * n.z; ++b) {
      const glm::ivec3 block(b % n.x, b / n.x % n.y, b / n.x / n.y);
      const std::span<Sample> out = f.open(block);
      ASSERT_FALSE(out.empty());
      for (int s = 0; s < static_cast<int>(out.size()); ++s) {
        const double v =
            std::floor(scale * shape(glm::dvec3(block * 16 + glm::ivec3(s & 15, s >> 4 & 15, s >> 8))));
        out[static_cast<std::size_t>(s)] = static_cast<Sample>(
            std::clamp(v, double{ScalarField<Sample>::kSolid}, double{ScalarField<Sample>::kAir}));
      }
      f.close(block);
    }
  }
  void fill(const FieldShape& shape) {
    if (field.info().sample_bits == 16) {
      fill(field.words(), shape);
    } else {
      fill(field.bytes(), shape);
    }
  }

  std::vector<std::uint32_t> table;
  std::vector<std::byte> samples;
  FieldBlocks field;
};

// A world of a field alone, voxels of 1 m.
inline std::vector<std::byte> field_world_file(const FieldBlocks& field,
                                               const WorldMaterials& materials = WorldMaterials()) {
  std::array<Octree::Octet, 1> octets{};
  Octree none;
  WorldWriter writer;
  writer.info.level = 1;
  writer.info.voxel_size_m = 1;
  const int shift = kMostCellLog2 - field.info().cell_log2;
  writer.info.extent = glm::max(field.info().corner + (field.info().blocks * 16 >> shift), glm::ivec3(2));
  const int widest = std::max({writer.info.extent.x, writer.info.extent.y + 1, writer.info.extent.z});
  writer.info.depth = 1;
  while (1 << writer.info.depth < widest) ++writer.info.depth;
  EXPECT_TRUE(none.create(octets, writer.info.depth).ok());
  writer.octree = &none;
  writer.field = &field;
  writer.materials = materials;
  std::vector<std::byte> file;
  const auto append = [&](std::span<const std::byte> bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
    return true;
  };
  const Status status = writer.run(ByteSink::to(append));
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  return file;
}

// Corners in lattice steps from the world's corner, of all blocks.
template <class Visit>
void each_field_triangle(const FieldBlocks& field, const Visit& visit) {
  const FieldInfo& info = field.info();
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> indices(120'000);
  field.with([&](const auto& f) {
    using Job = ExtractBlock<std::remove_cvref_t<decltype(f.filling(glm::ivec3(0)))>>;
    std::vector<std::byte> room(Job::room_bytes() + 16);
    void* aligned = room.data();
    std::size_t space = room.size();
    std::align(16, Job::room_bytes(), aligned, space);
    for (int z = 0; z < info.blocks.z; ++z) {
      for (int y = 0; y < info.blocks.y; ++y) {
        for (int x = 0; x < info.blocks.x; ++x) {
          Job job;
          job.field = &f;
          job.corner = glm::ivec3(x, y, z) * 16;
          job.vertices = vertices;
          job.triangles = indices;
          typename Job::Result result;
          ASSERT_TRUE(job.run({static_cast<std::byte*>(aligned), space}, result).ok());
          const glm::ivec3 low = info.corner * kStepsPerVoxel + (job.corner << info.cell_log2);
          for (std::size_t t = 0; t < result.triangles; ++t) {
            std::array<glm::ivec3, 3> corner;
            for (std::size_t k = 0; k < 3; ++k) {
              const IsoVertex& v = vertices[indices[3 * t + k]];
              const glm::ivec3 place(v.place[0], v.place[1], v.place[2]);
              corner[k] = low + (place << (info.cell_log2 - kLeastCellLog2));
            }
            visit(corner);
          }
        }
      }
    }
  });
}

// Edges that triangles run in one direction more often than in the other, but for those in the field's sides.
inline std::size_t open_edges(const FieldBlocks& field) {
  using Position = std::array<std::int32_t, 3>;
  std::map<std::pair<Position, Position>, int> edges;
  const glm::ivec3 low = field.info().corner * kStepsPerVoxel, high = low + field.info().drawn_steps();
  each_field_triangle(field, [&](const std::array<glm::ivec3, 3>& c) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::ivec3 a = c[k], b = c[(k + 1) % 3];
      bool on_side = false;
      for (int axis = 0; axis < 3; ++axis)
        on_side = on_side || (a[axis] == b[axis] && (a[axis] == low[axis] || a[axis] == high[axis]));
      if (on_side || a == b) continue;
      const Position p{a.x, a.y, a.z}, q{b.x, b.y, b.z};
      if (p < q) {
        ++edges[{p, q}];
      } else {
        --edges[{q, p}];
      }
    }
  });
  return static_cast<std::size_t>(std::ranges::count_if(edges, [](const auto& e) { return e.second != 0; }));
}

}  // namespace karst::test
