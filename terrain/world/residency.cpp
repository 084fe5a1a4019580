// SPDX-License-Identifier: MIT
#include "terrain/world/residency.h"

#include <algorithm>
#include <bit>
#include <new>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// Patches a frame that generate_next() looks at beyond what the views lack.
constexpr std::uint32_t kAheadPatches = 256;
// Nearer by this factor, a patch is about to be needed: the camera gets there within a second or so.
constexpr float kAheadDistance = 0.85f;

constexpr std::array<std::uint32_t, kMaxLevel + 1> make_pages_at() {
  std::array<std::uint32_t, kMaxLevel + 1> pages{};
  for (int level = 1; level <= kMaxLevel; ++level) pages[static_cast<std::size_t>(level)] = slot_pages(level);
  return pages;
}
constexpr std::array<std::uint32_t, kMaxLevel + 1> kPagesAt = make_pages_at();

std::uint32_t pages_at(int level) {
  return kPagesAt[static_cast<std::size_t>(level)];
}

}  // namespace

void Residency::add_to(Budget& budget, const Config& config) {
  count_blocks<Blocks>(config, budget);
  ThresholdSets::add_to(budget, config);
}

Status Residency::create(const Config& config, Arena& arena) {
  config_ = config;
  world_ = nullptr;
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  pool_.create(blocks_.pool);
  return thresholds_.create(config, arena);
}

Status Residency::attach(World& world) {
  world_ = &world;
  lent_ = world.lend();
  views_ = {};
  governor_.reset();
  thresholds_.reset();
  if (const Status status = find_shading(); !status.ok()) return status;
  forget();
  return {};
}

void Residency::forget() {
  pool_.reset(world_->patch_count(), world_->base_level());
  for (ViewState& view : views_) view.clear_lacking();
  turns_.ahead_left = 0;
  turns_.fresh = 0;
  turns_.stale = turns_.plain = blocks_.stale.size();
  remade_ = {};
  std::fill(blocks_.stale.begin(), blocks_.stale.end(), std::uint64_t{0});
  std::fill(blocks_.reshaded.begin(), blocks_.reshaded.end(), std::uint64_t{0});
  std::fill(blocks_.plain.begin(), blocks_.plain.end(), std::uint64_t{0});
  thresholds_.forget_rows();
}

void Residency::outdate(PatchId patch, GridRows rows) {
  std::uint64_t& word = blocks_.stale[patch / 64];
  const std::uint64_t bit = std::uint64_t{1} << patch % 64;
  if ((word & bit) == 0) blocks_.stale_rows[patch] = {};
  word |= bit;
  blocks_.stale_rows[patch].join(rows);
  turns_.stale = std::min<std::size_t>(turns_.stale, patch / 64);
}

void Residency::follow_edit(std::span<const PatchId> touched, std::span<const GridRows> rows,
                            std::span<const PatchId> vanished) {
  KARST_ASSERT(rows.size() == touched.size());
  KARST_ASSERT(!blocks_.stale.empty());
  if (touched.empty() && vanished.empty()) return;
  const WorldPart& part = world_->part_of(touched.empty() ? vanished[0] : touched[0]);
  const FindPatchShading find = shading_job(part);
  for (const PatchId patch : vanished) {
    pool_.lower(patch, 0);
    find.run(patch - part.first);
  }
  for (std::size_t n = 0; n < touched.size(); ++n) {
    shade(part, find, touched[n] - part.first);
    if (pool_.level(touched[n]) > 0 && rows[n].any()) outdate(touched[n], rows[n]);
  }
  update_thresholds(part, touched, vanished);
  for (ViewState& view : views_) view.clear_lacking();
}

void Residency::follow_measures(PatchId patch) {
  const WorldPart& part = world_->part_of(patch);
  shade(part, shading_job(part), patch - part.first);
  update_thresholds(part, {&patch, 1}, {});
}

void Residency::follow_sky(std::size_t n) {
  const WorldPart& part = world_->parts()[n];
  const FindPatchShading find = shading_job(part);
  for (PatchId own = 0; own < find.out.size(); ++own) shade(part, find, own);
}

