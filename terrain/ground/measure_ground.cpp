// SPDX-License-Identifier: MIT
#include "terrain/ground/measure_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "terrain/base/check.h"
#include "terrain/ground/ground_box.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Of what is kept from size to size, which is rounded up to halves, 2^-10, in each.
constexpr double kSlack = 1.002;
constexpr double kKept = 1.0 - kNodeMorphShare;
constexpr auto kOverKept = static_cast<float>(1.0 / kKept);
// What sums of floats lose of a deviation at most, and steps that they lose of heights (2^27 steps, 24 bits).
constexpr double kFloatSums = 1.0 + 1e-5;
// Where a point is measured from the vertex that is not the nearer one, it is for this factor at least.
constexpr float kSwitch = 1.03f;
// A point of the full surface is as far from its reference as that strays; G times that over the least k.
constexpr float kStrayOverDemand = static_cast<float>(kSteepest / kLeastDemand);

bool is_power_of_two(double value) {
  int exponent = 0;
  return std::frexp(value, &exponent) == 0.5;
}

double length(double x, double y, double z) {
  return std::sqrt(x * x + y * y + z * z);
}

struct Span {
  double low, high;

  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

double square(double x) {
  return x * x;
}

// Which band a point is in whose squared distance is known.
class Bands {
 public:
  explicit Bands(const double (&side)[2]) {
    for (std::size_t n = 0; n < reach_.size(); ++n)
      reach_[n] = static_cast<float>(square(kBandReach[n]) * (square(side[0]) + square(side[1])));
  }
  void take(std::array<float, kBands>& most, float deviation, float squared) const {
    std::size_t band = 0;
    for (const float reach : reach_) band += squared > reach ? 1 : 0;
    most[band] = std::max(most[band], deviation);
  }

 private:
  std::array<float, kBands - 1> reach_;
};

// The least and the greatest of deviations.
struct Reach {
  float low, high;
  static Reach of(double value) { return {static_cast<float>(value), static_cast<float>(value)}; }
  void take(const Reach& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
  float most(float under, float over) const { return std::max(-(low + under), high + over); }
};

// A vertex of the reference, or several: the full surface less the size's own, and less the state in which a
// middle or the centre alone has arrived; squared distances from the middle and the centre; of a vertex also
// the least and the greatest with a middle alone on its way.
struct Point {
  Reach home, middle_alone, centre_alone;
  float to_middle, to_centre;
  float low_edge, high_edge;

  void take(const Point& other) {
    home.take(other.home);
    middle_alone.take(other.middle_alone);
    centre_alone.take(other.centre_alone);
    to_middle = std::max(to_middle, other.to_middle);
    to_centre = std::max(to_centre, other.to_centre);
  }
};

// Where the reference's vertices lie in a quad: the same for all quads of a size.
class Lattice {
 public:
  struct Place {
    float at_corner, at_middle, at_centre;  // weights in its child triangle
    float to_middle, to_centre;             // squared, as seen from above
    std::uint8_t edge;                      // of the middle
    std::uint8_t beside;                    // on a diagonal the other edge that it lies at, else the same
    std::uint8_t corner;                    // 2 edge, and 1 for the edge's second corner
  };

  Lattice(int along, const double (&side)[2]) : quads_(along) {
    const double scale = 2.0 / along;
    for (int k = 0; k <= along; ++k) {
      const double v = k * scale - 1.0;
      for (int i = 0; i <= along; ++i) {
        const double u = i * scale - 1.0;
        const bool to_side = std::abs(u) >= std::abs(v);
        const int edge = to_side ? (u < 0 ? 0 : 2) : (v > 0 ? 1 : 3);
        const double out = to_side ? std::abs(u) : std::abs(v);
        const double along_edge = to_side ? (edge == 0 ? v : -v) : (edge == 1 ? u : -u);
        const double at_corner = std::abs(along_edge);
        const auto to_middle = [&](int e) {
          return square((std::abs(u) - (e % 2 == 0 ? 1.0 : 0.0)) * side[0]) +
                 square((std::abs(v) - (e % 2 == 0 ? 0.0 : 1.0)) * side[1]);
        };
        const int beside = out > at_corner ? edge : v > 0 ? 1 : 3;
        places_[static_cast<std::size_t>(k * (kMostReferenceRows + 1) + i)] = {
            static_cast<float>(at_corner),
            static_cast<float>(out - at_corner),
            static_cast<float>(1.0 - out),
            static_cast<float>(std::max(to_middle(edge), to_middle(beside))),
            static_cast<float>(square(u * side[0]) + square(v * side[1])),
            static_cast<std::uint8_t>(edge),
            static_cast<std::uint8_t>(beside),
            static_cast<std::uint8_t>(2 * edge + (along_edge < 0 ? 0 : 1))};
      }
    }
  }
  int quads() const { return quads_; }
  const Place* row(int k) const { return places_.data() + k * (kMostReferenceRows + 1); }

