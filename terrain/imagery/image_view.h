// SPDX-License-Identifier: MIT
// What one eye needs of the imagery, and the table by which its pixels find it.
//
// A pixel knows its place from the eye and how many texels it covers. Of size s it needs the tile that it
// lies in; the table has, for each size, a window of kImageWindow x kImageWindow tiles around the one that
// the eye is over, and in each place the layer that has the tile, or the nearest coarser one that there is:
//   bits 0..9   layer + 1; 0: no image is there
//   bits 10..15 how many sizes coarser its tile is
// On a plane a pixel's place among tiles follows from its place from the eye; on a curved basis from those of
// its triangle's samples, which the page table has (gles_shaders/terrain_vertex.glsl).
// Size s is looked up where a texel of it is at most a pixel, and one of s + 1 more; so a pixel of size s is
// within 2^s / (240 pixel) tiles' sides of the eye, which is inside of the window but for telescopes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/imagery/image_cache.h"
#include "terrain/nodes/forecast.h"
#include "terrain/nodes/ground_view.h"
#include "terrain/view/camera.h"

namespace karst::core {

inline constexpr int kImageWindow = 32;  // tiles a side
inline constexpr int kImageSizes = kMostSize + 1;
inline constexpr int kImageWindowTiles = kImageWindow * kImageWindow;

struct ImageRequest {
  const Camera* camera = nullptr;  // borrowed for the select()
  double pixel = 0;                // its side at distance 1, or in a parallel view everywhere, voxels
  // Of when what is asked for will have come: what is of no use then is not wanted. Null: nothing moves.
  const Forecast* forecast = nullptr;
};

// Where a view's pixels begin to look.
struct ImagePlace {
  std::int32_t centre[2] = {};  // the tile of size 0 that the windows lie around
  // Of a plane alone.
  float eye[2] = {};            // from its corner, in tiles of size 0
  float tiles_a_voxel[2] = {};  // of size 0
  float texels_a_voxel = 0;     // of size 0, along the axis that has fewer
  std::int32_t least_size = 0;
  std::int32_t top_size = 0;
  std::int32_t root_size = 0;  // image_top_size(): where the table begins
};

// Of a texel of a size, voxels along the axis that has more.
double texel_voxels(const GroundInfo& info, int size);
// How wide a pixel is on the nearest point of a box, voxels. eye: lattice steps from the ground's corner.
double pixel_voxels(const NodeBox& box, const glm::dvec3& eye, bool parallel, double pixel);

class ImageView {
 public:
  struct Storage {
    std::span<std::uint16_t> table;  // kImageWindowTiles a size, from 0 on

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t sizes = config.image_layers == 0 ? 0 : kImageSizes;
      visit(Consumer::imagery, sizes * kImageWindowTiles, table);
    }
  };
  struct Result {
    std::uint32_t visited = 0;   // tiles looked at
    std::uint32_t lacking = 0;   // of them, that exist and are not there
    std::uint32_t left_out = 0;  // of those, that would come too late
    // The most pixels that a texel covers where a finer tile exists and is not there; 0: nowhere.
    float coarsest_px = 0;
  };

  void create(const Storage& storage) { storage_ = storage; }
  // Forgets what the GPU has of the table.
  void reset();

  // Looks at what the view needs, and wants of the cache what it lacks. ground: what the view draws of it.
  void select(const GroundInfo& info, const ImageryInfo& imagery, const GroundView& ground,
              const ImageRequest& request, ImageCache& cache);
  const Result& result() const { return result_; }
  const ImagePlace& place() const { return place_; }

  // Brings the table up to what the cache has, at the eye of the last select().
  void make_table(const ImageCache& cache);
  // The next size whose part of the table changed since it was taken, and that part; -1: none.
  int take_size(std::span<const std::uint16_t>& part);

 private:
  Storage storage_;
  Result result_;
  ImagePlace place_;
  std::uint64_t made_version_ = 0;
  std::int32_t made_centre_[2] = {};
  bool made_ = false;
  std::uint32_t dirty_ = 0;  // a bit a size
};

}  // namespace karst::core
