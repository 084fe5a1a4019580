// SPDX-License-Identifier: MIT
// What one eye sees of the ground: which nodes are drawn, at what size, and where their vertices morph, so
// that no drawn point is further than a stated number of pixels from the ground of size 0, nothing pops and
// nothing cracks. morph.h has the words: apparent distance rho, its steepest rise G, its share sigma (here
// kNodeMorphShare), the
// error scale S / error_px.
//
// Thresholds. A node p of size s >= 1 has one threshold, a function of k = S / error_px + 1 that is measured
// when the ground is made (NodeMeasure, demand.h, measure_ground.h), times f^s, f being 1 and what floats
// lose of distances. The vertices of p's family, even ones too, go from home to their targets, which are
// places of p's own vertices and midpoints between them, over the last sigma before D(p); on p's border
// before the least threshold of all nodes of p's size that share the vertex. p is split where its least rho
// is below D(p). With R(q) the most that rho changes in q's box,
//   (1)  D(p) >= k error + G reach / (1 - sigma)
//   (2)  (1 - sigma) D(p) >= D(q) + R(q)      for every q of size s - 1 that touches p
//
// What follows:
//  - A node that is not split has rho >= D(p) in all of its box. So all vertices that its family would
//    have, and those that a neighbour's family has on the common border, have arrived: the border is p's own,
//    by bits. So is all of p when it takes the family's place.
//  - Where q is split, some point of q's box has rho < D(q), so by (2) all of it has rho < (1 - sigma) D(p)
//    for every p of the next size that touches it: p is split, and q's own vertices there are at home. So
//    nodes that touch differ by one size at most, and the coarser one of two has its common vertices at home.
//  - Error: as in morph.h, with one more case less: in a triangle two vertices move at most, by the same
//    threshold or by that of a border.
//
// Of a curved basis the same holds with balls in the place of boxes (ground_box.h), R(q) being G times the
// ball's diameter, and deviations in space (measure_ground.h). Around a cube's corners there are seven nodes.
// What the ellipsoid's horizon hides counts as out of view.
//
// Of a ground that closes the nodes at its ends are neighbours. In one whose children are a western half
// alone the seam is the line in its middle: there, all of its family goes by the thresholds of those to the
// east, too, which are made for its error (measure_ground.h).
//
// Regions (ground.h). Thresholds of nodes that have one in part hold
//   (3)  D(p) >= k error + G (reach + R(p) / G)
// error being how far what is seen of the region is from the ground that stands for it, and reach the
// diagonal of a box of both. So where any point of the region has rho < k error, every such p is split: then
// the region is drawn, and nodes that it has all of are not. All borders of the region then lie between nodes
// that are drawn and it. Where such a node is drawn, too far away or for want of data, the ground is drawn
// closed, and the region is not: the ground of size 0 is within error_px of it, to which comes what the drawn
// ground is off by; or such a node was refused, and bound_px counts both. Each region is drawn or not
// whatever becomes of the others. A node at a border counts as in view where its piece of the belt may be,
// which reaches from its edge up or down to the region's rim.
//
// What is missing. A node is split only if its children's tile is there, the pool has room for its family,
// and all eight nodes of its size around it are there, drawn or split (or are out of view, or beyond the
// ground). One that should be and is not is *refused*: then its border has threshold 0 for all nodes that
// share it, so that their vertices have arrived there whatever their distance. A vertex that touches a
// refused node touches no family of a smaller size, since a neighbour of that size would not be there.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/draw/draw_list.h"
#include "terrain/ground/ground_box.h"
#include "terrain/lod/morph.h"
#include "terrain/lod/threshold_sets.h"
#include "terrain/nodes/family_pool.h"
#include "terrain/nodes/family_row.h"
#include "terrain/paging/tile_cache.h"
#include "terrain/view/camera.h"
#include "terrain/view/frustum.h"

namespace karst::core {

// What a view asks of the ground.
struct GroundRequest {
  const Camera* camera = nullptr;  // borrowed for the select()
  ErrorScale scale;                // make_error_scale's, for it
  double error_px = 4;             // that scale was made for
  bool morphing = true;            // false: nothing moves; neighbours of two sizes do not meet exactly
  // Not 0: nodes are split by their distance over their side, from so many sides on (S's split value,
  // distance / (width * detail * (1 + error)), but that the least demand's threshold is added for the error).
  // A sum of two thresholds that keep (2) below keeps it. Nothing is promised of the error then.
  double sides_away = 0;
  bool culls = true;  // what is out of the frustum is not listed, nor walls that face away
  // Null: the camera's. Else planes from the ground's corner; the camera is then only what distances are
  // from.
  const Frustum* frustum = nullptr;
  // Lattice steps that the eye moves a frame. Tiles that would come too late to be of use are not wanted.
  glm::dvec3 motion{0.0};
  std::uint32_t regions = 0;                // bit n: the patches of region n are there to be drawn
  int least_size = 0;                       // no finer one is drawn
  std::uint32_t most_splits = 0xffffffffu;  // nodes; what casts leaves families for what is seen
  // Lattice steps: nodes whose errors, and those around and within them, are not above this are not split,
  // whatever is asked.
  float spared_error = 0;
};

class GroundView {
 public:
  // A node of the tree that was looked at.
  struct Node {
    static constexpr std::int32_t kNotThere = -1;  // a coarser node is drawn there
    static constexpr std::int32_t kOutOfView = -2;
    static constexpr std::int32_t kOutside = -3;  // beyond the ground

