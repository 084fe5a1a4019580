// SPDX-License-Identifier: MIT
// Where levels morph, once for each of a frame's views that differ in optics, error or mode: thresholds by
// patch, and the rows of them that the GPU has. Views that agree share a set; a view keeps its set from frame
// to frame, so that nothing is made or uploaded anew because another view differs.
//
// Row r of set s is row s x max_resident_patches + r on the GPU.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/lod/morph.h"
#include "terrain/resident/resident_pool.h"

namespace karst::core {

// Rows of thresholds that changed: kMorphRow halves each.
struct MorphRows {
  std::uint32_t first_row = 0;            // on the GPU
  std::span<const std::uint16_t> halves;  // empty: nothing changed
};

class ThresholdSets {
 public:
  // Frames after which a set that no view used is given up.
  static constexpr std::uint32_t kIdleFrames = 120;

  // What thresholds depend on, beside the world.
  struct Key {
    ErrorScale scale;
    bool morphing = false;
    int top_level = 0;

    friend bool operator==(const Key&, const Key&) = default;
  };

  static void add_to(Budget& budget, const Config& config) { count_blocks<Blocks>(config, budget); }
  Status create(const Config& config, Arena& arena);
  // Forgets all: for another world.
  void reset();
  // Forgets what the GPU has, keeps thresholds: resident patches have to be touched again.
  void forget_rows();
  // Bounds, errors or edges of patches of a part changed: job has them, without scale and lods. list: first
  // the changed ones, each once, and room for as many as the part has. Where that is not enough to go by, all
  // thresholds of a set are made anew in its next fill(). first: patch of the part.
  void update(SetThresholds job, std::span<PatchId> list, std::size_t changed, PatchId first,
              const ResidentPool& pool);

  // Which set each view uses in a frame. sets: in, those of the last frame, or -1; out, as many as keys, at
  // most Config::max_views. A set that holds a view's thresholds already is taken first, then its old one.
  void assign(std::span<const Key> keys, std::span<int> sets, std::uint32_t frame);

  // Makes a set hold the thresholds of jobs, of one part of the world each, whose lods are filled in here,
  // where it does not; rows of resident patches with it. Errors of SetThresholds::validate().
  Status fill(int set, std::span<SetThresholds> jobs, const ResidentPool& pool);
  Status fill(int set, SetThresholds job, const ResidentPool& pool) { return fill(set, {&job, 1}, pool); }

  // Writes a resident patch's row in every set. surface: of its part, whose first patch is `first`.
  void touch(const Surface& surface, PatchId patch, std::uint32_t row, PatchId first = 0);

  std::span<const PatchLod> lods(int set) const;
  // Changes when and only when the set's thresholds do; no two fillings of any sets have the same one. 0:
  // none.
  std::uint32_t version(int set) const { return sets_[static_cast<std::size_t>(set)].version; }
  std::uint32_t first_row(int set) const { return static_cast<std::uint32_t>(set) * rows_a_set_; }
  int count() const { return count_; }

  // Rows of one set that were not taken yet; call until nothing is left.
  MorphRows take();

 private:
  struct Set {
    Key key;
    std::uint32_t version = 0;  // 0: holds nothing
    std::uint32_t last_used = 0;
    bool used = false;              // by a view that assign() has dealt with
    std::uint32_t dirty_begin = 0;  // rows that may be
    std::uint32_t dirty_end = 0;
  };
  struct Blocks {
    std::span<PatchLod> lods;        // set by set, max_patches each
    std::span<std::uint16_t> rows;   // set by set, max_resident_patches each: what the GPU has, or will have
    std::span<std::uint64_t> dirty;  // set by set, a bit a row that the GPU does not have yet

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::thresholds, std::size_t{config.max_views} * config.max_patches, lods);
      visit(Consumer::thresholds, std::size_t{config.max_views} * config.max_resident_patches * kMorphRow,
            rows);
      visit(Consumer::thresholds, config.max_views * dirty_words(config.max_resident_patches), dirty);
    }
  };

  static constexpr std::size_t dirty_words(std::size_t rows) { return (rows + 63) / 64; }
  std::span<std::uint64_t> dirty_of(int set) const {
    const std::size_t words = dirty_words(rows_a_set_);
    return blocks_.dirty.subspan(static_cast<std::size_t>(set) * words, words);
  }
  int find(const Key& key) const;
  int oldest_unused() const;
  std::span<PatchLod> all_lods(int set) const;
  void touch_row(int set, const Surface& surface, PatchId first, PatchId patch, std::uint32_t row);

  Blocks blocks_;
  std::array<Set, kMostViews> sets_{};
  int count_ = 0;
  std::uint32_t patches_ = 0;  // of the world
  std::uint32_t patches_a_set_ = 0;
  std::uint32_t rows_a_set_ = 0;
  std::uint32_t versions_ = 0;
};

}  // namespace karst::core