 private:
  int quads_;
  std::array<Place, (kMostReferenceRows + 1) * (kMostReferenceRows + 1)> places_;
};

// A quad of a size within the rows of its reference grid.
class QuadMeasure {
 public:
  QuadMeasure(const MeasureQuads& job, const Lattice& lattice, const Bands& bands, std::int64_t x)
      : job_(job),
        lattice_(lattice),
        bands_(bands),
        x_(x),
        quads_(1 << (job.size - reference_size(job.size))),
        first_(x * quads_) {}

  void run() const {
    const auto at = static_cast<std::size_t>(x_);
    const QuadRow& out = job_.out;
    std::int32_t low = std::numeric_limits<std::int32_t>::max();
    std::int32_t high = std::numeric_limits<std::int32_t>::min();
    const int wide = std::min<int>(quads_, reference_quads(0) - static_cast<int>(first_));
    const int deep = std::min<int>(quads_, reference_quads(1) - static_cast<int>(job_.k * quads_));
    for (int k = 0; k < deep; ++k) {
      const QuadRow& row = job_.finer[static_cast<std::size_t>(k)];
      for (int i = 0; i < wide; ++i) {
        low = std::min(low, row.low[static_cast<std::size_t>(first_ + i)]);
        high = std::max(high, row.high[static_cast<std::size_t>(first_ + i)]);
      }
    }
    out.low[at] = low;
    out.high[at] = high;
    const GroundInfo& info = *job_.info;
    const bool whole =
        ((x_ + 1) << job_.size) <= info.samples[0] - 1 && ((job_.k + 1) << job_.size) <= info.samples[1] - 1;
    if (whole) {
      run_whole();
    } else {
      run_at_end(wide, deep);
    }
  }

 private:
  int reference_quads(int axis) const {
    return static_cast<int>(quads_along(*job_.info, axis, reference_size(job_.size)));
  }
  double height(int i, int k) const {
    return 2.0 * job_.heights[static_cast<std::size_t>(k)][static_cast<std::size_t>(first_ + i)];
  }
  float below(int i, int k) const {
    return job_.finer[static_cast<std::size_t>(k)].below[static_cast<std::size_t>(first_ + i)];
  }
  float above(int i, int k) const {
    return job_.finer[static_cast<std::size_t>(k)].above[static_cast<std::size_t>(first_ + i)];
  }

