// SPDX-License-Identifier: MIT
// Folds are rare (design 4.4) and small: neighbouring rays that meet different sheets of a steep slope.
// Averaging the heights of the vertices concerned with those around them pulls the sheets together again.
// Passes look only at patches that changed in the last one. On features one voxel thin W can oppose the
// surface's normal; a triangle there counts as folded only when it is turned against its undisplaced self as
// well.
#include "bake/voxels/repair_folds.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/patch/displacement.h"
#include "terrain/patch/shared_vertices.h"

namespace karst::bake {
using namespace core;
namespace {

// After this many passes a folded triangle also moves the vertices around its own: its fold is wider than
// itself.
constexpr int kWidenAfter = 8;

// A set of numbers below a size: a bit each, and a list of those that are in.
class NumberSet {
 public:
  explicit NumberSet(std::size_t size) : words_((size + 63) / 64) {}

  void add(std::uint64_t n) {
    std::uint64_t& word = words_[n / 64];
    const std::uint64_t bit = std::uint64_t{1} << (n % 64);
    if ((word & bit) == 0) list_.push_back(n);
    word |= bit;
  }
  const std::vector<std::uint64_t>& list() const { return list_; }
  void clear() {
    for (const std::uint64_t n : list_) words_[n / 64] = 0;
    list_.clear();
  }

 private:
  std::vector<std::uint64_t> words_;
  std::vector<std::uint64_t> list_;
};

class Repair {
 public:
  explicit Repair(const RepairFolds& job)
      : job_(job),
        side_(patch_side(job.level)),
        patches_(job.surface.patches.begin(), job.surface.patches.end()),
        bare_patches_(patches_),
        positions_(block()),
        base_(block()),
        folded_(block()),
        around_(block()),
        marked_(patches_.size() * block()),
        touched_(patches_.size()) {
    for (PatchId p = 0; p < patches_.size(); ++p) patches_[p].height_block = p;
    for (Patch& p : bare_patches_) p.height_block = kNoHeights;
    surface_ = {job.surface.volumes, patches_};
    bare_surface_ = {job.surface.volumes, bare_patches_};
  }

  RepairFolds::Result run() {
    RepairFolds::Result result;
    for (std::uint64_t p = 0; p < patches_.size(); ++p) touched_.add(p);
    NumberSet moved(patches_.size() * block());
    std::uint64_t visits_left = job_.least_visits + job_.visits_per_patch * patches_.size();
    for (;; ++result.passes) {
      marked_.clear();
      std::uint64_t folded = 0;
      for (const std::uint64_t p : touched_.list()) folded += find_folds(PatchId(p), result.passes);
      if (result.passes == 0) {
        result.folded_before = folded;
        if (static_cast<double>(folded) > job_.most_folded * static_cast<double>(triangles())) {
          result.folded_after = folded;
          break;
        }
      }
      result.folded_after = folded;
      if (folded == 0 || result.passes == job_.max_passes || visits_left == 0) break;
      move(result.passes);
      visits_left -= std::min<std::uint64_t>(visits_left, touched_.list().size());
      for (const std::uint64_t k : marked_.list()) moved.add(k);
    }
    result.vertices_moved = moved.list().size();
    return result;
  }

 private:
  std::uint64_t triangles() const {
    return 2 * patches_.size() * static_cast<std::uint64_t>((side_ - 1) * (side_ - 1));
  }
  std::size_t block() const { return static_cast<std::size_t>(side_ * side_); }
  std::size_t in_block(int i, int j) const { return static_cast<std::size_t>(j * side_ + i); }
  std::uint64_t key(GridVertex v) const { return std::uint64_t{v.patch} * block() + in_block(v.i, v.j); }
  GridVertex vertex(std::uint64_t k) const {
    const int at = static_cast<int>(k % block());
    return {static_cast<PatchId>(k / block()), at % side_, at / side_};
  }

  // The vertex's key in the copy with the least one.
  std::uint64_t canonical(GridVertex v) const {
    std::uint64_t least = key(v);
    for_each_copy(patches_, job_.level, v, [&](GridVertex copy) { least = std::min(least, key(copy)); });
    return least;
  }

  // Calls visit(place in the block) for a vertex and those that are up to `ring` cells away.
  template <class Visitor>
  void for_each_around(int at_i, int at_j, int ring, Visitor&& visit) const {
    for (int j = std::max(0, at_j - ring); j <= std::min(side_ - 1, at_j + ring); ++j) {
      for (int i = std::max(0, at_i - ring); i <= std::min(side_ - 1, at_i + ring); ++i)
        visit(in_block(i, j));
    }
  }

  glm::dvec3 normal(const std::vector<glm::ivec3>& positions, const GridVertex (&v)[3]) const {
    glm::dvec3 d[3];
    for (int k = 0; k < 3; ++k) d[k] = glm::dvec3(positions[in_block(v[k].i, v[k].j)]);
    return glm::cross(d[1] - d[0], d[2] - d[0]);
  }

