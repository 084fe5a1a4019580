// SPDX-License-Identifier: MIT
// Worlds on curved bases: closed from space and from 2 m; places by longitude and latitude; queries along up.
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "terrain/shading/materials.h"
#include "tests/library/ground_file.h"
#include "tests/library/host.h"
#include "tests/support/curved_ground.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

Vec3 along(Vec3 from, Vec3 direction, double metres) {
  return {from.x + direction.x * metres, from.y + direction.y * metres, from.z + direction.z * metres};
}
Vec3 mixed(Vec3 a, double wa, Vec3 b, double wb, Vec3 c, double wc) {
  return {a.x * wa + b.x * wb + c.x * wc, a.y * wa + b.y * wb + c.y * wc, a.z * wa + b.z * wb + c.z * wc};
}
double distance(Vec3 a, Vec3 b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

// Heights by the place that a sample has, so that they fit over the edges of faces.
test::MemoryGround::Heights waves_over(const core::GroundInfo& info, double tall_m, double length_m) {
  return [info, tall_m, length_m](std::int64_t i, std::int64_t k) {
    const int face = info.is_cube() ? core::cube_home(info.basis.face_quads, i, k) : 0;
    const glm::dvec3 p = core::place_m(info.basis, {double(i), double(k), 0, face}) * (6.28 / length_m);
    const double share = std::sin(p.x) * std::sin(p.y + 1) + std::sin(p.z + 2);
    return static_cast<std::int32_t>(tall_m / info.basis.height_unit_m * share);
  };
}

class WorldsOnBases : public test::HostTest {
 protected:
  WorldsOnBases() : HostTest(kWidth, kHeight) {}

  void open_shape(const core::GroundInfo& shape, double tall_m, double length_m, bool deferred = false) {
    Needs needs;
    needs.queries = 1;
    if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    GlOptions options;
    options.shading = deferred ? Shading::deferred : Shading::forward;
    const test::MemoryGround ground(shape, waves_over(shape, tall_m, length_m));
    const double spacing_m = shape.basis.height_unit_m / core::kVertexStep * shape.steps[0];
    open(needs, {}, options, test::ground_file(ground, spacing_m));
  }
  World& world() { return *host_->world; }

  bool ground_at(Vec3 place, Hit& hit) {
    Query* query = nullptr;
    EXPECT_TRUE(world().take_query(query).ok());
    const bool found = query->ground(place, 1e5, Wait::for_file, hit);
    world().release(query);
    return found;
  }

  // Pixels that show what was there before a frame without sky.
  std::size_t holes(ViewState view, double near_m, double far_m, double fov_deg, double work_ms) {
    view.width_px = kWidth;
    view.height_px = kHeight;
    set_perspective(view, fov_deg, near_m, far_m);
    FrameResult result;
    return HostTest::holes(view, work_ms, result);
  }
};

// Red, and green from a height on, without shades of their own.
struct RedAndGreen {
  explicit RedAndGreen(float from_voxels) {
    set.count = 2;
    set.side = 16;
    std::strcpy(set.materials[0].name, "red");
    std::strcpy(set.materials[1].name, "green");
    set.materials[1].height_low = from_voxels;
    set.materials[1].height_soft = 1e-4f;
    textures.assign(core::texture_bytes(set), std::byte{128});
    for (int level = 0; level < core::texture_levels(set.side, core::TextureArray::far); ++level) {
      for (std::uint32_t m = 0; m < set.count; ++m) {
        const std::size_t last = core::texture_offset(set, core::TextureArray::far, level, m + 1);
        for (std::size_t at = core::texture_offset(set, core::TextureArray::far, level, m); at < last; ++at)
          textures[at] = static_cast<std::byte>(at % 4 == m || at % 4 == 3 ? 220 : 10);
      }
    }
  }
  core::MaterialSet set;
  std::vector<std::byte> textures;
};

// From space a few quads do, and however long their chords are, what lies on the ground is what its heights
// say.
TEST_F(WorldsOnBases, AWholePlanetTakesFewTriangles) {
  for (const bool deferred : {false, true}) {
    const core::GroundInfo shape = test::planet(512, core::kWgs84RadiusM);
    const double voxel_m = test::voxel_m(shape);
    // All of it 200 m high, a tenth of what the chords that are drawn bend, with some relief for the sizes.
    const auto high = static_cast<std::int32_t>(200 / shape.basis.height_unit_m);
    const test::MemoryGround ground(shape, [high](std::int64_t, std::int64_t) { return high; });
    const RedAndGreen colours(static_cast<float>(50 / voxel_m));
    core::WorldMaterials materials;
    materials.set = colours.set;
    materials.textures = colours.textures;
    Needs needs;
    if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    GlOptions options;
    options.shading = deferred ? Shading::deferred : Shading::forward;
    open(needs, {}, options,
         test::ground_file(ground, voxel_m / core::kStepsPerVoxel * shape.steps[0], {}, materials));
    for (const double height_m : {2e7, 6e6, 1.5e6, 4e5}) {
      const double latitude = height_m == 1.5e6 ? 90.0 : height_m == 6e6 ? 35.26 : height_m == 4e5 ? 80 : -10;
      Vec3 place;
      ASSERT_TRUE(world().from_geodetic({45, latitude, height_m}, place));
      const LocalAxes axes = world().axes_at(place);
      ViewState view;
      view.error_px = 4;
      view.eye = place;
      view.width_px = kWidth;
      view.height_px = kHeight;
      set_perspective(view, height_m > 1e7 ? 34 : 60, 0.2 * height_m, 2 * height_m + 1.4e7);
      ASSERT_TRUE(look_at(view, along(place, axes.up, -1), axes.north));
      const FrameResult result = test::draw_frame(*renderer_, picture_, {view});
      if (height_m == 2e7) {
        EXPECT_GT(result.triangles, 2'000u);
      }
      EXPECT_LT(result.triangles, 20'000u);
      EXPECT_LE(result.error_px[0], 4.0);
      const Pixels pixels = picture_.read();
      int green = 0, red = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const std::uint8_t* const p = pixels.at(x, y);
          green += p[1] > p[0] + 20 && p[1] > p[2] + 20 ? 1 : 0;
          red += p[0] > p[1] + 20 ? 1 : 0;
        }
      }
      EXPECT_GT(green, 2'000) << height_m << ' ' << deferred;
      EXPECT_EQ(red, 0) << height_m << ' ' << deferred;
    }
  }
}

TEST_F(WorldsOnBases, APlanetIsClosedFromSpaceAndFromTwoMetres) {
  for (const bool deferred : {false, true}) {
    open_shape(test::planet(128, core::kWgs84RadiusM), 4000, 3e6, deferred);
    ASSERT_EQ(world().info().basis, Basis::cube);
    std::mt19937 random(3);
    const auto between = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random);
    };
    for (int n = 0; n < 120; ++n) {
      // Poles, corners of faces at 35.26 degrees and odd multiples of 45, and anywhere.
      Geodetic at{between(-180, 180), between(-90, 90), 0};
      if (n % 4 == 1) at = {45.0 + 90 * (n % 3), 35.26, 0};
      if (n % 4 == 2) at = {between(-180, 180), n % 8 == 2 ? 89.99 : -89.99, 0};
      if (n % 4 == 3) at = {-135.0 + 90 * (n % 4), 0, 0};
      Vec3 place;
      ASSERT_TRUE(world().from_geodetic(at, place));
      Hit hit;
      ASSERT_TRUE(ground_at(place, hit)) << at.longitude_deg << ' ' << at.latitude_deg;
      const LocalAxes axes = world().axes_at(hit.place);
      ViewState view;
      view.error_px = std::exp2(between(-1, 4));
      const bool from_space = n % 2 == 0;
      const double height_m = from_space ? 2e7 : 2;
      view.eye = along(hit.place, axes.up, height_m);
      const double turn = between(0, 6.28);
      const Vec3 ahead = mixed(axes.east, std::cos(turn), axes.north, std::sin(turn), axes.up, 0);
      // While it is coarse the ground may be higher than the eye, which then waits.
      // From space its middle, which fills the picture; else down in front of the feet.
      const Vec3 look = from_space ? mixed(axes.up, -1, ahead, 0.05, axes.up, 0)
                                   : mixed(axes.up, -1.2, ahead, 1, axes.up, 0);
      ASSERT_TRUE(look_at(view, along(view.eye, look, 1), ahead));
      ASSERT_EQ(holes(view, from_space ? 1e7 : 0.1, from_space ? 4e7 : 1e6, from_space ? 12 : 40,
                      from_space && n % 3 != 0 ? 0.05 : 0),
                0u)
          << n << ' ' << at.longitude_deg << ' ' << at.latitude_deg << ' ' << deferred;
    }
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    close();
  }
}