  // All states lie between two planes.
  void run_at_end(int wide, int deep) const {
    const auto at = static_cast<std::size_t>(x_);
    const GroundInfo& info = *job_.info;
    const int r = reference_size(job_.size);
    // Where the reference's vertices are, in samples.
    const auto place = [&](int axis, std::int64_t index) {
      return static_cast<double>(sample_of(info.samples[axis], r, index));
    };
    const double x0 = place(0, first_), z0 = place(1, job_.k * quads_);
    const double x1 = place(0, first_ + wide), z1 = place(1, job_.k * quads_ + deep);
    const double east = height(wide, 0) - height(0, 0) + height(wide, deep) - height(0, deep);
    const double south = height(0, deep) - height(0, 0) + height(wide, deep) - height(wide, 0);
    const double slope_x = east / (2.0 * (x1 - x0)), slope_z = south / (2.0 * (z1 - z0));
    Span band{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    double under = 0, over = 0;
    for (int k = 0; k <= deep; ++k) {
      const double dz = place(1, job_.k * quads_ + k) - z0;
      for (int i = 0; i <= wide; ++i) {
        const double dx = place(0, first_ + i) - x0;
        band.take(height(i, k) - slope_x * dx - slope_z * dz);
        if (i == wide || k == deep) continue;
        under = std::min(under, double{below(i, k)});
        over = std::max(over, double{above(i, k)});
      }
    }
    const double between = (band.high - band.low + over - under) * kFloatSums;
    const auto value = static_cast<float>(between);
    job_.out.below[at] = -value;
    job_.out.above[at] = value;
    for (const std::span<float> row : job_.out.most) row[at] = value;
    for (const std::span<float> row : job_.out.border) row[at] = value;
    job_.out.tall[at] = 2.0f * (static_cast<float>(job_.out.high[at]) - static_cast<float>(job_.out.low[at]));
  }

  // Vertex (i, k) of the children's: 0..2.
  double child(int i, int k) const { return height(i * quads_ / 2, k * quads_ / 2); }

  void run_whole() const {
    const auto at = static_cast<std::size_t>(x_);
    const bool even = ((x_ + job_.k) & 1) == 0;
    const double centre = child(1, 1);
    const double centre_target = even ? 0.5 * (child(0, 0) + child(2, 2)) : 0.5 * (child(2, 0) + child(0, 2));
    // By edge: west, south, east, north; the corners of an edge, its middle and the middle's target.
    const double corner[4][2] = {{child(0, 0), child(0, 2)},
                                 {child(0, 2), child(2, 2)},
                                 {child(2, 2), child(2, 0)},
                                 {child(2, 0), child(0, 0)}};
    const double middle[4] = {child(0, 1), child(1, 2), child(2, 1), child(1, 0)};
    double back[4];  // -way
    double target[4];
    for (int edge = 0; edge < 4; ++edge) {
      target[edge] = 0.5 * (corner[edge][0] + corner[edge][1]);
      back[edge] = middle[edge] - target[edge];
    }
    const double centre_back = centre - centre_target;
    // Whose middle is one of the node's border.
    const std::int64_t last[2] = {quads_along(*job_.info, 0, job_.size) - 1,
                                  quads_along(*job_.info, 1, job_.size) - 1};
    const bool outer[4] = {x_ % kNodeQuads == 0, job_.k % kNodeQuads == kNodeQuads - 1 || job_.k == last[1],
                           x_ % kNodeQuads == kNodeQuads - 1 || x_ == last[0], job_.k % kNodeQuads == 0};
    float least_home = 0, greatest_home = 0;
    std::array<float, kBands> most{};
    float border[4] = {};
    // Of a quad of size 1 the full surface is that of its children: halves of a triangle lie between points
    // that the reference has not.
    const bool exact = quads_ == 2;
    const int n = lattice_.quads();
    Point rows[2][kMostReferenceRows + 1];
    for (int k = 0; k <= n; ++k) {
      Point* const row = rows[k & 1];
      const Point* const before = rows[(k + 1) & 1];
      const Lattice::Place* const places = lattice_.row(k);
      for (int i = 0; i <= n; ++i) {
        const Lattice::Place& place = places[i];
        const double at_middle = double{place.at_middle}, at_centre = double{place.at_centre};
        const double own = double{place.at_corner} * corner[place.corner / 2][place.corner % 2] +
                           at_middle * middle[place.edge] + at_centre * centre;
        const double full = exact ? own : height(i, k);
        const double d = full - own;
        const double b = at_middle * back[place.edge];
        const double c = at_centre * centre_back;
        Point& p = row[i];
        // At the size itself both are at their targets.
        p.home = Reach::of(d + b + c);
        p.middle_alone = Reach::of(d + b);
        p.centre_alone = Reach::of(d + c);
        p.low_edge = static_cast<float>(d + std::min(0.0, b));
        p.high_edge = static_cast<float>(d + std::max(0.0, b));
        p.to_centre = place.to_centre + static_cast<float>(square(full - centre));
        p.to_middle = place.to_middle + static_cast<float>(std::max(square(full - middle[place.edge]),
                                                                    square(full - middle[place.beside])));
      }
      if (k == 0) continue;
      Point left = before[0];
      left.take(row[0]);
      // In quads of the reference from the quad's middle, the further side.
      const int far_row = std::max(n / 2 - k + 1, k - n / 2);
      for (int i = 0; i < n; ++i) {
        Point right = before[i + 1];
        right.take(row[i + 1]);
        Point all = left;
        all.take(right);
        left = right;
        const float under = exact ? below(i / 2, (k - 1) / 2) : below(i, k - 1);
        const float over = exact ? above(i / 2, (k - 1) / 2) : above(i, k - 1);
        least_home = std::min(least_home, all.home.low + under);
        greatest_home = std::max(greatest_home, all.home.high + over);
        const float both = all.home.most(under, over);
        const float middle_alone = all.middle_alone.most(under, over);
        const float centre_alone = all.centre_alone.most(under, over);
        // With the nearer one arrived, and at home: by the middle, by the centre.
        const float arrived[2] = {std::max(both, middle_alone), std::max(both, centre_alone)};
        const float at_home[2] = {kOverKept * centre_alone, kOverKept * middle_alone};
        const float way[2] = {all.to_middle, all.to_centre};
        // The edges in whose child triangles it lies: two on a diagonal.
        const int far_column = std::max(n / 2 - i, i + 1 - n / 2);
        const int beside = 2 * i < n ? 0 : 2, above_or_below = 2 * (k - 1) < n ? 3 : 1;
        const bool is_outer =
            (far_column >= far_row && outer[beside]) || (far_row >= far_column && outer[above_or_below]);
        std::size_t by = std::max(far_column, far_row) <= n / 4 ? 1 : 0;
        // The other one where that saves more than the way to it costs.
        if (kSwitch * std::max(arrived[1 - by], at_home[1 - by]) < std::max(arrived[by], at_home[by]))
          by = 1 - by;
        if (is_outer) by = 1;
        const float stray = kStrayOverDemand * std::max(-under, over);
        bands_.take(most, arrived[by] + stray, way[by]);
        bands_.take(most, at_home[by] + stray, std::max(way[0], way[1]) * (kOverKept * kOverKept));
        if (!is_outer) continue;
        // On a diagonal, where an edge's middle counts nothing, other edges' triangles may be, too.
        const auto take = [&](const Point& p, const Lattice::Place& place) {
          const float value = std::max(-(p.low_edge + under), p.high_edge + over);
          for (std::size_t edge = 0; edge < 4; ++edge) {
            if (outer[edge] && (place.edge == edge || !(place.at_middle > 0)))
              border[edge] = std::max(border[edge], value);
          }
        };
        for (int corner_i = i; corner_i <= i + 1; ++corner_i) {
          take(before[corner_i], lattice_.row(k - 1)[corner_i]);
          take(row[corner_i], places[corner_i]);
        }
      }
    }
    const auto keep = [](float value) { return static_cast<float>(double{value} * kFloatSums); };
    job_.out.below[at] = keep(least_home);
    job_.out.above[at] = keep(greatest_home);
    for (std::size_t band = 0; band < kBands; ++band) job_.out.most[band][at] = keep(most[band]);
    for (std::size_t edge = 0; edge < 4; ++edge) job_.out.border[edge][at] = keep(border[edge]);
    // Of a child: two middles and the centre with their targets, and a corner.
    double tall = 0;
    for (int edge = 0; edge < 4; ++edge) {
      const int next = (edge + 1) % 4;
      Span of{centre, centre};
      for (const double value :
           {centre_target, middle[edge], target[edge], middle[next], target[next], corner[edge][1]}) {
        of.take(value);
      }
      tall = std::max(tall, of.high - of.low);
    }
    job_.out.tall[at] = static_cast<float>((tall + double{greatest_home} - double{least_home}) * kFloatSums);
  }

  const MeasureQuads& job_;
  const Lattice& lattice_;
  const Bands& bands_;
  std::int64_t x_;
  int quads_;
  std::int64_t first_;
};

// Metres that what is drawn of a node of a curved basis may be off beside its deviation in height: a place is
// B + h U, base and up, h' being how far h is from the node's middle. At a place of a quad of the node B and
// the middle's part bend by E at most, in the state that is drawn (children's vertices lie in the quad or in
// its chords) and from the full surface; U differs from its middle's by no more than it turns, so that h' U
// differs from h' times that by half the node's heights times the turn, in each of the two.
double curved_error(const GroundInfo& info, int size, std::int32_t low, std::int32_t high, double stretch) {
  const double tall_m = (static_cast<double>(high) - low) * info.basis.height_unit_m;
  return 2 * bend_m(info.basis, size) * stretch + tall_m * std::min(2.0, bend_rad(info.basis, size));
}

}  // namespace

void measure_quads(std::span<const std::int32_t> north, std::span<const std::int32_t> south,
                   const QuadRow& out) {
  const std::size_t quads = out.low.size();
  KARST_ASSERT(north.size() == quads + 1 && south.size() == quads + 1);
  for (std::size_t x = 0; x < quads; ++x) {
    out.low[x] = std::min(std::min(north[x], north[x + 1]), std::min(south[x], south[x + 1]));
    out.high[x] = std::max(std::max(north[x], north[x + 1]), std::max(south[x], south[x + 1]));
  }
  for (const std::span<float> row : {out.below, out.above, out.tall}) std::fill(row.begin(), row.end(), 0.0f);
  for (const std::span<float> row : out.most) std::fill(row.begin(), row.end(), 0.0f);
  for (const std::span<float> row : out.border) std::fill(row.begin(), row.end(), 0.0f);
}

void MeasureQuads::run(std::int64_t first, std::int64_t last) const {
  const std::int64_t wide = quads_along(*info, 0, size);
  const double unit = std::ldexp(0.5, size);
  const double side[2] = {unit * info->steps[0], unit * info->steps[1]};
  const int quads = 1 << (size - reference_size(size));
  const Lattice lattice(std::max(quads, 4), side);
  const Bands bands(side);
  for (std::int64_t x = first; x < std::min(wide, last); ++x) QuadMeasure(*this, lattice, bands, x).run();
  for (std::int64_t x = std::max(wide, first); x < last; ++x) {
    const auto at = static_cast<std::size_t>(x);
    // Nodes do not look at them.
    out.low[at] = out.high[at] = 0;
    out.below[at] = out.above[at] = out.tall[at] = 0;
    for (const std::span<float> row : out.most) row[at] = 0;
    for (const std::span<float> row : out.border) row[at] = 0;
  }
}

void gather_nodes(const GroundInfo& info, int size, std::int64_t k, const QuadRow& quads,
                  const NodeRow& out) {
  const auto wide = static_cast<std::size_t>(quads_along(info, 0, size));
  const bool first_row = k % kNodeQuads == 0;
  const bool last_row = k % kNodeQuads == kNodeQuads - 1 || k == quads_along(info, 1, size) - 1;
  if (first_row) {
    std::fill(out.low.begin(), out.low.end(), std::numeric_limits<std::int32_t>::max());
    std::fill(out.high.begin(), out.high.end(), std::numeric_limits<std::int32_t>::min());
    for (const std::span<float> band : out.most) std::fill(band.begin(), band.end(), 0.0f);
    for (const std::span<float> row : out.border) std::fill(row.begin(), row.end(), 0.0f);
    std::fill(out.tall.begin(), out.tall.end(), 0.0f);
  }
  const auto raise = [](float& value, float other) { value = std::max(value, other); };
  for (std::size_t node = 0; node < out.low.size(); ++node) {
    const std::size_t begin = node * kNodeQuads;
    const std::size_t end = std::min(begin + kNodeQuads, wide);
    for (std::size_t x = begin; x < end; ++x) {
      out.low[node] = std::min(out.low[node], quads.low[x]);
      out.high[node] = std::max(out.high[node], quads.high[x]);
      if (size == 0) continue;
      for (std::size_t band = 0; band < kBands; ++band) raise(out.most[band][node], quads.most[band][x]);
      if (last_row) raise(out.border[1][node], quads.border[1][x]);
      if (first_row) raise(out.border[3][node], quads.border[3][x]);
      raise(out.tall[node], quads.tall[x]);
    }
    raise(out.border[0][node], quads.border[0][begin]);
    raise(out.border[2][node], quads.border[2][end - 1]);
  }
}

void MeasureNodes::run() const {
  if (size == 0) {
    std::fill(own->thresholds.begin(), own->thresholds.end(), std::uint16_t{0});
    return;
  }
  // Of the size's lattice.
  const double unit = std::ldexp(1.0, info->page_size(size));
  const double half = unit / 2;
  const bool curved = info->basis.is_curved();
  const double steps_per_m = kVertexStep / info->basis.height_unit_m;
  const bool on_lattice =
      is_power_of_two(info->steps[0]) && is_power_of_two(info->steps[1]) && !info->has_voxel_lattice();
  const int axes = on_lattice && !curved ? 1 : 3;
  const double rounding = std::sqrt(static_cast<double>(axes)) * 2 * unit;
  const double quads = std::ldexp(0.5, size);
  const double quad[2] = {quads * info->steps[0], quads * info->steps[1]};
  const std::size_t nodes = own->low.size();
  for (std::size_t x = 0; x < nodes; ++x) {
    std::array<double, kBands> most;
    for (std::size_t band = 0; band < kBands; ++band) most[band] = double{own->most[band][x]};
    double border = 0, others = 0;  // deviations along it, and from its other side
    for (const std::span<float> edge : own->border) border = std::max(border, double{edge[x]});
    double tall = double{own->tall[x]};
    const auto other_side = [&](const NodeRow* row, std::size_t at, std::size_t edge) {
      if (row == nullptr || at >= nodes) return;
      others = std::max(others, double{row->border[edge][at]});
      tall = std::max(tall, double{row->tall[at]});
    };
    const bool closes = info->closes();
    if (x > 0 || closes) other_side(own, x > 0 ? x - 1 : nodes - 1, 2);
    other_side(own, closes && x + 1 == nodes ? 0 : x + 1, 0);
    other_side(north, x, 1);
    other_side(south, x, 3);
    std::int32_t low = own->low[x], high = own->high[x];
    if (x == 0 && has_seam_inside(*info, {size, last_column(*info, size), 0})) {
      // By its threshold all of what lies to the west goes.
      for (const NodeRow* row : {own, north, south}) {
        if (row == nullptr) continue;
        for (std::size_t band = 0; band < kBands; ++band)
          most[band] = std::max(most[band], double{row->most[band].back()});
        for (const std::span<float> edge : row->border) border = std::max(border, double{edge.back()});
        tall = std::max(tall, double{row->tall.back()});
        low = std::min(low, row->low.back());
        high = std::max(high, row->high.back());
      }
    }
    // Beside each of those.
    double error = rounding;
    double stretch = 1, pad = 8 * unit;
    if (curved) {
      stretch = height_stretch(*info, low, high);
      pad = 16 * unit;
      if (bend_m(info->basis, size) > info->basis.most_bend_m) error = kInfinite;
      error += curved_error(*info, size, low, high, stretch) * steps_per_m / kKept;
    }
    const double reach = length(quad[0] * stretch, tall, quad[1] * stretch) + pad;
    const double diagonal = length(quad[0], 0, quad[1]) * stretch;
    const std::span<std::uint16_t> out = own->thresholds.subspan(x * kDemands, kDemands);
    double steps[kDemands];
    for (int n = 0; n < kDemands; ++n) {
      const double k = demand(n);
      steps[n] = (k * (border + error) + kSteepest * reach) / kKept;
      steps[n] = std::max(steps[n], k * (others + error) + kSteepest * reach);
      for (std::size_t band = 0; band < kBands; ++band) {
        const double within = band + 1 < kBands ? kBandReach[band] * diagonal + pad : reach / kKept;
        steps[n] = std::max(steps[n], k * (most[band] + error) + kSteepest * within);
      }
    }
    const NodeKey key{size, static_cast<std::int32_t>(first + static_cast<std::int64_t>(x)),
                      static_cast<std::int32_t>(z)};
    for (std::size_t k = 0; k < regions.size(); ++k) {
      const RegionMeasure& region = regions[k];
      if (in_region(info->regions()[k], key) != InRegion::part) continue;
      const double box_tall = 2 * (static_cast<double>(own->high[x]) - own->low[x]) + 8 * unit;
      const double wide = 2 * kNodeQuads;
      const double own_box = length(wide * quad[0] + 8 * unit, box_tall, wide * quad[1] + 8 * unit);
      const double change = kSteepest * (region.reach + own_box) * kSlack;
      for (int n = 0; n < kDemands; ++n)
        steps[n] = std::max(steps[n], demand(n) * region.error * kSlack + change);
    }
    for (const NodeRow* row : finer) {
      if (row == nullptr) continue;
      // From 2 x - 1 on.
      for (std::size_t past = 2 * x; past < 2 * x + 4; ++past) {
        std::size_t q = past - 1;
        if (past == 0 || q >= row->low.size()) {
          if (!closes) continue;
          q = past == 0 ? row->low.size() - 1 : 0;
        }
        const double q_tall = 2 * (static_cast<double>(row->high[q]) - row->low[q]) + 8 * half;
        const double rise = kSteepest * (curved ? 2 * node_radius(*info, row->low[q], row->high[q], size - 1)
                                                : length(kNodeQuads * quad[0] + 8 * half, q_tall,
                                                         kNodeQuads * quad[1] + 8 * half));
        for (int n = 0; n < kDemands; ++n) {
          const std::uint16_t finer_half = row->thresholds[q * kDemands + static_cast<std::size_t>(n)];
          // Where nothing of q ever moves there is nothing to keep.
          const double of_q = finer_half >= kNeverMorphs ? std::numeric_limits<double>::infinity()
                                                         : double{threshold_steps(finer_half)} * half;
          if (size > 1) steps[n] = std::max(steps[n], (of_q + rise) * kSlack / kKept + 8 * unit);
        }
      }
    }
    for (int n = 0; n < kDemands; ++n) {
      // The float is rounded down by less than the half is rounded up, but where it is a half already.
      const auto value = static_cast<float>(steps[n] / unit * (1.0 + 0x1p-22));
      out[static_cast<std::size_t>(n)] = threshold_half(value);
    }
  }
}

}  // namespace karst::core
