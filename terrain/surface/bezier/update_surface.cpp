// SPDX-License-Identifier: MIT
// Both sides of the comparison are found by key: fresh volumes ascend by key, old ones have a table. Volumes
// need no table of their own, because each has a patch 0.
#include "terrain/surface/bezier/update_surface.h"

#include <algorithm>
#include <cstring>

#include "terrain/base/check.h"
#include "terrain/surface/bezier/case_tables.h"

namespace karst::core {
namespace {

bool inside(const CornerBox& box, glm::ivec3 at) {
  for (int axis = 0; axis < 3; ++axis) {
    if (at[axis] < box.low[axis] || at[axis] > box.high[axis]) return false;
  }
  return true;
}

glm::ivec3 corner_of(const Volume& v) {
  return {v.corner[0], v.corner[1], v.corner[2]};
}

bool looks_alike(const Volume& a, const Volume& b) {
  return a.configuration == b.configuration && std::memcmp(a.gradient, b.gradient, sizeof a.gradient) == 0;
}

}  // namespace

void SurfaceSlots::create(std::span<Volume> volumes, std::span<Patch> patches, PatchTable* table) {
  KARST_ASSERT(table->capacity() == patches.size());
  volumes_ = volumes;
  patches_ = patches;
  table_ = table;
  adopt(0, 0);
}

void SurfaceSlots::adopt(std::uint32_t volumes, std::uint32_t patches) {
  table_->clear();
  volume_end_ = volume_count_ = volumes;
  free_volume_ = kNoVolume;
  for (PatchId id = 0; id < patches; ++id) {
    PatchId slot = PatchTable::kNone;
    const Status status = table_->take(key_of(Surface{volumes_, patches_}, id), slot);
    KARST_ASSERT(status.ok() && slot == id);
    static_cast<void>(status);
  }
}

// A free volume holds the next free one in its gradients.
std::uint32_t SurfaceSlots::take_volume() {
  ++volume_count_;
  if (free_volume_ == kNoVolume) return volume_end_++;
  const std::uint32_t slot = free_volume_;
  std::memcpy(&free_volume_, volumes_[slot].gradient, sizeof free_volume_);
  return slot;
}

void SurfaceSlots::release_volume(std::uint32_t slot) {
  volumes_[slot] = Volume{};
  std::memcpy(volumes_[slot].gradient, &free_volume_, sizeof free_volume_);
  free_volume_ = slot;
  --volume_count_;
}

struct UpdateSurface::Counts {
  std::uint64_t volumes = 0;  // in use afterwards
  std::uint64_t patches = 0;
  std::uint64_t changes = 0;
  std::uint64_t before = 0;  // patches in the box
};

// Calls visit(slot) for the volumes in the box, before anything is changed. Looks at the box's corners or at
// all volumes, whichever is less. visit may release the volume.
template <class Visit>
void UpdateSurface::for_each_old(const Visit& visit) const {
  const std::span<const Volume> volumes = slots->volumes_.first(slots->volume_end_);
  const glm::ivec3 low = glm::ivec3(std::max(box.low.x, 1), std::max(box.low.y, 1), std::max(box.low.z, 1));
  const glm::ivec3 high =
      glm::ivec3(std::min(box.high.x, 1023), std::min(box.high.y, 1023), std::min(box.high.z, 1023));
  const auto side = [&](int axis) { return std::int64_t{std::max(high[axis] - low[axis] + 1, 0)}; };
  if (side(0) * side(1) * side(2) > static_cast<std::int64_t>(volumes.size())) {
    for (std::uint32_t slot = 0; slot < volumes.size(); ++slot) {
      if (volumes[slot].patch_count > 0 && inside(box, corner_of(volumes[slot]))) visit(slot);
    }
    return;
  }
  const auto at = [](int v) { return static_cast<std::uint32_t>(v); };
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const PatchId first = slots->table_->find(PatchKey::make(0, at(x), at(y), at(z), 0));
        if (first != PatchTable::kNone) visit(slots->patches_[first].volume);
      }
    }
  }
}