TEST_F(WorldsOnBases, ACylindersInsideIsClosed) {
  const double radius_m = 500;
  const double around_m = 2 * 3.14159265358979323846 * radius_m;
  const std::int64_t side = 257;
  open_shape(test::tube(side, side, -radius_m, around_m / double(side - 1)), 10, 300);
  ASSERT_EQ(world().info().basis, Basis::cylinder);
  std::mt19937 random(4);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  for (int n = 0; n < 100; ++n) {
    Vec3 place;
    ASSERT_TRUE(world().from_projected({between(-0.4, 0.4) * around_m, between(-800, 800), 0}, place));
    Hit hit;
    ASSERT_TRUE(ground_at(place, hit));
    const LocalAxes axes = world().axes_at(hit.place);
    ViewState view;
    view.error_px = std::exp2(between(-1, 4));
    view.eye = along(hit.place, axes.up, std::exp2(between(1, 7)));
    const double turn = between(0, 6.28);
    const Vec3 ahead = mixed(axes.east, std::cos(turn), axes.north, std::sin(turn), axes.up, 0);
    ASSERT_TRUE(look_at(view, along(view.eye, mixed(axes.up, -1.5, ahead, 1, axes.up, 0), 1), ahead));
    ASSERT_EQ(holes(view, 0.5, 5000, 40, n % 2 == 0 ? 0 : 0.05), 0u) << n;
    // The axis is above everywhere.
    const Vec3 axis = world().to_world(along(place, world().axes_at(place).up, radius_m));
    EXPECT_NEAR(axis.x, 0, 1e-6);
    EXPECT_NEAR(std::abs(axis.y), radius_m, 1e-6);
  }
}