void Residency::follow_region(std::size_t n) {
  const WorldPart& part = world_->parts()[n];
  shading_job(part).run();
  take_scratch();
  thresholds_.reset();
  turns_.fresh |= std::uint32_t{1} << n;
  views_ = {};
  turns_.base = part.first;
}

// Pages carry shading. own: its number in the part.
void Residency::shade(const WorldPart& part, const FindPatchShading& find, PatchId own) {
  const auto bits = [](PatchShading s) { return std::uint32_t{s.needs} << 8 | s.material; };
  const std::uint32_t before = bits(find.out[own]);
  find.run(own);
  const PatchId patch = part.first + own;
  if (bits(find.out[own]) == before || pool_.level(patch) == 0) return;
  blocks_.reshaded[patch / 64] |= std::uint64_t{1} << patch % 64;
  turns_.stale = std::min<std::size_t>(turns_.stale, patch / 64);
}

void Residency::update_thresholds(const WorldPart& part, std::span<const PatchId> touched,
                                  std::span<const PatchId> vanished) {
  SetThresholds job;
  job.surface = part.surface;
  job.bounds = part.bounds;
  job.errors = part.level_errors;
  const std::span<PatchId> list = lend_list();
  std::size_t count = 0;
  for (const std::span<const PatchId> of : {touched, vanished}) {
    for (const PatchId patch : of) list[count++] = patch - part.first;
  }
  thresholds_.update(job, list, count, part.first, pool_);
}

// Lists pages of a patch that hold what may be other vertices; how many those are.
std::uint32_t Residency::find_pages(PatchId patch) {
  remade_ = {};
  remade_.patch = patch;
  std::uint32_t pages = 0;
  for (int m = 1; m <= pool_.level(patch); ++m) {
    const SlotRange range = vertices_of_rows(world_->info().level, m, blocks_.stale_rows[patch]);
    if (range.first == range.last) continue;
    const auto first = static_cast<std::uint32_t>(range.first) / kPageVertices;
    const std::uint32_t end = pages_for(static_cast<std::size_t>(range.last));
    if (remade_.count > 0 && first <= remade_.stretches[remade_.count - 1].end) {
      pages += end - std::min(end, remade_.stretches[remade_.count - 1].end);
      remade_.stretches[remade_.count - 1].end = end;
    } else {
      pages += end - first;
      remade_.stretches[remade_.count++] = {first, end};
    }
  }
  return pages;
}

// Where most pages of a patch change, or there is no room for others beside them, all of it is made anew.
bool Residency::remake(PatchId patch, PatchUpload& upload, Status& status) {
  const int held = pool_.level(patch);
  if (held == 0) return false;
  const std::uint32_t pages = find_pages(patch);
  if (pages == 0) return false;
  if (4 * pages <= 3 * pages_at(held) && pages <= pool_.free_pages()) {
    for (const Remade::Stretch& s : std::span(remade_.stretches).first(remade_.count))
      pool_.replace(patch, s.first, s.end - s.first);
    return next_stretch(upload, status);
  }
  return make_anew(patch, held, upload, status);
}

bool Residency::make_anew(PatchId patch, int level, PatchUpload& upload, Status& status) {
  remade_ = {};
  blocks_.reshaded[patch / 64] &= ~(std::uint64_t{1} << patch % 64);
  pool_.lower(patch, 0);
  for (; level > 0; --level) {
    if (make_resident(patch, level, upload, status)) return true;
    if (!status.ok()) return false;
  }
  return false;
}

// Places of a level's vertices are the same bits whatever level they are taken of, so borders still match.
bool Residency::make_plain(PatchId patch, PatchUpload& upload, Status& status) {
  const int held = pool_.level(patch);
  if (held == 0) return false;
  const std::uint64_t bit = std::uint64_t{1} << patch % 64;
  if ((blocks_.plain[patch / 64] & bit) == 0) blocks_.held[patch] = 0;
  blocks_.held[patch] = std::max(blocks_.held[patch], static_cast<std::uint8_t>(held));
  blocks_.plain[patch / 64] |= bit;
  turns_.plain = std::min<std::size_t>(turns_.plain, patch / 64);
  blocks_.reshaded[patch / 64] &= ~bit;
  remade_ = {};
  pool_.lower(patch, 0);
  for (int level = std::min(held, world_->base_level()); level > 0; --level) {
    if (make_resident(patch, level, level, upload, status)) return true;
    if (!status.ok()) return false;
  }
  return false;
}