const Volume* UpdateSurface::fresh_volume(PatchKey key) const {
  const auto below = [](const Volume& v, PatchKey k) { return key_of(v, 0) < k; };
  const auto found = std::lower_bound(fresh.volumes.begin(), fresh.volumes.end(), key.of_volume(), below);
  return found != fresh.volumes.end() && key_of(*found, 0) == key.of_volume() ? &*found : nullptr;
}

UpdateSurface::Counts UpdateSurface::count() const {
  Counts counts;
  std::uint64_t old_volumes = 0;
  std::uint64_t old_patches = 0;
  for_each_old([&](std::uint32_t slot) {
    const Volume& old = slots->volumes_[slot];
    ++old_volumes;
    old_patches += old.patch_count;
    const Volume* now = fresh_volume(key_of(old, 0));
    // What vanishes, and of what stays what looks another way.
    const std::uint32_t kept = now == nullptr ? 0u : std::min(now->patch_count, old.patch_count);
    counts.changes += old.patch_count - kept;
    if (now != nullptr && !looks_alike(old, *now)) counts.changes += kept;
    counts.patches += kept;
  });
  counts.changes += fresh.patches.size() - counts.patches;  // what appears
  counts.before = old_patches;
  counts.volumes = slots->volume_count_ - old_volumes + fresh.volumes.size();
  counts.patches = slots->table_->size() - old_patches + fresh.patches.size();
  return counts;
}

void UpdateSurface::remove_old(Result& result) const {
  for_each_old([&](std::uint32_t slot) {
    const Volume old = slots->volumes_[slot];
    const Volume* now = fresh_volume(key_of(old, 0));
    const std::uint32_t kept = now == nullptr ? 0u : std::min(now->patch_count, old.patch_count);
    for (std::uint32_t c = kept; c < old.patch_count; ++c) {
      const PatchId id = slots->table_->find(key_of(old, c));
      slots->table_->release(id);
      slots->patches_[id] = Patch{};
      slots->patches_[id].volume = kNoVolume;
      slots->patches_[id].height_block = kNoHeights;
      changes[result.changes++] = {id, PatchChange::vanished};
      ++result.vanished;
    }
    if (now == nullptr) slots->release_volume(slot);
  });
}

// Slots for all that is fresh. Edges are linked afterwards, when all slots are known.
void UpdateSurface::put_patches(Result& result) const {
  for (std::size_t next = 0; next < fresh.patches.size();) {
    const Volume& volume = fresh.volumes[fresh.patches[next].volume];
    const PatchId old = slots->table_->find(key_of(volume, 0));
    const bool is_new = old == PatchTable::kNone;
    const std::uint32_t slot = is_new ? slots->take_volume() : slots->patches_[old].volume;
    const bool alike = !is_new && looks_alike(slots->volumes_[slot], volume);
    const bool reshaped = !is_new && slots->volumes_[slot].configuration != volume.configuration;
    slots->volumes_[slot] = volume;
    for (std::uint32_t c = 0; c < volume.patch_count; ++c, ++next) {
      PatchId id = slots->table_->find(key_of(volume, c));
      const bool appears = id == PatchTable::kNone;
      if (appears) {
        const Status status = slots->table_->take(key_of(volume, c), id);
        KARST_ASSERT(status.ok());  // counted before
        static_cast<void>(status);
      }
      const std::uint32_t block = appears ? kNoHeights : slots->patches_[id].height_block;
      slots->patches_[id] = fresh.patches[next];
      slots->patches_[id].volume = slot;
      slots->patches_[id].height_block = block;
      result.appeared += appears ? 1u : 0u;
      result.kept += appears ? 0u : 1u;
      if (appears || !alike) {
        changes[result.changes++] = {id, appears    ? PatchChange::appeared
                                         : reshaped ? PatchChange::reshaped
                                                    : PatchChange::changed};
      }
    }
  }
}