// What stands behind the sea's horizon and is lower than it is seen through all of the sea, wherever its own
// height is.
TEST_F(WorldsOnBases, TheSeaHidesWhatIsBehindItsHorizon) {
  const core::GroundInfo shape = test::region(129, 129, 10, 0.64, 0.01);
  const double spacing_m = shape.basis.height_unit_m / core::kVertexStep * shape.steps[0];
  core::WorldMaterials sea;
  sea.surroundings = {core::kHasWater, 0, 0, 0};
  // A sea 50 m deep; from 44 km on to the north there is land. 2 m above the sea all of it that is lower than
  // 119 m is hidden.
  const auto picture = [&](double land_m, bool deferred) {
    const test::MemoryGround ground(shape, [&](std::int64_t, std::int64_t k) {
      return static_cast<std::int32_t>((k < 24 ? land_m : -50) / shape.basis.height_unit_m);
    });
    Needs needs;
    needs.shadow_maps = 0;
    if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    GlOptions options;
    options.shading = deferred ? Shading::deferred : Shading::forward;
    open(needs, {}, options, test::ground_file(ground, spacing_m, {}, sea));
    ViewState view;
    view.width_px = kWidth;
    view.height_px = kHeight;
    const glm::dvec3 eye = core::place_m(shape.basis, {64, 64, 2, 0});
    view.eye = world().from_world({eye.x, eye.y, eye.z});
    const LocalAxes axes = world().axes_at(view.eye);
    EXPECT_TRUE(look_at(view, along(view.eye, axes.north, 1), axes.up));
    set_perspective(view, 2, 1, 2e5);
    view.error_px = 0.5;
    Target where;
    where.viewport = {0, 0, kWidth, kHeight};
    where.framebuffer = picture_.name();
    const FrameResult result = test::draw_frame(*renderer_, picture_, {view}, 0, &where);
    EXPECT_TRUE(result.complete);
    return picture_.read();
  };
  for (const bool deferred : {false, true}) {
    const Pixels open_sea = picture(-50, deferred), low = picture(90, deferred),
                 high = picture(1500, deferred);
    EXPECT_LE(test::share_beyond(open_sea, low, 3), 0.001);
    // Above the horizon, which is 0.045 degrees below the middle, high land is seen.
    int above = 0, below = 0;
    for (int y = 0; y < kHeight; ++y) {
      const int off = std::abs(open_sea.at(kWidth / 2, y)[0] - high.at(kWidth / 2, y)[0]);
      if (y > kHeight / 2) above += off > 3;
      if (y < kHeight / 2 - 6) below += off > 3;
    }
    EXPECT_GT(above, 20);
    EXPECT_EQ(below, 0);
  }
}