  bool folded(PatchId p, const GridVertex (&v)[3]) const {
    const glm::dvec3 n = normal(positions_, v);
    if (job_.height_field) return n.y <= 0 && glm::dot(n, n) > 0;
    if (glm::dot(n, normal(base_, v)) >= 0) return false;
    glm::dvec3 w(0.0);
    for (const GridVertex& g : v) w += base_point(surface_, job_.level, p, g.i, g.j).direction;
    return glm::dot(n, w) < 0;
  }

  // Marks the vertices to move; returns the number of folded triangles.
  std::uint64_t find_folds(PatchId p, int pass) {
    displaced_positions(surface_, {job_.level, job_.heights}, job_.level, p, positions_);
    if (!job_.height_field) displaced_positions(bare_surface_, {}, job_.level, p, base_);
    const int n = side_ - 1;
    std::uint64_t count = 0;
    folded_.clear();
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        // K's pattern (figure 3.27): the diagonal runs up where i + j is even.
        const GridVertex a{p, i, j}, b{p, i + 1, j}, c{p, i, j + 1}, d{p, i + 1, j + 1};
        const bool rising = (i + j) % 2 == 0;
        const GridVertex triangles[2][3] = {{a, b, rising ? d : c}, {rising ? a : b, d, c}};
        for (const auto& t : triangles) {
          if (!folded(p, t)) continue;
          ++count;
          for (const GridVertex& v : t) folded_.add(in_block(v.i, v.j));
        }
      }
    }
    const int ring = pass >= kWidenAfter ? std::min(1 + (pass - kWidenAfter) / kWidenAfter, 3) : 0;
    around_.clear();
    for (const std::uint64_t at : folded_.list()) {
      for_each_around(static_cast<int>(at) % side_, static_cast<int>(at) / side_, ring,
                      [&](std::size_t near) { around_.add(near); });
    }
    const std::uint64_t first = key({p, 0, 0});
    for (const std::uint64_t at : around_.list()) marked_.add(canonical(vertex(first + at)));
    return count;
  }

  // Mean height of a vertex's grid neighbours over all its copies.
  std::int16_t smoothed(GridVertex v, int pass) const {
    std::int64_t sum = 0;
    std::int64_t count = 0;
    for_each_copy(patches_, job_.level, v, [&](GridVertex copy) {
      const std::int16_t* const heights = job_.heights.data() + key({copy.patch, 0, 0});
      for_each_around(copy.i, copy.j, 1, [&](std::size_t near) {
        sum += heights[near];
        ++count;
      });
    });
    // Undisplaced, no triangle is folded (a height field's may stand upright): heights that keep folding are
    // worn down.
    const std::int64_t worn = !job_.height_field && pass >= kWidenAfter ? sum * 3 / 4 : sum;
    return static_cast<std::int16_t>(worn / count);
  }

  // All marked vertices at once from the old heights; touched_ are the patches to look at again.
  void move(int pass) {
    values_.clear();
    for (const std::uint64_t k : marked_.list()) values_.push_back(smoothed(vertex(k), pass));
    touched_.clear();
    auto value = values_.begin();
    for (const std::uint64_t k : marked_.list()) {
      for_each_copy(patches_, job_.level, vertex(k), [&](GridVertex copy) {
        job_.heights[key(copy)] = *value;
        touched_.add(copy.patch);
      });
      ++value;
    }
  }

  const RepairFolds& job_;
  int side_;
  std::vector<Patch> patches_;
  std::vector<Patch> bare_patches_;  // the same without heights
  Surface surface_;
  Surface bare_surface_;
  std::vector<glm::ivec3> positions_;  // of the patch in hand, displaced
  std::vector<glm::ivec3> base_;       // and undisplaced
  NumberSet folded_, around_;          // vertices in the block of the patch in hand
  NumberSet marked_;                   // canonical keys of the vertices to move in this pass
  std::vector<std::int16_t> values_;   // what they become
  NumberSet touched_;                  // patches to look at in the next pass
};

}  // namespace

Status RepairFolds::validate() const {
  if (level < 1 || level > kMaxLevel) return {StatusCode::invalid_argument, "level is out of 1..6", "level"};
  if (heights.size() != surface.patches.size() * static_cast<std::size_t>(patch_vertices(level))) {
    return {StatusCode::invalid_argument, "heights do not have one block a patch", "heights"};
  }
  if (!(most_folded >= 0 && most_folded <= 1))
    return {StatusCode::invalid_argument, "most_folded is out of 0..1", "most_folded"};
  if (max_passes < 1) return {StatusCode::invalid_argument, "max_passes is below 1", "max_passes"};
  return {};
}

RepairFolds::Result RepairFolds::run() const {
  return Repair(*this).run();
}

}  // namespace karst::bake