// Neighbours inside the box: from numbers to slots.
void UpdateSurface::link_inside(const Patch& fresh_patch, Patch& patch) const {
  for (int e = 0; e < 4; ++e) {
    const PatchEdge other = fresh_patch.neighbour[e];
    if (!other.exists()) continue;
    patch.neighbour[e] = PatchEdge::make(slots->table_->find(key_of(fresh, other.patch())), other.edge());
  }
}

// Curves on faces of the box: their other sides lie on volumes that extraction did not see.
void UpdateSurface::link_outside(const Volume& volume) const {
  const ConfigurationCase& own = kCaseTable[volume.configuration];
  for (std::size_t face = 0; face < 6; ++face) {
    glm::ivec3 at = corner_of(volume);
    at[static_cast<int>(face / 2)] += face % 2 == 0 ? -1 : 1;
    if (own.curve[face][0] == kNoCurve || inside(box, at)) continue;
    const auto key = [&](std::uint32_t c) {
      return PatchKey::make(0, static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y),
                            static_cast<std::uint32_t>(at.z), c);
    };
    const PatchId first = slots->table_->find(key(0));
    if (first == PatchTable::kNone) continue;  // the surface ends here: a side of the world
    const ConfigurationCase& theirs =
        kCaseTable[slots->volumes_[slots->patches_[first].volume].configuration];
    for (std::size_t curve = 0; curve < kFaceCurves; ++curve) {
      if (own.curve[face][curve] == kNoCurve) continue;
      const std::uint8_t mine = own.curve[face][curve];
      const std::uint8_t other = theirs.curve[face ^ 1u][curve];
      KARST_ASSERT(other != kNoCurve);
      const PatchId p = slots->table_->find(key_of(volume, mine >> 2));
      const PatchId q = slots->table_->find(key(other >> 2));
      slots->patches_[p].neighbour[mine & 3] = PatchEdge::make(q, other & 3);
      slots->patches_[q].neighbour[other & 3] = PatchEdge::make(p, mine & 3);
    }
  }
}

std::span<PatchId> UpdateSurface::list_lost(std::span<PatchId> out) const {
  std::size_t lost = 0;
  for_each_old([&](std::uint32_t slot) {
    const Volume& old = slots->volumes_[slot];
    const Volume* now = fresh_volume(key_of(old, 0));
    const bool stays = now != nullptr && now->configuration == old.configuration;
    for (std::uint32_t c = 0; c < old.patch_count && !stays; ++c)
      out[lost++] = slots->table_->find(key_of(old, c));
  });
  return out.first(lost);
}

Status UpdateSurface::check(std::uint32_t& patches_before) const {
  const Counts counts = count();
  patches_before = static_cast<std::uint32_t>(counts.before);
  return check(counts);
}

Status UpdateSurface::check(const Counts& counts) const {
  if (counts.volumes > slots->volumes_.size())
    return {StatusCode::limit_reached, "intersection volumes are used up", "max_volumes", counts.volumes};
  if (counts.patches > slots->patches_.size())
    return {StatusCode::limit_reached, "patches are used up", "max_patches", counts.patches};
  if (counts.changes > changes.size())
    return {StatusCode::limit_reached, "more patches change than the list has room for", "changes",
            counts.changes};
  return {};
}

Status UpdateSurface::run(Result& result) const {
  result = {};
  if (const Status status = check(count()); !status.ok()) return status;
  remove_old(result);
  put_patches(result);
  for (std::size_t p = 0; p < fresh.patches.size(); ++p) {
    const PatchKey key = key_of(fresh, static_cast<PatchId>(p));
    Patch& patch = slots->patches_[slots->table_->find(key)];
    link_inside(fresh.patches[p], patch);
  }
  for (const Volume& volume : fresh.volumes) link_outside(volume);
  return {};
}

}  // namespace karst::core
