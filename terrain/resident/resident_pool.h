// SPDX-License-Identifier: MIT
// Which patches have vertices on the GPU, up to which level, and in which pages (design 4.8).
//
// Vertex memory is one buffer in pages of kPageVertices; a patch resident at level r has a chain of
// slot_pages(r) pages, in any order (page_table.h), so memory never fragments: whatever gives way makes room
// for anything. Pages that follow each other in the buffer, and the patch's last one, are taken where there
// are some, because their indices are written faster (expand_indices.cpp). Vertices are stored level by level
// (gpu_vertex.h): raising the level appends pages, lowering it drops the last ones. Each resident patch also
// has a row, for its morph thresholds (morph.h).
//
// The GPU may still draw a frame when the next ones are prepared: what a patch seen in one of the last
// kFramesInFlight frames gives up is kept back for as many frames.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/resident/page_table.h"
#include "terrain/surface/patch.h"

namespace karst::core {

class ResidentPool {
 public:
  static constexpr std::uint32_t kNoRow = 0xffffffffu;

  // A resident patch. 12 bytes.
  struct Row {
    PatchId patch = 0;  // or, of a free row, the next free one
    std::uint32_t last_seen = 0;
    std::uint8_t needed = 0;  // most that was wanted in the selection last_selection of the frame last_seen
    bool used = false;
    std::uint16_t last_selection = 0;
  };