// Around a cube the sea lies where the ground is low, on all faces alike: from space and from 2 m, on poles,
// edges and corners of faces.
TEST_F(WorldsOnBases, TheSeaLiesAroundAPlanetWhereItIsLow) {
  const core::GroundInfo shape = test::planet(128, core::kWgs84RadiusM);
  const double spacing_m = shape.basis.height_unit_m / core::kVertexStep * shape.steps[0];
  constexpr double kDeepM = -3000, kLandM = 900;
  core::WorldMaterials sea;
  sea.surroundings = {core::kHasWater, 0, 0, 0};
  // Within 55 degrees of the default sun, which is at 129, 35: the pole, edges of faces, a corner, and
  // inside.
  constexpr double kPlaces[][2] = {{135, 0},  {90, 45},     {180, 45}, {135, 35.264},
                                   {135, 90}, {135, 89.99}, {110, 20}};
  const auto pictures = [&](double ground_m, bool wet, bool deferred) {
    const test::MemoryGround ground(shape, [&](std::int64_t, std::int64_t) {
      return static_cast<std::int32_t>(ground_m / shape.basis.height_unit_m);
    });
    Needs needs;
    needs.shadow_maps = 0;
    if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    GlOptions options;
    options.shading = deferred ? Shading::deferred : Shading::forward;
    open(needs, {}, options, test::ground_file(ground, spacing_m, {}, wet ? sea : core::WorldMaterials()));
    std::vector<Pixels> all;
    for (const auto& at : kPlaces) {
      for (const bool from_space : {true, false}) {
        // Vertices are rounded to 19 m here: an eye on land stands well above them.
        const double height_m = from_space ? 6e6 : ground_m > 0 ? ground_m + 40 : 2;
        ViewState view;
        EXPECT_TRUE(world().from_geodetic({at[0], at[1], height_m}, view.eye));
        view.width_px = kWidth;
        view.height_px = kHeight;
        view.error_px = 1;
        set_perspective(view, from_space ? 28 : 40, from_space ? 1e6 : 0.5, from_space ? 2e7 : 1e6);
        const LocalAxes axes = world().axes_at(view.eye);
        // Level ahead, so that the horizon is in the middle; or straight down.
        const Vec3 ahead = from_space ? mixed(axes.up, -1, axes.north, 0, axes.up, 0) : axes.north;
        EXPECT_TRUE(look_at(view, along(view.eye, ahead, 1), from_space ? axes.north : axes.up));
        EXPECT_TRUE(test::draw_frame(*renderer_, picture_, {view}).complete);
        all.push_back(picture_.read());
      }
    }
    close();
    return all;
  };
  for (const bool deferred : {false, true}) {
    const std::vector<Pixels> deep = pictures(kDeepM, true, deferred),
                              bed = pictures(kDeepM, false, deferred),
                              land = pictures(kLandM, true, deferred),
                              dry = pictures(kLandM, false, deferred);
    for (std::size_t n = 0; n < deep.size(); ++n) {
      const bool from_space = n % 2 == 0;
      // Land above the sea is as it is without one.
      EXPECT_EQ(test::largest_difference(land[n], dry[n]), 0) << n << ' ' << deferred;
      // The sea, below the horizon: blue where the bed is not, but for the sun's glitter, and from space
      // without a line on faces' edges.
      int wet = 0, bluer = 0, most_step = 0;
      const int high = from_space ? kHeight : kHeight / 2 - 4;
      for (int y = from_space ? 0 : kHeight / 4; y < high; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const std::uint8_t* const p = deep[n].at(x, y);
          const std::uint8_t* const b = bed[n].at(x, y);
          ++wet;
          bluer += p[2] - p[0] > b[2] - b[0] + 10 ? 1 : 0;
          if (x > 0) most_step = std::max(most_step, std::abs(p[2] - deep[n].at(x - 1, y)[2]));
        }
      }
      EXPECT_GT(bluer, 0.8 * wet) << n << ' ' << deferred;
      if (from_space) {
        EXPECT_LE(most_step, 6) << n << ' ' << deferred;
      }
    }
  }
}

