// SPDX-License-Identifier: MIT
// What is on the GPU, one for all eyes: pages of vertices and who has them, vertices made, thresholds, what
// to make next over the union of all views, and one governor for them.
//
//   each frame:
//     residency.begin_frame();
//     residency.select(views, requests);            // all views of the frame together
//     while (there is time && residency.generate_next(ahead, upload, status)) copy upload to the GPU
//     for (MorphRows rows; !(rows = residency.take_morph_rows()).halves.empty();) copy rows to the GPU
//     for each view: draw view.items() with residency.pages() and residency.first_morph_row(view)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/lod/governor.h"
#include "terrain/lod/threshold_sets.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/resident/page_table.h"
#include "terrain/resident/resident_pool.h"
#include "terrain/shading/patch_shading.h"
#include "terrain/shading/shading.h"
#include "terrain/world/view_state.h"
#include "terrain/world/world.h"

namespace karst::core {

// Vertices of one patch for the GPU; valid until the next call of the Residency.
struct PatchUpload {
  PatchId patch = 0;
  std::uint32_t row = 0;  // its morph row
  int first_vertex = 0;   // of its slot; those before it are there already
  // To its chain of pages (pages()), from first_vertex on. None: what its pages say of it is another.
  std::span<const GpuVertex> vertices;
  glm::ivec3 origin{0};  // voxels
  PatchShading shading;
};

class Residency {
 public:
  Residency() = default;
  Residency(const Residency&) = delete;
  Residency& operator=(const Residency&) = delete;

  static void add_to(Budget& budget, const Config& config);
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);
  // Begins anew with a world that was just loaded: nothing is resident, memory that the world lends is used.
  // Borrowed until the next attach(); call it again after each World::load().
  Status attach(World& world);
  // Forgets what is on the GPU: after its buffers were lost or made anew.
  void forget();

  // The world was edited. touched: patches whose measures may be others, and rows of each that hold all
  // vertices that may be, which remake_next() makes anew where they are resident; vanished: slots that are
  // free now. Both ascending, and of one part.
  void follow_edit(std::span<const PatchId> touched, std::span<const GridRows> rows,
                   std::span<const PatchId> vanished);
  // A part is new: none of its patches is resident. It is fresh until all of them are.
  void follow_region(std::size_t part);
  // Bit n: not all patches of part n were resident yet, since follow_region().
  std::uint32_t fresh_parts() const { return turns_.fresh; }
  // The world has used what it lends.
  void take_scratch() { patch_scratch_ = make_patch_scratch(lent_.scratch); }
  // A patch was measured (terrain/edit/settle.h), or the sky of a part is another, or what is painted.
  void follow_measures(PatchId patch);
  void follow_sky(std::size_t part);
  // Before a frame's select(): makes vertices of what edits have touched, in other pages than those that may
  // be drawn still, and no other pages than they lie in; where there is no room at coarser levels, or not at
  // all. Then what has other shading alone: an upload without vertices. A patch may take several uploads.
  // False: nothing is left. status: errors of reading heights.
  // most: patches that are made so, counted down; with 0 left a patch gets plain vertices: those of the
  // coarsest levels, at their places, with normals of a coarse surface. It waits for a call with more.
  bool remake_next(PatchUpload& upload, Status& status, std::uint32_t& most);
  bool remake_next(PatchUpload& upload, Status& status) {
    std::uint32_t all = 0xffffffffu;
    return remake_next(upload, status, all);
  }
  // Whether patches have plain vertices, whoever sees them.
  bool has_plain() const;
  // Working memory between frames, one value a patch.
  std::span<std::uint32_t> lend_list() { return blocks_.list_scratch.first(world_->patch_count()); }

  // What a patch's shading needs, which its vertices' pages carry. Where skips differ from the last ones, all
  // is found anew and forget() is called.
  Status set_shading_skips(const ShadingSkips& skips);
  std::span<const PatchShading> shading() const;