    NodeKey key;
    float threshold = 0;                       // D, as its half says; steps of size 0. 0 of size 0
    float least_apparent = 0;                  // of its box. Both: where it is in view
    std::int32_t first_child = -1;             // the first of four, by quadrant; -1: not split
    std::uint32_t family = FamilyPool::kNone;  // of its children
    std::uint32_t parent_family = FamilyPool::kNone;
    std::int32_t around[8] = {};  // nodes of its size: over edges 0..3, at corners 0..3 (family_row.h)
    const Tile* tile = nullptr;   // its own
    const Tile* below = nullptr;  // its children's, where it is to be split
    std::uint16_t half = 0;       // threshold, as the GPU has it
    std::uint16_t touches = 0;    // bit n: region n that is asked for has some of it, or a border at it
    std::uint8_t planes = 0;      // that its box crosses: its children are inside of the others, too
    std::uint8_t walls = 0;       // node_walls()
    std::uint8_t nearest = 0;     // the quadrant over which the eye stands, or that is nearest to it
    bool in_view = false;
    bool refused = false;

    bool is_split() const { return first_child >= 0; }
  };

  struct Storage {
    std::span<Node> nodes;
    std::span<DrawItem> items;
    std::span<std::int32_t> item_nodes;  // by item: which of nodes
    std::span<std::uint16_t> rows;       // kMorphRow a row: the root's, then one a family

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t families = config.ground_families;
      const std::size_t most = families == 0 ? 0 : 4 * families + 1;
      visit(Consumer::ground, most, nodes);
      visit(Consumer::ground, most, items);
      visit(Consumer::ground, most, item_nodes);
      visit(Consumer::ground, families == 0 ? 0 : (families + 1) * kMorphRow, rows);
    }
  };

  struct Result {
    std::uint32_t drawn = 0;  // items
    std::uint32_t triangles = 0;
    std::uint32_t visited = 0;        // nodes looked at
    std::uint32_t split = 0;          // of them
    std::uint32_t culled = 0;         // of them, out of view
    std::uint32_t refused = 0;        // should be split
    std::uint32_t lacks_tile = 0;     // of them, for want of a tile
    std::uint32_t left_out = 0;       // of those, whose tile would come too late
    std::int32_t left_out_below = 0;  // the greatest size of which one was, plus 1; 0: none
    std::uint32_t lacks_room = 0;     // for want of a family
    std::int32_t least_size = 0;      // of what is drawn
    std::int32_t greatest_size = 0;
    std::uint32_t regions = 0;  // bit n: region n is drawn: nodes leave it out
    // No drawn point in front of the near plane is further from the ground of size 0: error_px, or more where
    // a node was refused; infinite where one is as near as its error.
    float bound_px = 0;
  };

  void create(const Storage& storage) { storage_ = storage; }
  // Forgets what the GPU has of rows.
  void reset() { known_rows_ = 0; }

  // Chooses what is drawn. Tiles that it lacks are wanted of the cache, families are taken from the pool:
  // those of all nodes that are split. Neither fails nor allocates. Precondition: the root's tile is in the
  // cache.
  void select(const GroundInfo& info, const GroundRequest& request, TileCache& tiles, FamilyPool& pool);

  const Result& result() const { return result_; }
  // Of what was selected and of its rows: the same where the same is drawn.
  std::uint64_t hash() const;
  // Nearest first, by and large. patch: 4 * family + quadrant, page of the family pages; level kNodeLevel.
  std::span<const DrawItem> items() const { return storage_.items.first(result_.drawn); }
  // That select() looks at.
  std::size_t most_nodes() const { return storage_.nodes.size(); }
  std::span<const Node> nodes() const { return storage_.nodes.first(node_count_); }
  // What an item draws, by its place among items().
  const Node& node_of(std::size_t item) const {
    return storage_.nodes[static_cast<std::size_t>(storage_.item_nodes[item])];
  }

  // Rows that the last select() changed: first row, halves; until there are none. Row 0 is the root's, row f
  // + 1 family f's.
  MorphRows take_rows();

 private:
  struct Looks;

  static unsigned facing_walls(const Looks& looks, double slack);
  bool add_roots(const Looks& looks, FamilyPool& pool);
  void add_children(const Looks& looks, std::int32_t parent);
  void link_children(const Looks& looks, std::int32_t parent);
  static std::int32_t around_at_seam(const Looks& looks, const Node& node, NodeKey child, std::size_t d,
                                     std::span<const std::int32_t> first);
  static void look_at_ball(const Looks& looks, Node& node);
  static void set_threshold(const Looks& looks, Node& node);
  static float least_apparent(const Looks& looks, const glm::dvec3& centre, double radius,
                              const glm::dvec3* half);
  static void look_at(const Looks& looks, const NodeBox& box, Node& node);
  void decide(Looks& looks, FamilyPool& pool, Node& node);
  void make_row(const Looks& looks, const Node& node);
  void store_row(std::uint32_t row, std::span<const std::uint16_t, kMorphRow> halves);
  std::uint32_t left_regions(const Looks& looks) const;
  void add_bound_of_closed(const Looks& looks, std::uint32_t bit);
  bool is_left_out(const Looks& looks, const Node& node) const;
  static std::uint16_t touched(const Looks& looks, std::uint32_t of_parent, NodeKey key);
  void list(const Looks& looks);

  Storage storage_;
  Result result_;
  std::uint32_t node_count_ = 0;
  std::uint32_t root_count_ = 0;
  std::uint32_t dirty_begin_ = 0;  // rows
  std::uint32_t dirty_end_ = 0;
  std::uint32_t known_rows_ = 0;  // 0: none was taken since reset()
};

}  // namespace karst::core