// A host's function: a torus, whose ring lies level.
struct Torus {
  double ring_m, tube_m;

  static const Torus& of(void* user) { return *static_cast<const Torus*>(user); }
  static Vec3 place(void* user, double u, double v, double height_m) {
    const Torus& t = of(user);
    const double a = u / (t.ring_m + t.tube_m), b = v / t.tube_m;
    const double out = t.ring_m + (t.tube_m + height_m) * std::cos(b);
    return {out * std::sin(a), -(t.tube_m + height_m) * std::sin(b), out * std::cos(a)};
  }
  static Vec3 up(void* user, double u, double v) {
    const Torus& t = of(user);
    const double a = u / (t.ring_m + t.tube_m), b = v / t.tube_m;
    return {std::cos(b) * std::sin(a), -std::sin(b), std::cos(b) * std::cos(a)};
  }
  static bool inverse(void* user, Vec3 p, double& u, double& v, double& height_m) {
    const Torus& t = of(user);
    const double out = std::hypot(p.x, p.z) - t.ring_m;
    u = std::atan2(p.x, p.z) * (t.ring_m + t.tube_m);
    v = std::atan2(-p.y, out) * t.tube_m;
    height_m = std::hypot(out, p.y) - t.tube_m;
    return height_m > -0.9 * t.tube_m;
  }
};

TEST_F(WorldsOnBases, AHostsFunctionSaysWhereAGroundLies) {
  Torus torus{3000, 1000};
  const GroundFunction function{Torus::place, Torus::up, Torus::inverse, &torus};
  const int wide = 513, deep = 257;
  const double spacing_m = 20;
  core::GroundInfo shape;
  shape.samples[0] = wide;
  shape.samples[1] = deep;
  shape.steps[0] = shape.steps[1] = core::kMostCurvedSteps;
  shape.basis.kind = core::BasisKind::function;
  for (int axis = 0; axis < 2; ++axis) {
    shape.basis.step[axis] = spacing_m;
    shape.basis.first[axis] = -0.5 * spacing_m * double(shape.samples[axis] - 1);
  }
  shape.basis.height_unit_m = spacing_m / core::kMostCurvedSteps * core::kVertexStep;
  const double across_m = std::hypot(spacing_m, spacing_m);
  shape.basis.function.turn_rad = across_m / torus.tube_m;
  shape.basis.function.sagitta_m = across_m * shape.basis.function.turn_rad / 8;
  ASSERT_TRUE(shape.basis.finish().ok());
  const auto heights = [&shape](std::int64_t i, std::int64_t k) {
    const double waves = std::sin(0.11 * double(i)) * std::cos(0.07 * double(k));
    return static_cast<std::int32_t>(60 * waves / shape.basis.height_unit_m);
  };
  const test::MemoryGround ground(shape, heights);
  const std::vector<std::byte> file = test::ground_file(ground, spacing_m);
  // Without it there is no world, and the error names the field.
  {
    test::MemoryFile bytes(file);
    Plan plan;
    ASSERT_TRUE(make_plan(bytes.source(), plan).ok());
    std::vector<std::byte> memory(plan.cpu_bytes + kMemoryAlignment);
    void* at = memory.data();
    std::size_t room = memory.size();
    std::align(kMemoryAlignment, plan.cpu_bytes, at, room);
    World* none = nullptr;
    const Status status =
        World::create(plan, bytes.source(), {static_cast<std::byte*>(at), plan.cpu_bytes}, none);
    EXPECT_STREQ(status.field(), "ground");
  }
  for (const bool deferred : {false, true}) {
    Needs needs;
    needs.queries = 1;
    if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    GlOptions options;
    options.shading = deferred ? Shading::deferred : Shading::forward;
    open(needs, {}, options, file, function);
    ASSERT_EQ(world().info().basis, Basis::function);
    std::mt19937 random(5);
    const auto between = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random);
    };
    for (int n = 0; n < 100; ++n) {
      // At samples, where the ground is as high as they are.
      const int i = static_cast<int>(between(40, wide - 40)), k = static_cast<int>(between(40, deep - 40));
      const double u = shape.basis.first[0] + spacing_m * i, v = shape.basis.first[1] + spacing_m * k;
      const double height_m = heights(i, k) * shape.basis.height_unit_m;
      Hit hit;
      ASSERT_TRUE(ground_at(world().from_world(Torus::place(&torus, u, v, height_m + 50)), hit)) << n;
      EXPECT_NEAR(distance(world().to_world(hit.place), Torus::place(&torus, u, v, height_m)), 0, 0.02) << n;
      const LocalAxes axes = world().axes_at(hit.place);
      const Vec3 up = Torus::up(&torus, u, v), towards = world().to_world(axes.up);
      EXPECT_NEAR(distance(up, towards), 0, 1e-6);
      ViewState view;
      view.error_px = std::exp2(between(-1, 4));
      view.eye = along(hit.place, axes.up, std::exp2(between(1, 6)));
      const double turn = between(0, 6.28);
      const Vec3 ahead = mixed(axes.east, std::cos(turn), axes.north, std::sin(turn), axes.up, 0);
      ASSERT_TRUE(look_at(view, along(view.eye, mixed(axes.up, -1.7, ahead, 1, axes.up, 0), 1), ahead));
      ASSERT_EQ(holes(view, 0.1, 1e5, 40, n % 3 == 0 ? 0.05 : 0), 0u) << n << ' ' << deferred;
    }
  }
}

