// SPDX-License-Identifier: MIT
// What a patch's edges ask for is a few runs of batches, the same ones at every level: a table of 256 states
// holds them. Inner loops are by how the slot's pages lie: behind each other in one to three stretches of the
// buffer, which are most, an index is moved by one of so many numbers, which is vector code over contiguous
// memory; elsewhere the slot's vertices are placed first, and each index is looked up.
#include "terrain/draw/expand_indices.h"

#include <algorithm>
#include <array>

#include "terrain/draw/wall_indices.h"

namespace karst::core {
namespace {

// Batches first .. last - 1 of a level, by the edges' state: lower_edges << 4 | skipped_edges. As
// index_ranges().
struct BatchRuns {
  std::uint8_t first[kMaxIndexRanges] = {};
  std::uint8_t last[kMaxIndexRanges] = {};
};

constexpr BatchRuns runs_of(unsigned lower, unsigned skipped) {
  BatchRuns runs;
  int used = 0;
  const auto append = [&](int batch) {
    if (used > 0 && runs.last[used - 1] == batch) {
      ++runs.last[used - 1];
      return;
    }
    runs.first[used] = static_cast<std::uint8_t>(batch);
    runs.last[used++] = static_cast<std::uint8_t>(batch + 1);
  };
  append(0);
  for (int edge = 0; edge < 4; ++edge) {
    if (((lower | skipped) >> edge & 1u) == 0) append(batch_same(edge));
  }
  for (int edge = 0; edge < 4; ++edge) {
    if (((lower & ~skipped) >> edge & 1u) != 0) append(batch_lower(edge));
  }
  return runs;
}

constexpr std::array<BatchRuns, 256> make_runs() {
  std::array<BatchRuns, 256> all;
  for (unsigned state = 0; state < all.size(); ++state) all[state] = runs_of(state >> 4, state & 15u);
  return all;
}
constexpr std::array<BatchRuns, 256> kRuns = make_runs();

// Where batches begin in the table, and the last one ends.
struct BatchStarts {
  std::uint32_t at[kMaxLevel + 1][kBatches + 1];

  BatchStarts() {
    for (int level = 1; level <= kMaxLevel; ++level) {
      for (int batch = 0; batch < kBatches; ++batch) at[level][batch] = index_batch(level, batch).first;
      at[level][kBatches] = index_count(level);
    }
  }
};

// From this vertex of a slot on, what its place in the buffer is more than that of the stretch before.
struct Step {
  std::uint16_t vertex;
  std::uint32_t more;
};

constexpr int kMostSteps = 2;

// kSteps: stretches of pages but the first.
template <int kSteps>
std::uint32_t* write_stretches(const std::uint16_t* from, std::uint32_t count, std::uint32_t moved,
                               const Step* steps, std::uint32_t* to) {
  Step step[kMostSteps];
  for (int s = 0; s < kSteps; ++s) step[s] = steps[s];
  for (std::uint32_t n = 0; n < count; ++n) {
    std::uint32_t at = moved + from[n];
    for (int s = 0; s < kSteps; ++s) at += from[n] >= step[s].vertex ? step[s].more : 0u;
    to[n] = at;
  }
  return to + count;
}

// Where the vertices of a patch's slot lie in the buffer.
class Slot {
 public:
  // False where the patch has fewer pages than the level needs.
  bool find(const PageTable& pages, PatchId patch, int level) {
    std::uint32_t page = patch < pages.first_page.size() ? pages.first_page[patch] : kNoPage;
    const std::uint32_t needed = slot_pages(level);
    placed_ = 0;
    steps_count_ = 0;
    for (std::uint32_t place = 0; place < needed; ++place) {
      if (page >= pages.next_page.size()) return false;
      const std::uint32_t moved = (page - place) * kPageVertices;  // modulo 2^32
      if (place > 0 && moved != moved_[place - 1]) {
        const Step step{static_cast<std::uint16_t>(place * kPageVertices), moved - moved_[place - 1]};
        if (steps_count_ < kMostSteps) steps_[steps_count_] = step;
        ++steps_count_;
      }
      moved_[place] = moved;
      page = pages.next_page[page];
    }
    vertices_ = static_cast<std::uint32_t>(patch_vertices(level));
    return true;
  }

  // The same of a slot that is one page.
  bool find_page(std::uint32_t page, std::uint32_t pages, std::uint32_t first, int level) {
    if (page >= pages || slot_pages(level) != 1) return false;
    moved_[0] = (first + page) * kPageVertices;
    placed_ = 0;
    steps_count_ = 0;
    return true;
  }

  std::uint32_t* write(const std::uint16_t* from, std::uint32_t count, std::uint32_t* to) {
    switch (steps_count_) {
      case 0:
        return write_stretches<0>(from, count, moved_[0], steps_, to);
      case 1:
        return write_stretches<1>(from, count, moved_[0], steps_, to);
      case 2:
        return write_stretches<2>(from, count, moved_[0], steps_, to);
      default:
        break;
    }
    for (; placed_ < vertices_; ++placed_) places_[placed_] = moved_[placed_ / kPageVertices] + placed_;
    for (std::uint32_t n = 0; n < count; ++n) to[n] = places_[from[n]];
    return to + count;
  }

