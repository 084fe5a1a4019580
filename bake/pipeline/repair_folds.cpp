// SPDX-License-Identifier: MIT
// Folds are rare (design 4.4) and small: neighbouring rays that meet different sheets of a steep slope.
// Averaging the heights of the vertices concerned with those around them pulls the sheets together again.
// Passes look only at patches that changed in the last one. On features one voxel thin W can oppose the
// surface's normal; a triangle there counts as folded only when it is turned against its undisplaced self as
// well.
#include "bake/pipeline/repair_folds.h"

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

class Repair {
 public:
  explicit Repair(const RepairFolds& job)
      : job_(job),
        side_(patch_side(job.level)),
        patches_(job.surface.patches.begin(), job.surface.patches.end()),
        bare_patches_(patches_) {
    for (PatchId p = 0; p < patches_.size(); ++p) patches_[p].height_block = p;
    for (Patch& p : bare_patches_) p.height_block = kNoHeights;
    surface_ = {job.surface.volumes, patches_};
    bare_surface_ = {job.surface.volumes, bare_patches_};
  }

  RepairFolds::Result run() {
    RepairFolds::Result result;
    std::vector<PatchId> work(patches_.size());
    for (PatchId p = 0; p < work.size(); ++p) work[p] = p;
    std::vector<std::uint64_t> moved;
    std::uint64_t visits_left = job_.least_visits + job_.visits_per_patch * patches_.size();
    for (;; ++result.passes) {
      std::vector<std::uint64_t> marked;
      std::uint64_t folded = 0;
      for (const PatchId p : work) folded += find_folds(p, result.passes, marked);
      if (result.passes == 0) result.folded_before = folded;
      result.folded_after = folded;
      if (folded == 0 || result.passes == job_.max_passes || visits_left == 0) break;
      work = move(marked, result.passes);
      visits_left -= std::min<std::uint64_t>(visits_left, work.size());
      moved.insert(moved.end(), marked.begin(), marked.end());
    }
    std::sort(moved.begin(), moved.end());
    result.vertices_moved =
        static_cast<std::uint64_t>(std::unique(moved.begin(), moved.end()) - moved.begin());
    return result;
  }

 private:
  std::size_t block() const { return static_cast<std::size_t>(side_ * side_); }
  std::uint64_t key(GridVertex v) const {
    return std::uint64_t{v.patch} * block() + static_cast<std::size_t>(v.j * side_ + v.i);
  }
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

  glm::dvec3 normal(const std::vector<glm::ivec3>& positions, const GridVertex (&v)[3]) const {
    glm::dvec3 d[3];
    for (int k = 0; k < 3; ++k)
      d[k] = glm::dvec3(positions[static_cast<std::size_t>(v[k].j * side_ + v[k].i)]);
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

  // Appends the canonical keys of the vertices to move; returns the number of folded triangles.
  std::uint64_t find_folds(PatchId p, int pass, std::vector<std::uint64_t>& marked) {
    const Heights heights = {job_.level, job_.heights};
    positions_.resize(block());
    base_.resize(block());
    displaced_positions(surface_, heights, job_.level, p, positions_);
    displaced_positions(bare_surface_, {}, job_.level, p, base_);
    const int n = side_ - 1;
    std::uint64_t count = 0;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        // K's pattern (figure 3.27): the diagonal runs up where i + j is even.
        const GridVertex a{p, i, j}, b{p, i + 1, j}, c{p, i, j + 1}, d{p, i + 1, j + 1};
        const bool rising = (i + j) % 2 == 0;
        const GridVertex triangles[2][3] = {{a, b, rising ? d : c}, {rising ? a : b, d, c}};
        for (const auto& t : triangles) {
          if (!folded(p, t)) continue;
          ++count;
          const int ring = pass >= kWidenAfter ? 1 + (pass - kWidenAfter) / kWidenAfter : 0;
          for (const GridVertex& v : t) mark_around(v, std::min(ring, 3), marked);
        }
      }
    }
    return count;
  }

  void mark_around(GridVertex v, int ring, std::vector<std::uint64_t>& marked) const {
    for (int j = std::max(0, v.j - ring); j <= std::min(side_ - 1, v.j + ring); ++j) {
      for (int i = std::max(0, v.i - ring); i <= std::min(side_ - 1, v.i + ring); ++i) {
        marked.push_back(canonical({v.patch, i, j}));
      }
    }
  }

  // Mean height of a vertex's grid neighbours over all its copies.
  std::int16_t smoothed(GridVertex v, int pass) const {
    std::int64_t sum = 0;
    std::int64_t count = 0;
    for_each_copy(patches_, job_.level, v, [&](GridVertex copy) {
      for (int j = std::max(0, copy.j - 1); j <= std::min(side_ - 1, copy.j + 1); ++j) {
        for (int i = std::max(0, copy.i - 1); i <= std::min(side_ - 1, copy.i + 1); ++i) {
          sum += job_.heights[key({copy.patch, i, j})];
          ++count;
        }
      }
    });
    // Undisplaced, no triangle is folded (a height field's may stand upright): heights that keep folding are
    // worn down.
    const std::int64_t worn = !job_.height_field && pass >= kWidenAfter ? sum * 3 / 4 : sum;
    return static_cast<std::int16_t>(worn / count);
  }

  // All marked vertices at once from the old heights. Returns the patches to look at again.
  std::vector<PatchId> move(std::vector<std::uint64_t>& marked, int pass) {
    std::sort(marked.begin(), marked.end());
    marked.erase(std::unique(marked.begin(), marked.end()), marked.end());
    std::vector<std::int16_t> value;
    value.reserve(marked.size());
    for (const std::uint64_t k : marked) value.push_back(smoothed(vertex(k), pass));
    std::vector<PatchId> touched;
    for (std::size_t m = 0; m < marked.size(); ++m) {
      for_each_copy(patches_, job_.level, vertex(marked[m]), [&](GridVertex copy) {
        job_.heights[key(copy)] = value[m];
        touched.push_back(copy.patch);
      });
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
  }

  const RepairFolds& job_;
  int side_;
  std::vector<Patch> patches_;
  std::vector<Patch> bare_patches_;  // the same without heights
  Surface surface_;
  Surface bare_surface_;
  std::vector<glm::ivec3> positions_;  // of the patch in hand, displaced
  std::vector<glm::ivec3> base_;       // and undisplaced
};

}  // namespace

Status RepairFolds::validate() const {
  if (level < 1 || level > kMaxLevel) return {StatusCode::invalid_argument, "level is out of 1..6", "level"};
  if (heights.size() != surface.patches.size() * static_cast<std::size_t>(patch_vertices(level))) {
    return {StatusCode::invalid_argument, "heights do not have one block a patch", "heights"};
  }
  if (max_passes < 1) return {StatusCode::invalid_argument, "max_passes is below 1", "max_passes"};
  return {};
}

RepairFolds::Result RepairFolds::run() const {
  return Repair(*this).run();
}

}  // namespace karst::bake