  // Borrowed for the pool's life.
  struct Storage {
    std::span<std::uint32_t> first_page;    // by patch
    std::span<std::uint32_t> row_of_patch;  // by patch
    std::span<std::uint8_t> levels;         // by patch
    std::span<std::uint32_t> next_page;     // by page
    std::span<std::uint64_t> free_pages;    // a bit a page
    std::span<PageTexel> texels;            // by page, for the renderer
    std::span<Row> rows;                    // as many as patches can be resident

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::residency, config.max_patches, first_page);
      visit(Consumer::residency, config.max_patches, row_of_patch);
      visit(Consumer::residency, config.max_patches, levels);
      visit(Consumer::residency, config.gpu_vertex_pages, next_page);
      visit(Consumer::residency, (std::size_t{config.gpu_vertex_pages} + 63) / 64, free_pages);
      visit(Consumer::residency, config.gpu_vertex_pages, texels);
      visit(Consumer::residency, config.max_resident_patches, rows);
    }
  };
  void create(const Storage& storage);

  // Empties the pool for a world of so many patches, at most as many as storage has room for. base_level: one
  // page, what patches out of view are lowered to first. Where pages and rows suffice for all patches at it,
  // they are never lowered further: what comes into view is not a hole.
  void reset(std::uint32_t patches, int base_level);

  // A new frame: what was kept back long enough becomes free. frame() counts from 1.
  void begin_frame();
  std::uint32_t frame() const { return frame_; }

  int level(PatchId patch) const { return storage_.levels[patch]; }  // 0: not resident
  std::span<const std::uint8_t> levels() const { return storage_.levels.first(patches_); }
  std::uint32_t row(PatchId patch) const { return storage_.row_of_patch[patch]; }
  PageTable pages() const {
    return {storage_.first_page.first(patches_), storage_.next_page, storage_.texels};
  }

  // Rows are handed out from 0 on; below is where all used ones lie.
  std::uint32_t row_end() const { return row_end_; }
  const Row& row_at(std::uint32_t row) const { return storage_.rows[row]; }

  // What is wanted from here on replaces what the frame wanted until now. All views of a frame make one
  // selection.
  void begin_selection() { ++selection_; }
  // Tells that somebody sees a patch and wants it at a level; the most that anybody wants in a selection
  // counts. Returns what was wanted of it before in this selection: 0 where nothing was or where it is not
  // resident.
  int see(PatchId patch, int needed) {
    const std::uint32_t index = storage_.row_of_patch[patch];
    if (index == kNoRow) return 0;
    Row& row = storage_.rows[index];
    const int before = row.last_seen == frame_ && row.last_selection == selection_ ? row.needed : 0;
    row.last_seen = frame_;
    row.last_selection = selection_;
    if (needed > before) row.needed = static_cast<std::uint8_t>(needed);
    return before;
  }
  // The same of items (patch, level) that nobody has seen in this selection, each of another patch.
  template <class Item>
  void see_first(std::span<const Item> items) {
    // Copies, which the stores below cannot change.
    const std::uint32_t* const row_of_patch = storage_.row_of_patch.data();
    Row* const rows = storage_.rows.data();
    const std::uint32_t frame = frame_;
    const std::uint16_t selection = selection_;
    for (const Item& item : items) {
      const std::uint32_t index = row_of_patch[item.patch];
      if (index == kNoRow) continue;
      Row& row = rows[index];
      row.last_seen = frame;
      row.last_selection = selection;
      row.needed = item.level;
    }
  }
  // Most that was wanted of a patch in this selection, 0 where nothing was or where it is not resident.
  int needed(PatchId patch) const {
    const std::uint32_t index = storage_.row_of_patch[patch];
    if (index == kNoRow) return 0;
    const Row& row = storage_.rows[index];
    return row.last_seen == frame_ && row.last_selection == selection_ ? row.needed : 0;
  }

  bool keeps_base() const { return page_count() >= patches_ && storage_.rows.size() >= patches_; }
  std::uint32_t page_count() const { return static_cast<std::uint32_t>(storage_.next_page.size()); }
  std::uint32_t free_pages() const { return free_count_; }
  std::uint32_t kept_back() const;
  // What is kept back, or given up in the rest of this frame, is free at once. Precondition: the GPU is idle.
  void release_kept();
  std::uint32_t resident() const { return resident_; }

  // Gives a patch the pages and the row for a level above its own. False, and nothing changes, where too few
  // are free.
  bool raise(PatchId patch, int level);
  // Takes what is above a level (0: all) from a patch.
  void lower(PatchId patch, int level);

  // Gives a patch other pages for those at places first .. first + count - 1 of its chain, which are given up
  // as by lower(). Precondition: it has them, and as many are free.
  void replace(PatchId patch, std::uint32_t first, std::uint32_t count);

  // Makes room for raising a patch to a level: takes from patches that the frame does not see, longest unseen
  // first by and large, then from those that are finer than the frame needs; for the base level of a patch
  // that is not resident, which is a hole, even from those that the frame needs finer; not where it is not
  // seen itself and only casts a shadow. Whether there is room now; some of what it took may be kept back for
  // the next frames. Never touches `patch`.
  bool make_room(PatchId patch, int level, bool casts_only = false);

 private:
  struct List {  // a chain of pages
    std::uint32_t first = kNoPage;
    std::uint32_t last = kNoPage;
    std::uint32_t count = 0;
  };

  // Pages first .. first + count - 1.
  struct Stretch {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };

  void append(List& list, const List& pages);
  void set_free(const List& pages);
  std::uint32_t next_page(std::uint32_t page, bool is_free, std::uint32_t end) const;
  Stretch find_free(std::uint32_t pages);
  List take_free(std::uint32_t pages, std::uint32_t before);  // before: the chain's last page, or kNoPage
  void give_back(PatchId patch, std::uint32_t row, const List& pages);
  static std::uint32_t pages_at(int level) { return level <= 0 ? 0 : slot_pages(level); }
  bool has_room(PatchId patch, int level) const;
  // What is asked of patches: those out of view go down to `unseen`, those in view to what is needed of them,
  // or with `holes` to the base level.
  struct Claim {
    PatchId spared;
    int unseen;
    bool holes;
  };
  // What a row may be lowered to; above kMaxLevel where nothing can be taken.
  int yields_to(std::uint32_t row, const Claim& claim) const;
  bool take_oldest(const Claim& claim);

  Storage storage_;
  std::uint32_t patches_ = 0;
  int base_level_ = 1;
  std::uint32_t frame_ = 0;
  std::uint16_t selection_ = 0;   // wraps around: only those of one frame are told apart
  std::uint32_t idle_frame_ = 0;  // in this frame nothing is in flight; 0: none
  // Pages that are looked at behind a stretch that would do, so that many free ones cost no more than few.
  static constexpr std::uint32_t kFar = 4'096;
  std::uint32_t free_count_ = 0;
  std::uint32_t first_free_ = 0;  // none before it
  List kept_[kFramesInFlight];    // by frame modulo kFramesInFlight
  std::uint32_t free_row_ = kNoRow;
  std::uint32_t row_end_ = 0;
  std::uint32_t resident_ = 0;
  std::uint32_t hand_ = 0;
  std::uint32_t promised_ = 0;  // of the pages kept back, in this frame
};

}  // namespace karst::core
