// SPDX-License-Identifier: MIT
// What is drawn of a world's isosurface, for all eyes: one choice of blocks, whose meshes all are there. The
// next choice is made while the last one is drawn, and takes its place when none of its meshes is missing: so
// every frame draws a closed surface. A choice takes half of the memory for meshes at most.
//
//   each frame:
//     isosurface.begin_frame();
//     isosurface.choose(eyes);                            // where the last choice is complete
//     while (isosurface.make_next(upload, status)) copy it to the GPU
//     isosurface.list(frustum, list)                      // for each view and shadow map
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/blocks/block_pool.h"
#include "terrain/blocks/block_tree.h"

namespace karst::core {

// The region of a ground whose field it is: where that begins, voxels from the world's corner, and the width
// of its columns (block_rim.h), lattice steps. Cameras and frustums are the region's then.
struct FieldRegion {
  glm::ivec3 corner{0};
  std::int64_t column = 0;
};

class Isosurface {
 public:
  Isosurface() = default;
  Isosurface(const Isosurface&) = delete;
  Isosurface& operator=(const Isosurface&) = delete;

  static void add_to(Budget& budget, const Config& config) { count_blocks<Blocks>(config, budget); }
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);

  // Begins anew with a field, which is borrowed until the next attach(); one that does not exist draws
  // nothing.
  void attach(const FieldBlocks& field, const FieldRegion& region);
  void attach(const FieldBlocks& field) { attach(field, FieldRegion()); }
  bool exists() const { return field_ != nullptr && field_->exists(); }
  // Forgets what is on the GPU.
  void forget();
  // Samples low..high (both included) of the field have changed: meshes with them are made anew.
  void change(glm::ivec3 low, glm::ivec3 high);

  void begin_frame();
  // Whether the last choice is complete, so that another can be made.
  bool is_complete() const { return made_ == wanted_.count; }
  // Chooses for all eyes together. error_scale(): what they should aim at more than they do.
  void choose(std::span<const BlockEye> eyes);
  float error_scale() const { return error_scale_; }
  // The next mesh of the choice that is missing; with empty vertices there is none to copy. False: all are
  // there, or there is no room now (lacks_room()), or an error in status.
  bool make_next(MeshUpload& upload, Status& status);
  bool lacks_room() const { return lacks_room_; }
  // What is kept back is free at once. Precondition: the GPU is idle.
  void release_kept() { pool_.release_kept(); }

  // Meshes of what is drawn that a frustum may show; valid until the list's next use. hash: of them.
  struct List {
    std::span<const MeshItem> items;
    std::uint64_t hash = 0;
    std::uint32_t triangles = 0;
    std::uint32_t culled = 0;
  };
  // list: of Config::max_views views, and one more for shadow maps.
  List list(std::size_t list, const Frustum* frustum);
  // The most pixels that what is drawn is off by for an eye of a scale.
  float bound_px(const LodEye& eye, float pixels) const;
  std::span<const ChosenBlock> drawn() const {
    return std::span<const ChosenBlock>(shown_.blocks).first(shown_.count);
  }
  // Where that ends at the sides of its region; there is none of a field that is no region's.
  const BlockRim& rim() const { return rim_; }
  // Blocks of the next choice whose meshes are missing.
  std::uint32_t lacking() const { return static_cast<std::uint32_t>(wanted_.count - made_); }

  const BlockTree& tree() const { return tree_; }
  const BlockPool& pool() const { return pool_; }

 private:
  struct Choice {
    std::span<ChosenBlock> blocks;
    std::span<std::uint32_t> meshes;
    std::size_t count = 0;
  };
  struct Blocks {
    BlockRim::Storage rim;
    BlockTree::Storage tree;
    BlockPool::Storage pool;
    std::array<std::span<ChosenBlock>, 2> blocks;
    std::array<std::span<std::uint32_t>, 2> meshes;
    std::array<std::span<MeshItem>, kMostViews + 1> lists;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      rim.each_block(config, visit);
      tree.each_block(config, visit);
      pool.each_block(config, visit);
      for (std::size_t n = 0; n < 2; ++n) {
        visit(Consumer::fields, config.field_meshes, blocks[n]);
        visit(Consumer::fields, config.field_meshes, meshes[n]);
      }
      for (std::size_t n = 0; n <= config.max_views; ++n)
        visit(Consumer::fields, config.field_meshes, lists[n]);
    }
  };

  void rechoose();
  void show();
  bool coarsen(float factor);
  bool give_way();
  float used_share() const;

  const FieldBlocks* field_ = nullptr;
  Blocks blocks_;
  BlockTree tree_;
  BlockPool pool_;
  BlockRim rim_;  // of what is shown
  std::int64_t column_ = 0;
  Choice shown_, wanted_;
  std::size_t made_ = 0;  // of wanted_, from the first on
  std::uint32_t made_pages_ = 0, made_index_pages_ = 0;
  std::array<BlockEye, kMostViews> eyes_{};
  std::size_t eye_count_ = 0;
  float error_scale_ = 1;
  std::uint64_t changes_ = 0;
  bool lacks_room_ = false;
};

}  // namespace karst::core
