// SPDX-License-Identifier: MIT
// Images over a ground: each pixel shows what they have where it is; memory is what was planned; no frame
// waits for a tile; what is missing, damaged or finds no room is drawn coarser and said.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/file/world_reader.h"
#include "tests/library/ground_file.h"
#include "tests/library/host.h"
#include "tests/support/curved_ground.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kWide = 240, kDeep = 200;  // samples of 10 m

using Colour = std::array<std::uint8_t, 4>;
constexpr Colour kSand{200, 170, 90, 255}, kWood{40, 80, 50, 255}, kNothing{0, 0, 0, 0};
constexpr double kSquare = 5;  // samples

bool is_sand(double column, double row) {
  return ((static_cast<int>(std::floor(column / kSquare)) + static_cast<int>(std::floor(row / kSquare))) &
          1) == 0;
}
Colour checker(double column, double row) {
  return is_sand(column, row) ? kSand : kWood;
}

std::vector<std::byte> flat_file(const test::GroundImages& images) {
  const test::MemoryGround ground(kWide, kDeep, 2048, 2048, [](std::int64_t, std::int64_t) { return 0; });
  return test::ground_file(ground, 10, images);
}
test::MemoryGround hilly() {
  return test::MemoryGround(kWide, kDeep, 2048, 2048, test::rough_heights());
}

class Images : public test::HostTest {
 protected:
  Images() : HostTest(kWidth, kHeight) {}

  ViewState view(Vec3 eye, Vec3 target) const {
    ViewState shown = test::looking(*host_->world, eye, target, kWidth, kHeight);
    set_perspective(shown, 60, 1, 20'000);
    return shown;
  }
  Pixels drawn(const std::vector<std::byte>& file, const GlOptions& options, Vec3 eye, Vec3 target) {
    Needs needs;
    if (options.shading == Shading::deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    open(needs, {}, options, file);
    Target where;
    where.viewport = {0, 0, kWidth, kHeight};
    where.framebuffer = picture_.name();
    const FrameResult result = test::draw_frame(*renderer_, picture_, {view(eye, target)}, 0, &where);
    EXPECT_TRUE(result.complete);
    EXPECT_EQ(result.lacking, 0u);
    Pixels pixels = picture_.read();
    close();
    return pixels;
  }
};

// Over level ground, a checker must look like one colour in some pixels and like the other in others, by
// where they are, near and far and where nodes are large.
TEST_F(Images, APixelShowsWhatLiesWhereItIs) {
  const std::vector<std::byte> both = flat_file({checker, 3});
  const std::vector<std::byte> sand = flat_file({[](double, double) { return kSand; }, 3});
  const std::vector<std::byte> wood = flat_file({[](double, double) { return kWood; }, 3});
  struct Look {
    Vec3 eye, target;
  };
  // 0.13 samples a texel; a pixel has 0.1, 1 and up to 3 samples.
  const Look looks[] = {{{1200, 120, 1000}, {1201, 0, 930}},
                        {{1200, 1100, 1000}, {1201, 0, 900}},
                        {{800, 300, 1500}, {1300, 0, 600}}};
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    GlOptions options;
    options.shading = shading;
    for (const Look& look : looks) {
      const Pixels of_both = drawn(both, options, look.eye, look.target);
      const Pixels of_sand = drawn(sand, options, look.eye, look.target);
      const Pixels of_wood = drawn(wood, options, look.eye, look.target);
      const auto unit = [](Vec3 v) {
        const double length = std::hypot(v.x, v.y, v.z);
        return Vec3{v.x / length, v.y / length, v.z / length};
      };
      const auto cross = [](Vec3 a, Vec3 b) {
        return Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
      };
      const Vec3 ahead =
          unit({look.target.x - look.eye.x, look.target.y - look.eye.y, look.target.z - look.eye.z});
      const Vec3 right = unit(cross(ahead, {0, 1, 0}));
      const Vec3 up = cross(right, ahead);
      const double tangent = std::tan(0.5 * 60 * 3.14159265358979 / 180);
      int compared[2] = {}, wrong = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const auto place = [&](double px, double py, double& column, double& row) {
            const double u = (2 * px / kWidth - 1) * tangent * kWidth / kHeight,
                         v = (2 * py / kHeight - 1) * tangent;
            const Vec3 ray{ahead.x + u * right.x + v * up.x, ahead.y + u * right.y + v * up.y,
                           ahead.z + u * right.z + v * up.z};
            if (ray.y >= -0.05) return false;
            const double away = look.eye.y / -ray.y;
            column = (look.eye.x + away * ray.x) / 10;
            row = (look.eye.z + away * ray.z) / 10;
            return column > 1 && row > 1 && column < kWide - 2 && row < kDeep - 2;
          };
          // A pixel of one colour, and those around it.
          double column = 0, row = 0;
          if (!place(x + 0.5, y + 0.5, column, row)) continue;
          const bool is = is_sand(column, row);
          bool pure = true;
          for (int k = 0; k < 9; ++k) {
            double c = 0, r = 0;
            const bool inside = place(x + 0.5 + 2 * (k % 3 - 1), y + 0.5 + 2 * (k / 3 - 1), c, r);
            pure = pure && inside && is_sand(c, r) == is && std::abs(c - column) < kSquare &&
                   std::abs(r - row) < kSquare;
          }
          if (!pure) continue;
          ++compared[is ? 1 : 0];
          const std::uint8_t* const shown = of_both.at(x, y);
          const std::uint8_t* const expected = (is ? of_sand : of_wood).at(x, y);
          for (int c = 0; c < 3; ++c) wrong += std::abs(shown[c] - expected[c]) > 3 ? 1 : 0;
        }
      }
      EXPECT_EQ(wrong, 0) << look.eye.y;
      EXPECT_GT(compared[0], 100) << look.eye.y;
      EXPECT_GT(compared[1], 100) << look.eye.y;
    }
  }
}

