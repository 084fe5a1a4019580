// SPDX-License-Identifier: MIT
// Meshes of blocks of an isosurface in memory of stated size: vertices in pages of the GPU's buffer, indices
// in pages of their own (terrain/draw/mesh_items.h). What was not asked for longest gives way. Pages that a
// mesh drawn in one of the last kFramesInFlight frames gives up are kept back for as many frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/blocks/block_key.h"
#include "terrain/blocks/block_rim.h"
#include "terrain/blocks/block_tree.h"
#include "terrain/draw/mesh_items.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/resident/page_table.h"

namespace karst::core {

// Vertices of one mesh for the GPU, page by page along its chain; valid until the pool's next make().
struct MeshUpload {
  std::uint32_t first_page = kNoPage;
  glm::ivec3 origin{0};  // voxels of the size
  int size = 0;          // of its pages
  std::span<const GpuVertex> vertices;
};

class BlockPool {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  // What the greatest block takes: each edge of its cells and of its transition cells, and all triangles.
  static constexpr std::size_t kMostVertices = 28'000;
  static constexpr std::size_t kMostIndices = 3 * 36'000;

  struct Mesh {
    ChosenBlock block;
    std::uint32_t first_page = kNoPage;
    std::uint32_t first_index_page = kNoPage;
    std::uint32_t vertices = 0;
    std::uint32_t indices = 0;
    std::uint32_t rim = 0;       // values of its runs (block_rim.h), behind its indices
    std::uint32_t next = kNone;  // with the same hash; of a free one, the next free one
    std::uint32_t asked = 0;     // the last frame that asked for it
    std::uint32_t drawn = 0;     // the last frame that drew it; 0: none
    bool used = false;
    bool old = false;  // of samples that have changed: no longer found
  };
  struct Storage {
    std::span<Mesh> meshes;
    std::span<std::uint32_t> heads;  // by hash
    std::span<std::uint32_t> next_page, next_index_page;
    std::span<PageTexel> texels;  // by page, for the renderer
    std::span<std::uint16_t> indices;
    std::span<IsoVertex> made;  // one block's, as it is extracted
    std::span<GpuVertex> vertices;
    std::span<std::uint16_t> triangles;
    std::span<std::byte> room;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const bool any = config.field_blocks > 0;
      visit(Consumer::fields, config.field_meshes, meshes);
      visit(Consumer::fields, any ? head_count(config.field_meshes) : 0, heads);
      visit(Consumer::fields, config.field_vertex_pages, next_page);
      visit(Consumer::fields, config.field_index_pages, next_index_page);
      visit(Consumer::fields, config.field_vertex_pages, texels);
      visit(Consumer::fields, std::size_t{config.field_index_pages} * kIndexPage, indices);
      visit(Consumer::fields, any ? kMostVertices : 0, made);
      visit(Consumer::fields, any ? kMostVertices : 0, vertices);
      visit(Consumer::fields, any ? kMostIndices : 0, triangles);
      visit(Consumer::fields, any ? room_bytes() : 0, room);
    }
    static std::size_t head_count(std::uint32_t meshes);
    static std::size_t room_bytes();
  };
  void create(const Storage& storage);

  // Where the field's region begins, voxels from the world's corner; of a field that is no region's 0.
  void set_region(glm::ivec3 corner) { region_ = corner; }
  // Empties it: the GPU holds nothing of it.
  void reset();
  void begin_frame() {
    ++frame_;
    release(frame_ % kFramesInFlight);
  }
  // What is kept back is free at once. Precondition: the GPU is idle.
  void release_kept() {
    for (std::uint32_t n = 0; n < kFramesInFlight; ++n) release(n);
  }

  // The mesh of a block, or kNone; it is asked for then in this frame, and stays.
  std::uint32_t find(const ChosenBlock& block);
  const Mesh& mesh(std::uint32_t n) const { return storage_.meshes[n]; }
  // One of its runs' values, and where a vertex of it lies among those of all pages.
  std::uint16_t rim_value(std::uint32_t n, std::uint32_t at) const;
  std::uint32_t vertex_place(std::uint32_t n, std::uint32_t vertex) const;
  // That a mesh is drawn in this frame, too.
  void draw(std::uint32_t n) { storage_.meshes[n].asked = storage_.meshes[n].drawn = frame_; }
  // That it stays in this frame.
  void ask(std::uint32_t n) { storage_.meshes[n].asked = frame_; }
  // Takes out what make() made last, before it was copied or drawn.
  void discard(std::uint32_t n) { give_up(n); }
  // That nobody needs it in this frame.
  void spare(std::uint32_t n) { storage_.meshes[n].asked = frame_ - 1; }
  // Meshes of blocks that is_old(block) says are no longer found, and give way when nobody asks for them.
  template <class IsOld>
  void outdate(const IsOld& is_old) {
    for (std::uint32_t n = 0; n < storage_.meshes.size(); ++n) {
      Mesh& mesh = storage_.meshes[n];
      if (mesh.used && !mesh.old && is_old(mesh.block.block)) {
        unlink(n);
        mesh.old = true;
      }
    }
  }

  // Makes a block's mesh; it may be empty. limit_reached ("field_meshes", "field_vertex_pages",
  // "field_index_pages") where nothing more can give way; some of what did may be kept back (has_kept()).
  Status make(const FieldBlocks& field, const ChosenBlock& block, std::uint32_t& mesh, MeshUpload& upload);
  bool has_kept() const;

  std::uint32_t free_pages() const { return pages_.free; }
  std::uint32_t page_count() const { return static_cast<std::uint32_t>(storage_.next_page.size()); }
  std::uint32_t free_index_pages() const { return index_pages_.free; }
  std::uint32_t index_page_count() const {
    return static_cast<std::uint32_t>(storage_.next_index_page.size());
  }
  std::span<PageTexel> texels() const { return storage_.texels; }
  MeshPages pages(std::uint32_t first_vertex_page) const {
    return {first_vertex_page, storage_.next_page, storage_.next_index_page, storage_.indices};
  }

 private:
  // Free pages and those kept back are chains, as those of meshes are.
  struct Pages {
    std::uint32_t first = kNoPage;
    std::uint32_t free = 0;
    std::array<std::uint32_t, kFramesInFlight> kept{};
  };

  std::uint32_t& head_of(const ChosenBlock& block);
  void release(std::uint32_t slot);
  static void reset_pages(Pages& pages, std::span<std::uint32_t> next);
  static std::uint32_t take(Pages& pages, std::span<std::uint32_t> next, std::uint32_t count);
  void keep_back(std::uint32_t first);
  static void set_free(Pages& pages, std::span<std::uint32_t> next, std::uint32_t first);
  void unlink(std::uint32_t mesh);
  void give_up(std::uint32_t mesh);
  bool give_up_oldest();
  Status extract(const FieldBlocks& field, const ChosenBlock& block, std::uint32_t& vertices,
                 std::uint32_t& indices);

  Storage storage_;
  glm::ivec3 region_{0};
  std::uint32_t frame_ = 0;
  std::uint32_t free_mesh_ = kNone;
  Pages pages_, index_pages_;
};

}  // namespace karst::core