bool Residency::has_plain() const {
  return std::any_of(blocks_.plain.begin() + static_cast<std::ptrdiff_t>(turns_.plain), blocks_.plain.end(),
                     [](std::uint64_t word) { return word != 0; });
}

bool Residency::next_stretch(PatchUpload& upload, Status& status) {
  if (remade_.next == remade_.count) return false;
  const int held = pool_.level(remade_.patch);
  if (remade_.stretches[remade_.count - 1].end > pages_at(held)) {  // it was lowered since
    remade_ = {};
    return false;
  }
  if (!remade_.in_room) {
    status = generate(remade_.patch, world_->info().level, held, blocks_.vertices);
    if (!status.ok()) return false;
    remade_.in_room = true;
  }
  const Remade::Stretch& stretch = remade_.stretches[remade_.next++];
  const std::size_t first = std::size_t{stretch.first} * kPageVertices;
  const auto all = static_cast<std::size_t>(patch_vertices(held));
  upload = upload_of(remade_.patch);
  upload.first_vertex = static_cast<int>(first);
  upload.vertices =
      blocks_.vertices.subspan(first, std::min(std::size_t{stretch.end} * kPageVertices, all) - first);
  return true;
}

bool Residency::remake_next(PatchUpload& upload, Status& status, std::uint32_t& most) {
  status = {};
  if (next_stretch(upload, status)) return true;
  if (!status.ok()) return false;
  const auto take = [](std::span<std::uint64_t> words, std::size_t at) {
    const int bit = std::countr_zero(words[at]);
    words[at] &= words[at] - 1;
    return static_cast<PatchId>(at * 64 + static_cast<std::size_t>(bit));
  };
  for (; turns_.stale < blocks_.stale.size(); ++turns_.stale) {
    while (blocks_.stale[turns_.stale] != 0) {
      const PatchId patch = take(blocks_.stale, turns_.stale);
      const std::uint64_t bit = std::uint64_t{1} << patch % 64;
      const bool was_plain = (blocks_.plain[patch / 64] & bit) != 0;
      bool made = false;
      if (most == 0) {
        made = make_plain(patch, upload, status);
      } else if (was_plain) {
        blocks_.plain[patch / 64] &= ~bit;
        const int level = std::max<int>(pool_.level(patch), blocks_.held[patch]);
        made = pool_.level(patch) > 0 && make_anew(patch, level, upload, status);
      } else {
        made = remake(patch, upload, status);
      }
      if (made && most > 0) --most;
      if (made) return true;
      if (!status.ok()) return false;
    }
    while (blocks_.reshaded[turns_.stale] != 0) {
      const PatchId patch = take(blocks_.reshaded, turns_.stale);
      if (pool_.level(patch) == 0) continue;
      upload = upload_of(patch);
      upload.first_vertex = patch_vertices(pool_.level(patch));
      return true;
    }
  }
  for (; turns_.plain < blocks_.plain.size(); ++turns_.plain) {
    while (blocks_.plain[turns_.plain] != 0 && most > 0) {
      const PatchId patch = take(blocks_.plain, turns_.plain);
      const int held = pool_.level(patch);
      if (held == 0) continue;
      --most;
      if (make_anew(patch, std::max<int>(held, blocks_.held[patch]), upload, status)) return true;
      if (!status.ok()) return false;
    }
    if (blocks_.plain[turns_.plain] != 0) return false;
  }
  return false;
}

Status Residency::set_shading_skips(const ShadingSkips& skips) {
  if (skips == shading_skips_) return {};
  shading_skips_ = skips;
  if (const Status status = find_shading(); !status.ok()) return status;
  forget();
  return {};
}

std::span<const PatchShading> Residency::shading() const {
  return blocks_.shading.first(world_->patch_count());
}

