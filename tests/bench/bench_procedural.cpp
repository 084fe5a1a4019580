// SPDX-License-Identifier: MIT
// What a vertex of a procedural surface takes: six octaves alone, and with eight features, in tiles of 65^2.
#include <cstdio>
#include <vector>

#include "terrain/procedural/procedural_surface.h"
#include "tests/bench/bench.h"

namespace karst::core {
namespace {

int run_procedural(bool smoke) {
  constexpr int kSide = 65;
  const int tiles = smoke ? 2 : 16;
  const RiverPoint points[] = {{{-600, -500}, 10}, {{-100, 40}, 10}, {{200, -80}, 9}, {{900, 700}, 8}};
  std::vector<RiverPiece> pieces(river_pieces(points, 0.01, {}));
  river_pieces(points, 0.01, pieces);
  Feature river{FeatureKind::river, {100, 100}, 1300};
  river.width_m = 20;
  river.depth_m = 2;
  river.valley_m = 150;
  river.pieces = static_cast<std::uint32_t>(pieces.size());
  Feature dunes{FeatureKind::dunes, {300, 0}, 900, 8};
  dunes.wavelength_m = 60;
  std::vector<Feature> features{{FeatureKind::mountain, {0, 300}, 900, 300, 0.7},
                                {FeatureKind::mountain, {500, 300}, 800, 250, 0.4},
                                dunes,
                                river};
  for (int n = 0; n < 4; ++n) features.push_back({FeatureKind::hill, {150.0 * n, 90}, 700, 40});
  order_features(features);
  std::vector<std::uint32_t> near(2 * features.size() + pieces.size() + 1);
  std::vector<float> out(kSide * kSide);
  std::printf("procedural: tiles of %d x %d samples, %zu features, a river of %zu pieces; ns a vertex\n",
              kSide, kSide, features.size(), pieces.size());
  struct Way {
    const char* name;
    int octaves;
    bool features;
  };
  for (const Way& way :
       {Way{"six octaves", 6, false}, Way{"twelve octaves", 12, false}, Way{"and features", 6, true}}) {
    ProceduralSurface surface{5, {0, 30, 800, 0.5, way.octaves}, {}, {}};
    if (way.features) {
      surface.features = features;
      surface.pieces = pieces;
    }
    for (const double spacing_m : {0.2, 1.0, 16.0}) {
      const bench::Times times = bench::measure_cpu(smoke ? 1 : 41, [&] {
        for (int n = 0; n < tiles; ++n)
          procedural_heights(surface, {64 * (n % 4), 64 * (n / 4), 1, kSide, kSide, spacing_m}, near, out);
      });
      std::printf("  %-16s samples %4.1f m apart: %6.1f\n", way.name, spacing_m,
                  1e6 * times.median_ms / (tiles * kSide * kSide));
    }
  }
  return 0;
}

const bench::Register registered{{"procedural", run_procedural}};

}  // namespace
}  // namespace karst::core