TEST_F(WorldsOnBases, PlacesByLongitudeAndLatitudeComeBack) {
  const core::GroundInfo shape = test::region(257, 257, 7, 48, 1.0 / 1200);
  const auto heights = waves_over(shape, 800, 4000);
  open_shape(shape, 800, 4000);
  const WorldInfo& info = world().info();
  EXPECT_EQ(info.basis, Basis::geographic);
  EXPECT_TRUE(info.is_geodetic);
  EXPECT_FALSE(info.is_projected);
  for (int n = 0; n < 60; ++n) {
    const int i = 1 + n * 37 % 254, k = 1 + n * 53 % 254;
    const Geodetic at{7 + i / 1200.0, 48 - k / 1200.0, 5000};
    Vec3 place;
    ASSERT_TRUE(world().from_geodetic(at, place));
    Geodetic back;
    ASSERT_TRUE(world().to_geodetic(place, back));
    EXPECT_NEAR(back.longitude_deg, at.longitude_deg, 1e-12);
    EXPECT_NEAR(back.latitude_deg, at.latitude_deg, 1e-12);
    EXPECT_NEAR(back.altitude_m, at.altitude_m, 1e-6);
    // The ground under it, as far down as it says, at the sample's height but for a step of the lattice.
    Hit hit;
    ASSERT_TRUE(ground_at(place, hit)) << i << ' ' << k;
    ASSERT_TRUE(world().to_geodetic(hit.place, back));
    const double unit_m = shape.basis.height_unit_m;
    EXPECT_NEAR(back.altitude_m, heights(i, k) * unit_m, 1.5 * unit_m) << i << ' ' << k;
    EXPECT_NEAR(hit.distance, 5000 - back.altitude_m, 1e-3);
    EXPECT_NEAR(distance(along(place, world().axes_at(place).up, -hit.distance), hit.place), 0, 1e-3);
    // A ray that goes level over all of it meets nothing; one to the earth's middle the ground.
    Query* query = nullptr;
    ASSERT_TRUE(world().take_query(query).ok());
    EXPECT_TRUE(query->inside(along(hit.place, world().axes_at(place).up, -10), Wait::for_file));
    EXPECT_FALSE(query->inside(along(hit.place, world().axes_at(place).up, 10), Wait::for_file));
    world().release(query);
  }
  Projected projected;
  EXPECT_FALSE(world().to_projected({}, projected));
}

}  // namespace
}  // namespace karst