// Uses the memory that making vertices needs, and gives it back to that.
Status Residency::find_shading() {
  for (const WorldPart& part : world_->parts()) {
    if (part.patches() == 0) continue;
    const FindPatchShading find = shading_job(part);
    if (const Status status = find.validate(); !status.ok()) return status;
    find.run();
  }
  patch_scratch_ = make_patch_scratch(lent_.scratch);
  return {};
}

FindPatchShading Residency::shading_job(const WorldPart& part) const {
  FindPatchShading find;
  find.surface = part.surface;
  find.corner = part.corner;
  find.bounds = part.bounds;
  find.cones = part.shading_cones;
  find.materials = &world_->materials();
  find.overrides = part.of(world_->material_overrides());
  find.sky = part.sky;
  find.lights = world_->lights();
  find.skips = shading_skips_;
  find.out = part.of(blocks_.shading.first(world_->patch_count()));
  return find;
}

// --- Vertices

std::uint64_t Residency::height_groups_read() const {
  return lent_.cache == nullptr ? 0 : lent_.cache->groups_read();
}

Status Residency::hold_heights(PatchId patch, int level) {
  if (lent_.cache == nullptr) return {};
  const WorldPart& part = world_->part_of(patch);
  GenerateVertices generate;
  generate.surface = part.surface;
  generate.level = level;
  lent_.cache->begin();
  Status result;
  generate.for_each_block(patch - part.first, [&](std::uint32_t block) {
    if (result.ok()) result = lent_.cache->hold(block, world_->height_source());
  });
  return result;
}

Status Residency::generate(PatchId patch, int level, int emit_level, std::span<GpuVertex> out) {
  if (out.data() == blocks_.vertices.data()) remade_.in_room = false;
  KARST_ASSERT(patch < world_->patch_count());
  KARST_ASSERT(1 <= emit_level && emit_level <= level && level <= world_->info().level);
  if (const Status status = hold_heights(patch, level); !status.ok()) return status;
  const WorldPart& part = world_->part_of(patch);
  GenerateVertices generate;
  generate.surface = part.surface;
  generate.heights = lent_.cache == nullptr ? world_->heights() : lent_.cache->heights();
  generate.level = level;
  generate.emit_level = emit_level;
  generate.scratch = patch_scratch_;
  generate.run(patch - part.first, out, nullptr);
  return {};
}

bool Residency::make_resident(PatchId patch, int level, int of, PatchUpload& upload, Status& status) {
  const int old_level = pool_.level(patch);
  if (!pool_.raise(patch, level)) return false;
  status = generate(patch, of, level, blocks_.vertices);
  if (!status.ok()) {
    pool_.lower(patch, old_level);
    return false;
  }
  const int first = old_level == 0 ? 0 : patch_vertices(old_level);
  upload = upload_of(patch);
  upload.first_vertex = first;
  upload.vertices = blocks_.vertices.subspan(static_cast<std::size_t>(first),
                                             static_cast<std::size_t>(patch_vertices(level) - first));
  const WorldPart& part = world_->part_of(patch);
  if (old_level == 0) thresholds_.touch(part.surface, patch, upload.row, part.first);
  return true;
}

// Without vertices.
PatchUpload Residency::upload_of(PatchId patch) const {
  const WorldPart& part = world_->part_of(patch);
  const Volume& volume = part.surface.volume_of(patch - part.first);
  PatchUpload upload;
  upload.patch = patch;
  upload.row = pool_.row(patch);
  upload.origin = part.corner + glm::ivec3(volume.corner[0], volume.corner[1], volume.corner[2]);
  upload.shading = blocks_.shading[patch];
  return upload;
}

// --- What to make next

ViewState* Residency::most_urgent_view() {
  ViewState* best = nullptr;
  for (ViewState& view : views_) {
    if (!view.lacking_is_ordered()) view.order_lacking(pool_);
    const LackingPatch* const top = view.most_urgent();
    if (top != nullptr && (best == nullptr || less_urgent(*best->most_urgent(), *top))) best = &view;
  }
  return best;
}