// On a curved basis, straight below the eye: at the equator, at 45 degrees, beside a pole and around the
// earth, where it closes, inside and outside of a cylinder.
TEST_F(Images, OnACurvedBasisTheyLieWhereSamplesDo) {
  struct Shape {
    const char* name;
    core::GroundInfo info;
  };
  const Shape shapes[] = {{"equator", test::region(100, 80, 12, 0.4, 0.01)},
                          {"45", test::region(100, 80, -170, 45.4, 0.01)},
                          {"pole", test::region(100, 80, 20, 89.99, 0.001)},
                          {"earth", test::region(361, 181, -180, 90, 1)},
                          {"cube", test::planet(64, 300'000)},
                          {"tube", test::tube(100, 80, 3'000, 10)},
                          {"inside", test::tube(100, 80, -3'000, 10)}};
  test::Random random{4};
  for (const Shape& shape : shapes) {
    const core::GroundInfo& info = shape.info;
    const test::MemoryGround ground(info, [](std::int64_t, std::int64_t) { return 0; });
    const double spacing_m = info.basis.height_unit_m / core::kVertexStep * info.steps[0];
    std::array<std::vector<std::byte>, 3> files;
    files[0] = test::ground_file(ground, spacing_m, {checker, 2});
    files[1] = test::ground_file(ground, spacing_m, {[](double, double) { return kSand; }, 2});
    files[2] = test::ground_file(ground, spacing_m, {[](double, double) { return kWood; }, 2});
    struct Place {
      int face;
      double column, row, height_m;
    };
    std::vector<Place> places;
    for (int n = 0; n < 24; ++n) {
      // A square of a face, or of all there is.
      const int face = info.is_cube() ? n % core::kCubeFaces : 0;
      int cell[2] = {};
      if (info.is_cube()) core::cube_cell(face, cell[0], cell[1]);
      const auto middle = [&](int axis) {
        const double side = info.is_cube() ? info.basis.face_quads : double(info.samples[axis] - 1);
        const int first = static_cast<int>(std::ceil(cell[axis] * side / kSquare));
        return (first + random.below(static_cast<int>(side / kSquare) - 1) + 0.5) * kSquare;
      };
      const double column = middle(0), row = middle(1);
      // A square covers some pixels, the narrow way too.
      const auto place = [&](double i, double k) { return core::place_m(info.basis, {i, k, 0, face}); };
      const double metres = std::min(glm::distance(place(column, row), place(column + 1, row)),
                                     glm::distance(place(column, row), place(column, row + 1)));
      places.push_back({face, column, row, metres * std::exp2(random.unit() * 6 - 1)});
    }
    std::array<std::vector<std::array<int, 3>>, 3> shown;
    for (std::size_t f = 0; f < files.size(); ++f) {
      open({}, {}, {}, files[f]);
      for (const Place& place : places) {
        const core::GridPlace below{place.column, place.row, 0, place.face};
        const core::GridPlace above{place.column, place.row, place.height_m, place.face};
        ViewState view;
        view.width_px = kWidth;
        view.height_px = kHeight;
        const auto world = [&](glm::dvec3 m) { return host_->world->from_world({m.x, m.y, m.z}); };
        view.eye = world(core::place_m(info.basis, above));
        const LocalAxes axes = host_->world->axes_at(view.eye);
        ASSERT_TRUE(look_at(view, world(core::place_m(info.basis, below)), axes.north));
        set_perspective(view, 20, 0.05 * place.height_m, 1e8);
        view.error_px = 1;
        const FrameResult result = test::draw_frame(*renderer_, picture_, {view}, 0);
        EXPECT_TRUE(result.complete);
        const std::uint8_t* const pixel = picture_.read().at(kWidth / 2, kHeight / 2);
        shown[f].push_back({pixel[0], pixel[1], pixel[2]});
      }
      close();
    }
    int sands = 0;
    for (std::size_t n = 0; n < places.size(); ++n) {
      if (shown[1][n][0] < 100) continue;  // night
      const bool is = is_sand(places[n].column, places[n].row);
      sands += is;
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        EXPECT_NEAR(shown[0][n][channel], shown[is ? 1 : 2][n][channel], 4)
            << shape.name << " " << places[n].column << " " << places[n].row << " " << places[n].height_m;
      }
      EXPECT_GT(shown[1][n][0], shown[2][n][0] + 20) << shape.name;
    }
    EXPECT_GT(sands, 3) << shape.name;
  }
}

// Where images do not cover, and in worlds without them, materials are as they were.
TEST_F(Images, WhereNothingCoversMaterialsShow) {
  const std::vector<std::byte> none = flat_file({});
  const std::vector<std::byte> empty = flat_file({[](double, double) { return kNothing; }, 4});
  const auto half = [](double column, double) { return column < 120 ? kSand : kNothing; };
  const Vec3 eye{1200, 900, 1000}, target{1201, 0, 900};
  const Pixels without = drawn(none, {}, eye, target);
  EXPECT_LE(test::largest_difference(without, drawn(empty, {}, eye, target)), 1);
  const Pixels halved = drawn(flat_file({half, 4}), {}, eye, target);
  int same = 0, other = 0;
  for (int x = 0; x < kWidth; ++x) {
    const std::uint8_t* const a = without.at(x, kHeight / 2);
    const std::uint8_t* const b = halved.at(x, kHeight / 2);
    const int off = std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
    if (x < kWidth / 2 - 4) other += off > 8 ? 1 : 0;
    if (x > kWidth / 2 + 4) same += off <= 1 ? 1 : 0;
  }
  EXPECT_EQ(other, kWidth / 2 - 4);
  EXPECT_EQ(same, kWidth / 2 - 5);
}

// Colours that change slowly: so are tiles of all sizes alike.
Colour slow(double column, double row) {
  return {static_cast<std::uint8_t>(std::clamp(60 + 0.7 * column, 0.0, 255.0)),
          static_cast<std::uint8_t>(std::clamp(60 + 0.8 * row, 0.0, 255.0)), 90, 255};
}

// Where there are no tiles of the least sizes the same colours lie at the same places, in coarser texels.
TEST_F(Images, SeveralResolutionsShowOnePicture) {
  const auto east = [](double column, double) { return column >= 120; };
  const std::vector<std::byte> fine = flat_file({slow, 2}), mixed = flat_file({slow, 2, east});
  ASSERT_LT(mixed.size(), fine.size() * 3 / 4);
  const Vec3 looks[][2] = {{{1200, 60, 1000}, {1201, 0, 940}}, {{1150, 400, 1200}, {1250, 0, 700}}};
  for (const auto& look : looks) {
    const Pixels of_fine = drawn(fine, {}, look[0], look[1]), of_mixed = drawn(mixed, {}, look[0], look[1]);
    EXPECT_LE(test::largest_difference(of_fine, of_mixed), 3) << look[0].y;
  }
}

// A colour map of one texel a sample, about, whose coarser sizes are quite different: while the eye rises and
// nodes and tiles grow, colours go over into those of larger ones, a little in each frame. (S has colours at
// vertices that morph with them.)
TEST_F(Images, ColoursOfSamplesComeAndGoSlowly) {
  constexpr int kSide = 513;
  constexpr int kTexelOfASample = 6;  // 60 texels a sample at size 0
  const double texel = std::ldexp(1.0, kTexelOfASample) / core::kTexelsPerSample;  // samples
  ASSERT_NEAR(texel, 1, 0.1);
  const auto noisy = [&](double column, double row) {
    const auto i = static_cast<std::uint32_t>(std::floor(column / texel)),
               k = static_cast<std::uint32_t>(std::floor(row / texel));
    const auto up = static_cast<std::uint8_t>((i + k) % 2 == 0 ? 60 : 0);
    return Colour{static_cast<std::uint8_t>(100 + up), static_cast<std::uint8_t>(120 + up / 2), 90, 255};
  };
  const test::MemoryGround ground(kSide, kSide, 2048, 2048, [](std::int64_t, std::int64_t) { return 0; });
  open({}, {}, {}, test::ground_file(ground, 10, {noisy, kTexelOfASample}));
  const double middle = 10.0 * (kSide - 1) / 2;
  // Of pixels around the middle, which stay where they are.
  constexpr int kAround = 8;
  const auto difference = [&](const Pixels& a, const Pixels& b) {
    int largest = 0;
    for (int y = kHeight / 2 - kAround; y < kHeight / 2 + kAround; ++y) {
      for (int x = kWidth / 2 - kAround; x < kWidth / 2 + kAround; ++x) {
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      }
    }
    return largest;
  };
  Pixels first, before;
  int largest = 0;
  for (int n = 0; n <= 240; ++n) {
    // From 1.3 pixels a texel to less than a half.
    const double height = 890 * std::exp2(1.5 * n / 240);
    const FrameResult result = test::draw_frame(
        *renderer_, picture_, {view({middle, height, middle}, {middle + 0.01, 0, middle})}, 0);
    ASSERT_TRUE(result.complete);
    const Pixels now = picture_.read();
    if (n == 0) first = before = now;
    largest = std::max(largest, difference(now, before));
    before = now;
  }
  const int whole = difference(before, first);
  std::printf("FIGURE colours change by %d of 255 from frame to frame at most, by %d in all\n", largest,
              whole);
  EXPECT_GT(whole, 25);
  EXPECT_LE(largest, 8);
}

// A region of voxels under images of two resolutions, with tiles for all or for too few layers, by frames
// that wait for them and by frames that do not: nowhere the background, nowhere black.
TEST_F(Images, NoPixelIsOpenOrBlackWhateverIsMissing) {
  constexpr glm::ivec3 kExtent{41, 24, 37};
  constexpr int kFirst[2] = {12, 9};
  const auto height_at = [](double x, double z) {
    return 12 + 2 * test::value_noise(5, glm::dvec3(x, 0, z) / 9.0);
  };
  test::TestWorld voxels(
      kExtent, [&](glm::ivec3 v) { return v.y + 0.5 < height_at(v.x + 0.5, v.z + 0.5); }, true);
  voxels.set_heights(3, [](glm::dvec3) { return 0.0; });
  test::MemoryRegion region{kExtent.x, kExtent.z, kFirst[0], kFirst[1], {}};
  region.measure.error = 4.0 * core::kStepsPerVoxel;
  region.measure.reach = 30.0 * core::kStepsPerVoxel;
  const test::MemoryGround ground(
      189, 165, 4096, 4096,
      [&](std::int64_t i, std::int64_t k) {
        const double h = height_at(0.5 + 0.5 * double(i) - 24, 0.5 + 0.5 * double(k) - 18);
        return static_cast<std::int32_t>(h * core::kStepsPerVoxel / core::kVertexStep);
      },
      {region});
  const auto east = [](double column, double) { return column >= 90; };
  const auto bright = [](double column, double row) {
    return is_sand(column, row) ? kSand : Colour{150, 190, 160, 255};
  };
  const std::vector<std::byte> file = test::ground_file(ground, voxels, {bright, 0, east});
  int frames = 0, lacking = 0, with_patches = 0;
  for (const bool deferred : {false, true}) {
    for (const std::uint64_t image_bytes : {std::uint64_t{0}, std::uint64_t{1}}) {
      Needs needs;
      needs.image_bytes = image_bytes;
      if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
      GlOptions options;
      options.shading = deferred ? Shading::deferred : Shading::forward;
      open(needs, {}, options, file);
      test::Random random{17};
      for (int frame = 0; frame < 24; ++frame, ++frames) {
        const double x = 2 + 37 * random.unit(), z = 2 + 33 * random.unit();
        const double y = height_at(x, z) + 1 + std::exp2(4 * random.unit());
        ViewState shown = view({x, y, z}, {x + random.unit() - 0.5, y - 2, z + random.unit() - 0.5});
        set_perspective(shown, 60, 0.1, 2000);
        shown.error_px = std::exp2(4 * random.unit());
        FrameResult result;
        // One that has to be complete waits; one of too few layers never is.
        ASSERT_EQ(holes(shown, frame % 8 == 0 ? 0 : 0.01, result), 0u) << frame << " at " << x << ' ' << z;
        const Pixels pixels = picture_.read();
        int black = 0;
        for (std::size_t n = 0; n < pixels.rgba.size(); n += 4)
          black += pixels.rgba[n] + pixels.rgba[n + 1] + pixels.rgba[n + 2] < 24 ? 1 : 0;
        ASSERT_EQ(black, 0) << frame << " at " << x << ' ' << y << ' ' << z << ' ' << deferred;
        lacking += result.lacking > 0 ? 1 : 0;
        with_patches += costs(*renderer_).patches_drawn > 0 ? 1 : 0;
      }
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
      close();
    }
  }
  EXPECT_GT(lacking, frames / 4);
  EXPECT_GT(with_patches, frames / 2);
}

TEST_F(Images, ThePlanIsWhatIsTaken) {
  open({}, {}, {}, test::ground_file(hilly(), 10, {checker, 4}));
  const DeviceInfo device = device_info(*renderer_);
  EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
  EXPECT_EQ(device.gpu_bytes, host_->plan.gpu_bytes);
  std::uint64_t imagery = 0;
  for (std::uint32_t n = 0; n < host_->plan.term_count; ++n) {
    const Term& term = host_->plan.terms[n];
    if (std::string_view(term.name) == "imagery" && term.gpu) imagery = term.bytes;
  }
  EXPECT_GT(imagery, 15u << 20);
  EXPECT_LE(imagery, (16u << 20) + (64u << 10));
  // Flying about takes nothing more.
  for (int frame = 0; frame < 60; ++frame) {
    const double x = 300 + 30 * frame;
    test::draw_frame(*renderer_, picture_, {view({x, 90, 1000}, {x + 200, 20, 800})}, 1);
  }
  EXPECT_EQ(device_info(*renderer_).gpu_bytes, host_->plan.gpu_bytes);
}

TEST_F(Images, APictureComesToRestAndIsThatOfAFrameThatWaits) {
  const std::vector<std::byte> file = test::ground_file(hilly(), 10, {checker, 3});
  open({}, {}, {}, file);
  const ViewState shown = view({1200, 90, 1000}, {1500, 20, 700});
  FrameResult result;
  int frames = 0;
  do {
    result = test::draw_frame(*renderer_, picture_, {shown}, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  } while (!result.complete && ++frames < 2000);
  ASSERT_TRUE(result.complete);
  const Pixels late = picture_.read();
  close();
  open({}, {}, {}, file);
  result = test::draw_frame(*renderer_, picture_, {shown}, 0);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(late.rgba, picture_.read().rgba);
}

// A file that takes 20 ms a read: frames read nothing themselves, and are there before it.
TEST_F(Images, FramesDoNotWaitForTheFile) {
  test::MemoryFile memory(test::ground_file(hilly(), 10, {checker, 3}));
  struct Slow {
    Source from;
    std::thread::id frames = std::this_thread::get_id();
    std::atomic<bool> drawing = false;
    std::atomic<int> own = 0, images = 0;
  } slow;
  slow.from = memory.source();
  Source source;
  source.bytes = slow.from.bytes;
  source.user = &slow;
  source.read = [](void* user, std::uint64_t offset, std::byte* out, std::size_t bytes) {
    auto& own = *static_cast<Slow*>(user);
    if (own.drawing && std::this_thread::get_id() == own.frames) ++own.own;
    if (own.drawing && bytes > core::image_texel_bytes(core::ImageFormat::rgba8)) ++own.images;
    if (own.drawing) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return own.from.read(own.from.user, offset, out, bytes);
  };
  Plan plan;
  ASSERT_TRUE(make_plan(source, plan).ok());
  test::AlignedBytes room(plan.cpu_bytes);
  World* world = nullptr;
  ASSERT_TRUE(World::create(plan, source, room.bytes(), world).ok());
  Renderer* renderer = nullptr;
  ASSERT_TRUE(Renderer::create(*world, picture_.loader(), {}, renderer).ok());
  test::draw_frame(*renderer, picture_,
                   {test::looking(*world, {1800, 90, 1500}, {2000, 20, 1200}, kWidth, kHeight)}, 1);
  slow.drawing = true;
  const ViewState elsewhere = test::looking(*world, {400, 90, 400}, {600, 20, 700}, kWidth, kHeight);
  int frames = 0;
  FrameResult result;
  std::uint32_t lacking = 0;
  do {
    result = test::draw_frame(*renderer, picture_, {elsewhere}, 1);
    lacking = std::max(lacking, result.lacking);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } while (!result.complete && ++frames < 5000);
  EXPECT_TRUE(result.complete);
  EXPECT_GT(lacking, 0u);
  EXPECT_EQ(slow.own, 0) << "reads by the thread that draws";
  EXPECT_GT(slow.images, 3);
  EXPECT_GT(frames, slow.images) << "more frames than reads";
  slow.drawing = false;
  renderer->destroy();
  world->destroy();
}

// Fewer layers than the view wants: it comes to rest, coarser, and says why.
TEST_F(Images, TooFewLayersAreSaid) {
  Needs needs;
  needs.image_bytes = 1;
  open(needs, {}, {}, test::ground_file(hilly(), 10, {checker, 3}));
  ViewState shown = view({50, 90, 50}, {1200, 0, 1000});
  shown.width_px = 16'000;  // as fine as no screen is
  shown.height_px = 12'000;
  FrameInput input;
  input.views = {&shown, 1};
  input.work_ms = 5;
  FrameResult result;
  std::uint32_t limits = 0;
  for (int frame = 0; frame < 2000; ++frame) {
    ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
    ASSERT_TRUE(renderer_->end_frame().ok());
    limits |= result.limits;
    if (result.complete && (limits & kLimitTiles) != 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_NE(limits & kLimitTiles, 0u);
  EXPECT_TRUE(result.complete);
  EXPECT_GT(result.lacking, 0u);
}

TEST_F(Images, ADamagedTileFailsAFrameThatHasToBeCompleteAndNoOther) {
  std::vector<std::byte> file = test::ground_file(hilly(), 10, {checker, 4});
  core::WorldReader reader;
  ASSERT_TRUE(reader.open(core::ByteSource::of(file)).ok());
  const std::uint64_t root = reader.root_image().offset;
  // The image tiles lie one behind the other, the root's last.
  std::uint64_t begin = 0;
  std::vector<std::byte> bytes(reader.root_image().bytes);
  ASSERT_TRUE(reader.read_tile(reader.root_image(), bytes).ok());
  for (std::uint64_t at = 0; at + bytes.size() <= file.size(); at += 1) {
    if (std::equal(bytes.begin(), bytes.begin() + 64, file.begin() + static_cast<std::ptrdiff_t>(at))) {
      begin = at - root;
      break;
    }
  }
  ASSERT_GT(begin, 0u);
  file[static_cast<std::size_t>(begin + root - bytes.size() + 5'000)] ^= std::byte{4};
  open({}, {}, {}, file);
  const ViewState shown = view({1500, 200, 1500}, {1501, 0, 1450});
  FrameResult result;
  FrameInput input;
  input.views = {&shown, 1};
  input.work_ms = 0;
  EXPECT_EQ(renderer_->begin_frame(input, result).code(), StatusCode::corrupt);
  EXPECT_TRUE(renderer_->end_frame().ok());
  result = test::draw_frame(*renderer_, picture_, {shown}, 1);
  EXPECT_FALSE(result.complete);
}

}  // namespace
}  // namespace karst