 private:
  std::uint32_t moved_[kMostSlotPages];
  Step steps_[kMostSteps];
  int steps_count_ = 0;
  std::uint32_t vertices_ = 0;
  std::uint32_t placed_ = 0;
  std::uint32_t places_[patch_vertices(kMaxLevel)];
};

// Where the pages of a mesh lie in the buffer, moved so that its vertices' numbers can be added.
constexpr std::uint32_t kMostMeshPages = (1u << 16) / kPageVertices;

std::uint32_t find_pages(const MeshPages& pages, std::uint32_t page, std::uint32_t* moved) {
  std::uint32_t count = 0;
  for (; page < pages.next_page.size() && count < kMostMeshPages; ++count, page = pages.next_page[page])
    moved[count] = (pages.first_vertex_page + page - count) * kPageVertices;  // modulo 2^32
  return count;
}

}  // namespace

Status ExpandIndices::validate(int max_level) const {
  if (max_level < 1 || max_level > kMaxLevel) {
    return {StatusCode::invalid_argument, "not a level of detail", "max_level"};
  }
  if (table.size() < index_count(max_level)) {
    return {StatusCode::invalid_argument, "does not hold the levels", "table", index_count(max_level)};
  }
  if (!items.empty() && pages.first_page.empty()) {
    return {StatusCode::invalid_argument, "missing", "first_page"};
  }
  const std::uint32_t room =
      std::max({least_room(max_level), nodes.empty() ? 0 : kLeastNodeRoom, meshes.empty() ? 0 : kIndexPage});
  if (out.size() < room) return {StatusCode::invalid_argument, "has no room for one patch", "out", room};
  return {};
}

ExpandIndices::Chunk ExpandIndices::run(std::uint32_t first_item) const {
  Chunk chunk{0, first_item, 0};
  std::uint32_t* to = out.data();
  std::size_t room = out.size();
  const BatchStarts starts;
  Slot slot;
  const std::size_t first_belt = items.size() + nodes.size();
  for (; chunk.next_item < first_belt; ++chunk.next_item) {
    const bool is_node = chunk.next_item >= items.size();
    const DrawItem& item = is_node ? nodes[chunk.next_item - items.size()] : items[chunk.next_item];
    const bool found = is_node ? slot.find_page(item.patch, node_pages, first_node_page, item.level)
                               : slot.find(pages, item.patch, item.level);
    if (!found) {
      ++chunk.left_out;
      continue;
    }
    const std::uint32_t indices =
        patch_index_count(item.level, item.lower_edges, item.skipped_edges) + wall_index_count(item.walls);
    if (indices > room) return chunk;
    room -= indices;
    chunk.indices += indices;
    // At level 1 nothing is lower, and its batches are empty.
    const unsigned lower = item.level > 1 ? item.lower_edges : 0u;
    const BatchRuns& runs = kRuns[(lower & 15u) << 4 | (item.skipped_edges & 15u)];
    const std::uint32_t* const start = starts.at[item.level];
    for (int r = 0; r < kMaxIndexRanges && runs.last[r] != 0; ++r) {
      const std::uint32_t first = start[runs.first[r]];
      to = slot.write(table.data() + first, start[runs.last[r]] - first, to);
    }
    for (int edge = 0; edge < 4 && item.walls != 0; ++edge) {
      if ((item.walls >> edge & 1u) == 0) continue;
      to = slot.write(kWallIndices[static_cast<std::size_t>(edge)].data(), kIndicesPerWall, to);
    }
  }
  if (chunk.next_item < first_mesh_page()) {
    const std::uint32_t triangles = copy_belts(chunk, to, room);
    to += 3 * triangles;
    room -= 3 * triangles;
  }
  if (chunk.next_item >= first_mesh_page()) write_meshes(chunk, to, room);
  return chunk;
}

// Returns how many triangles.
std::uint32_t ExpandIndices::copy_belts(Chunk& chunk, std::uint32_t* to, std::size_t room) const {
  const std::size_t first_belt = items.size() + nodes.size();
  const auto triangles = static_cast<std::uint32_t>(std::min(first_mesh_page() - chunk.next_item, room / 3));
  const auto from = belts.begin() + static_cast<std::ptrdiff_t>(3 * (chunk.next_item - first_belt));
  std::copy(from, from + static_cast<std::ptrdiff_t>(3 * triangles), to);
  chunk.indices += 3 * triangles;
  chunk.next_item += triangles;
  return triangles;
}

void ExpandIndices::write_meshes(Chunk& chunk, std::uint32_t* to, std::size_t room) const {
  std::size_t at = chunk.next_item - first_mesh_page();
  // The item that the page of indices is of.
  auto item = std::upper_bound(meshes.begin(), meshes.end(), at,
                               [](std::size_t n, const MeshItem& mesh) { return n < mesh.before; });
  if (item != meshes.begin()) --item;
  std::uint32_t moved[kMostMeshPages];
  for (; item != meshes.end(); ++item) {
    const std::size_t end = std::size_t{item->before} + item->index_pages();
    if (at >= end) continue;
    const std::uint32_t vertices = find_pages(mesh_pages, item->first_page, moved) * kPageVertices;
    std::uint32_t page = item->first_index_page;
    for (std::size_t n = item->before; n < at && page < mesh_pages.next_index_page.size(); ++n)
      page = mesh_pages.next_index_page[page];
    for (; at < end; ++at) {
      const std::uint32_t done = static_cast<std::uint32_t>(at - item->before) * kIndexPage;
      const std::uint32_t count = std::min(kIndexPage, item->indices - done);
      if (count > room) return;
      ++chunk.next_item;
      if (page >= mesh_pages.next_index_page.size()) {
        ++chunk.left_out;
        continue;
      }
      const std::uint16_t* const from = mesh_pages.indices.data() + std::size_t{page} * kIndexPage;
      for (std::uint32_t n = 0; n < count; ++n) {
        KARST_ASSERT(from[n] < vertices);
        to[n] = moved[from[n] / kPageVertices] + from[n];
      }
      to += count;
      room -= count;
      chunk.indices += count;
      page = mesh_pages.next_index_page[page];
    }
  }
}

}  // namespace karst::core