bool Residency::generate_next(bool ahead, PatchUpload& upload, Status& status) {
  status = {};
  while (ViewState* const view = most_urgent_view()) {
    const LackingPatch next = view->pop_lacking();
    // Another view may want it finer: then it is made once.
    const int wanted = std::max<int>(next.wanted, pool_.needed(next.patch));
    // Where the whole need finds no room, a part of it may; in a full pool holes get the least that fills
    // them.
    const bool least = governor_.state().pool_full && pool_.level(next.patch) == 0;
    for (int level = least ? std::min(world_->base_level(), wanted) : wanted; level > pool_.level(next.patch);
         --level) {
      if (!pool_.make_room(next.patch, level)) continue;
      if (make_resident(next.patch, level, upload, status)) return true;
      if (!status.ok()) return false;
    }
  }
  return ahead && generate_ahead(upload, status);
}

// The level that a patch would have at the pictures' corners and a little nearer; base_level() where details
// of what is not seen would take the place of what is.
int Residency::wanted_ahead(PatchId patch) const {
  const int base = world_->base_level();
  if (governor_.state().pool_full) return pool_.keeps_base() ? base : 0;
  int wanted = base;
  for (const ViewState& view : views_) {
    if (view.settings().mode != LodMode::error) continue;
    const PatchLod& lod = thresholds_.lods(view.threshold_set())[patch];
    const LodEye& eye = view.eye_of(world_->part_number(patch));
    wanted = std::max(wanted, level_at(lod, least_apparent_distance(lod, eye) * kAheadDistance));
  }
  return wanted;
}

// Patches get their turn by number. What is out of view wants the level it would have at the picture's
// corner: turning the camera then finds it ready.
bool Residency::generate_ahead(PatchUpload& upload, Status& status) {
  const std::uint32_t spare = pool_.page_count() / 8;
  for (; turns_.ahead_left > 0; --turns_.ahead_left) {
    if (turns_.ahead >= world_->patch_count()) turns_.ahead = 0;
    const PatchId patch = turns_.ahead++;
    if (world_->is_free(patch)) continue;
    const int wanted = wanted_ahead(patch);
    const int held = pool_.level(patch);
    if (wanted <= held) continue;
    const std::uint32_t pages = pages_at(wanted) - pages_at(held);
    // A coarse version of everything comes before details of what is not seen yet.
    if (pages + (wanted > world_->base_level() ? spare : 0) > pool_.free_pages()) continue;
    if (!make_resident(patch, wanted, upload, status)) {
      if (!status.ok()) return false;
      continue;
    }
    --turns_.ahead_left;
    return true;
  }
  return false;
}

bool Residency::generate_base(PatchUpload& upload, Status& status, std::uint32_t& most) {
  status = {};
  const std::uint32_t patches = world_->patch_count();
  // Where not all find room no part waits for the last of its patches.
  if (!pool_.keeps_base() || pool_.resident() == patches - world_->free_patches()) {
    turns_.fresh = 0;
    return false;
  }
  std::uint32_t waits = 0;
  for (std::uint32_t looked = 0; looked < patches; ++looked) {
    if (turns_.base >= patches) turns_.base = 0;
    const PatchId patch = turns_.base++;
    if (pool_.level(patch) != 0 || world_->is_free(patch)) continue;
    const std::uint32_t part = std::uint32_t{1} << world_->part_number(patch) & turns_.fresh;
    if (part != 0 && most == 0) {
      waits |= part;
      continue;
    }
    if (part != 0) --most;
    return make_resident(patch, world_->base_level(), upload, status);
  }
  turns_.fresh = waits;
  return false;
}

// --- A frame