  // Vertices of one patch at a level or, with emit_level, those of its coarser levels alone
  // (GenerateVertices); patch_vertices() of the level emitted, in slot order. Errors of reading heights.
  // Precondition: patch < patch_count(), 1 <= emit_level <= level <= info().level.
  Status generate(PatchId patch, int level, int emit_level, std::span<GpuVertex> out);

  // --- A frame

  // Call once for each frame that is drawn, before its first select().
  void begin_frame() { pool_.begin_frame(); }

  // Chooses levels for all views of the frame, no finer than what is resident, lists what they see, and lets
  // the governor decide on the next error scale. views and requests: as many as each other, at most
  // Config::max_views; view n of a frame is view n of the next one. Borrowed until the frame's last
  // generate_next(). May be called several times a frame. limit_reached ("max_draw_items"): some list is
  // valid, but shorter; else nothing is listed.
  // cuts: SelectLod's; without, complete_selection() has to follow.
  Status select(std::span<ViewState> views, std::span<const ViewRequest> requests, bool cuts = true);
  // After a select() without cuts, once generate_next() has made what it can: true where all of it is held
  // now. The selection is then the one that select() would make, and nothing lacks. False: call select().
  bool complete_selection();
  // Lets generate_next() try again what it had no room for. What patches give up in the rest of this frame is
  // free at once. Precondition: the GPU is idle.
  void retry_lacking();
  const Governor::State& governor() const { return governor_.state(); }

  // Makes vertices that the views of the last select() lacked, what is off by most pixels first, whoever sees
  // it. Then, with `ahead`, of patches that are about to be needed, as long as the pool has room to spare.
  // False: there is nothing to do, or no room. status: errors of reading heights.
  bool generate_next(bool ahead, PatchUpload& upload, Status& status);
  // Makes the coarsest vertices of a patch that has none, where the pool keeps room for those of all patches.
  // False: none lacks any, or there is no room. status: errors of reading heights. most: of fresh parts,
  // counted down; with 0 left they wait.
  bool generate_base(PatchUpload& upload, Status& status, std::uint32_t& most);
  bool generate_base(PatchUpload& upload, Status& status) {
    std::uint32_t all = 0xffffffffu;
    return generate_base(upload, status, all);
  }
  // Makes vertices of a patch up to a level, where there are free pages for them: pool().make_room() first.
  // False: there are not, or status has an error of reading heights; then nothing changed.
  bool make_resident(PatchId patch, int level, PatchUpload& upload, Status& status) {
    return make_resident(patch, level, world_->info().level, upload, status);
  }

  // What is resident takes effect in the next select().
  PageTable pages() const { return pool_.pages(); }
  const ResidentPool& pool() const { return pool_; }
  ResidentPool& pool() { return pool_; }
  // What patches give up in the rest of this frame is free at once. Precondition: the GPU is idle.
  void release_kept_pages() { pool_.release_kept(); }

  const ThresholdSets& thresholds() const { return thresholds_; }
  // GPU row that the view's thresholds begin at; a page's texel counts from it.
  std::uint32_t first_morph_row(const ViewState& view) const {
    return view.threshold_set() < 0 ? 0 : thresholds_.first_row(view.threshold_set());
  }
  // Rows that changed and were not taken yet, of one set at a time: call until there are none.
  MorphRows take_morph_rows() { return thresholds_.take(); }

  std::uint64_t height_groups_read() const;

 private:
  struct Blocks {
    ResidentPool::Storage pool;
    std::span<PatchShading> shading;        // by patch
    std::span<std::uint32_t> list_scratch;  // one value a patch
    std::span<GpuVertex> vertices;          // of one patch
    // A bit a patch, where worlds are edited: whose vertices are to be made anew, whose shading is another.
    std::span<std::uint64_t> stale;
    std::span<std::uint64_t> reshaded;
    std::span<std::uint64_t> plain;  // a bit a patch: that has plain vertices
    std::span<GridRows> stale_rows;  // by patch that is stale
    std::span<std::uint8_t> held;    // by patch that is plain: the level that it had