Status Residency::select(std::span<ViewState> views, std::span<const ViewRequest> requests, bool cuts) {
  views_ = {};
  cuts_ = cuts;
  if (views.size() != requests.size() || views.size() > config_.max_views) {
    return {StatusCode::invalid_argument, "not a request a view, or more than max_views", "views",
            views.size()};
  }
  Status limit;
  Status status = begin_views(views, requests);
  if (status.ok()) status = fill_thresholds(views);
  for (ViewState& view : views) {
    if (!status.ok()) break;
    status = view.choose(*world_, thresholds_.lods(view.threshold_set()), pool_.levels(), cuts,
                         blocks_.list_scratch);
    if (status.code() != StatusCode::limit_reached) continue;
    limit = status;
    status = {};
  }
  if (!status.ok()) {
    for (ViewState& view : views) view.clear();
    return status;
  }
  views_ = views;
  const bool by_error = std::any_of(views.begin(), views.end(), [](const ViewState& view) {
    return view.settings().mode == LodMode::error;
  });
  turns_.ahead_left = by_error ? std::min(kAheadPatches, world_->patch_count()) : 0;
  govern();
  return limit;
}

bool Residency::complete_selection() {
  // With a pool that is too small the governor may have chosen another error meanwhile.
  if (governor_.state().pool_full) return false;
  for (const ViewState& view : views_) {
    if (!view.is_held(pool_.levels())) return false;
  }
  for (ViewState& view : views_) view.set_complete();
  return true;
}

void Residency::retry_lacking() {
  release_kept_pages();
  for (ViewState& view : views_) view.restore_lacking();
}

Status Residency::begin_views(std::span<ViewState> views, std::span<const ViewRequest> requests) {
  least_weight_ = requests.empty() ? 1 : requests[0].weight;
  for (const ViewRequest& request : requests) least_weight_ = std::min(least_weight_, request.weight);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double scale = std::max(1.0, double{governor_.scale()} * (least_weight_ / requests[v].weight));
    if (const Status status = views[v].begin(*world_, requests[v], scale); !status.ok()) return status;
  }
  return {};
}

Status Residency::fill_thresholds(std::span<ViewState> views) {
  std::array<ThresholdSets::Key, kMostViews> keys;
  std::array<int, kMostViews> sets{};
  for (std::size_t v = 0; v < views.size(); ++v) {
    keys[v] = views[v].threshold_key();
    sets[v] = views[v].threshold_set();
  }
  thresholds_.assign(std::span(keys).first(views.size()), std::span(sets).first(views.size()), pool_.frame());
  for (std::size_t v = 0; v < views.size(); ++v) {
    views[v].set_threshold_set(sets[v]);
    std::array<SetThresholds, kMostRegions> jobs;
    const std::span<const WorldPart> parts = world_->parts();
    for (std::size_t n = 0; n < parts.size(); ++n) {
      jobs[n].scale = keys[v].scale;
      jobs[n].morphing = keys[v].morphing;
      jobs[n].max_level = keys[v].top_level;
      jobs[n].surface = parts[n].surface;
      jobs[n].bounds = parts[n].bounds;
      jobs[n].errors = parts[n].level_errors;
    }
    const Status status = thresholds_.fill(sets[v], std::span(jobs).first(parts.size()), pool_);
    if (!status.ok()) return status;
  }
  return {};
}

// Whether all views are those of the last select().
bool Residency::stand_still() {
  bool still = true;
  for (std::size_t v = 0; v < seen_.size(); ++v) {
    Seen seen;
    if (v < views_.size()) {
      const ViewState& view = views_[v];
      seen = {view.eye(), view.error_scale().pixels, view.wanted_error_px(), view.weight(),
              view.settings().top_level()};
    }
    still = still && seen == seen_[v];
    seen_[v] = seen;
  }
  return still;
}

// What is drawn coarser than it is held, because a neighbour lacks something, is kept as far as it is wanted:
// if the neighbour took its pages, the two would take them from each other for ever.
int Residency::kept_level(const ViewState& view, PatchId patch) const {
  const int held = pool_.level(patch);
  const int drawn = view.levels()[patch];
  if (held <= drawn || view.settings().mode != LodMode::error) return std::max(held, drawn);
  const PatchLod& lod = thresholds_.lods(view.threshold_set())[patch];
  return std::clamp(level_at(lod, least_apparent_distance(lod, view.eye_of(world_->part_number(patch)))),
                    drawn, held);
}

// Tells the pool what the views want, and adds up the pages for it; seen: patches. A patch that several views
// see counts once, at the most that one of them wants.
std::uint32_t Residency::count_pages(std::uint32_t& seen) {
  std::uint32_t pages = 0;
  std::uint32_t missing = 0;
  const auto count = [&](int before, int wanted) {
    seen += before == 0 ? 1 : 0;
    if (wanted > before) pages += pages_at(wanted) - pages_at(before);
  };
  pool_.begin_selection();
  for (const ViewState& view : views_) {
    missing += view.selection().lod.missing;
    if (&view == views_.data()) {
      pool_.see_first(view.items());
      seen += view.selection().list.drawn;
      for (int level = 1; level <= kMaxLevel; ++level) {
        pages += view.selection().list.at_level[level] * pages_at(level);
      }
    } else {
      for (const DrawItem& item : view.items()) count(pool_.see(item.patch, item.level), item.level);
    }
    for (const PatchId patch : view.cut()) {
      // Those alone that are listed.
      if (view.levels()[patch] >= pool_.level(patch) || pool_.needed(patch) == 0) continue;
      const int kept = kept_level(view, patch);
      count(pool_.see(patch, kept), kept);
    }
  }
  // What is missing has no row in the pool to note it in.
  const std::span<std::uint32_t> noted = blocks_.list_scratch.first(world_->patch_count());
  const bool notes = missing > 0 && (views_.size() > 1 || !cuts_);
  if (notes) std::fill(noted.begin(), noted.end(), 0u);
  // Without cuts it is listed.
  for (const ViewState& view : views_) {
    for (const DrawItem& item : view.items().first(notes && !cuts_ ? view.items().size() : 0)) {
      if (pool_.level(item.patch) == 0)
        noted[item.patch] = std::max<std::uint32_t>(noted[item.patch], item.level);
    }
  }
  for (const ViewState& view : views_) {
    for (const LackingPatch& patch : view.lacking()) {
      int before = pool_.see(patch.patch, patch.wanted);
      if (notes && pool_.level(patch.patch) == 0) {
        before = static_cast<int>(noted[patch.patch]);
        noted[patch.patch] = static_cast<std::uint32_t>(std::max<int>(before, patch.wanted));
      }
      count(before, patch.wanted);
    }
  }
  return pages;
}

// Raises the error that is aimed at while the views need more than the pool has (design 4.8).
void Residency::govern() {
  Governor::Load load;
  std::uint32_t seen = 0;
  load.pages = count_pages(seen);
  // One page a patch is taken whatever the error is.
  load.base = pool_.keeps_base() ? world_->patch_count() - world_->free_patches() : seen;
  load.pages += load.base - std::min(load.base, seen);
  load.page_count = pool_.page_count();
  load.still = stand_still();
  for (const ViewState& view : views_) {
    if (view.settings().mode != LodMode::error) continue;
    load.morphing = true;
    const double most = kMostErrorPx / view.wanted_error_px() * (view.weight() / least_weight_);
    load.most_scale = std::max(load.most_scale, static_cast<float>(most));
  }
  if (!governor_.note(load)) return;
  DemandCurve curve;
  fill_curve(curve);
  governor_.adjust(curve);
}

void Residency::fill_curve(DemandCurve& curve) const {
  const LevelErrors errors = world_->all_level_errors();
  for (const ViewState& view : views_) {
    if (view.settings().mode != LodMode::error) continue;
    const std::span<const PatchLod> lods = thresholds_.lods(view.threshold_set());
    const auto pixels = static_cast<float>(double{view.error_scale().pixels} / view.wanted_error_px());
    const auto weight = static_cast<float>(view.weight() / least_weight_);
    const auto add = [&](PatchId patch) {
      const LodEye& eye = view.eye_of(world_->part_number(patch));
      curve.add(errors, patch, lods[patch], least_apparent_distance(lods[patch], eye), pixels, weight,
                view.settings().top_level());
    };
    for (const DrawItem& item : view.items()) add(item.patch);
    for (const LackingPatch& patch : view.lacking()) {
      if (view.levels()[patch.patch] == 0) add(patch.patch);
    }
  }
  curve.finish();
}

}  // namespace karst::core