    static bool is_edited(const Config& config) { return config.edit_patches > 0 || config.paint_width > 0; }
    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      pool.each_block(config, visit);
      visit(Consumer::bounds, config.max_patches, shading);
      visit(Consumer::draw_list, config.max_patches, list_scratch);
      visit(Consumer::scratch, static_cast<std::size_t>(patch_vertices(static_cast<int>(config.max_level))),
            vertices);
      const std::size_t words = is_edited(config) ? (std::size_t{config.max_patches} + 63) / 64 : 0;
      visit(Consumer::edits, words, stale);
      visit(Consumer::edits, words, reshaded);
      visit(Consumer::edits, words, plain);
      visit(Consumer::edits, is_edited(config) ? config.max_patches : 0, stale_rows);
      visit(Consumer::edits, is_edited(config) ? config.max_patches : 0, held);
    }
  };
  // Where looking for patches goes on.
  struct Turns {
    PatchId ahead = 0;
    PatchId base = 0;
    std::uint32_t ahead_left = 0;  // patches to look at in this frame
    std::uint32_t fresh = 0;       // fresh_parts()
    std::size_t stale = 0;         // words of stale and reshaded before it are 0
    std::size_t plain = 0;         // words of plain before it are 0
  };
  // Pages of a patch, by place in its chain, that have yet to be uploaded.
  struct Remade {
    struct Stretch {
      std::uint32_t first = 0;
      std::uint32_t end = 0;
    };

    PatchId patch = 0;
    std::array<Stretch, kMaxLevel> stretches{};
    std::size_t count = 0;
    std::size_t next = 0;
    bool in_room = false;  // its vertices are in working memory
  };
  // What the last select() of all views looked at, to tell whether anything moved.
  struct Seen {
    LodEye eye;
    float pixels = 0;  // ErrorScale's
    double error_px = 0;
    double weight = 0;
    int top_level = 0;
    friend bool operator==(const Seen&, const Seen&) = default;
  };

  Status find_shading();
  FindPatchShading shading_job(const WorldPart& part) const;
  void shade(const WorldPart& part, const FindPatchShading& find, PatchId own);
  void update_thresholds(const WorldPart& part, std::span<const PatchId> touched,
                         std::span<const PatchId> vanished);
  Status begin_views(std::span<ViewState> views, std::span<const ViewRequest> requests);
  Status fill_thresholds(std::span<ViewState> views);
  bool stand_still();
  std::uint32_t count_pages(std::uint32_t& seen);
  int kept_level(const ViewState& view, PatchId patch) const;
  void govern();
  void fill_curve(DemandCurve& curve) const;
  void outdate(PatchId patch, GridRows rows);
  std::uint32_t find_pages(PatchId patch);
  bool remake(PatchId patch, PatchUpload& upload, Status& status);
  bool make_anew(PatchId patch, int level, PatchUpload& upload, Status& status);
  bool make_plain(PatchId patch, PatchUpload& upload, Status& status);
  bool next_stretch(PatchUpload& upload, Status& status);
  Status hold_heights(PatchId patch, int level);
  // of: the level of the surface that vertices are taken of.
  bool make_resident(PatchId patch, int level, int of, PatchUpload& upload, Status& status);
  PatchUpload upload_of(PatchId patch) const;
  ViewState* most_urgent_view();
  bool generate_ahead(PatchUpload& upload, Status& status);
  int wanted_ahead(PatchId patch) const;

  Config config_;
  Blocks blocks_;
  World* world_ = nullptr;
  World::Lent lent_;
  PatchScratch* patch_scratch_ = nullptr;
  ShadingSkips shading_skips_;  // what shading() was found with
  ResidentPool pool_;
  ThresholdSets thresholds_;
  Governor governor_;
  std::span<ViewState> views_;  // of the last select()
  bool cuts_ = true;            // of the last select()
  std::array<Seen, kMostViews> seen_{};
  double least_weight_ = 1;
  Turns turns_;
  Remade remade_;
};

}  // namespace karst::core
