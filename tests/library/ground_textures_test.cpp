// SPDX-License-Identifier: MIT
// How the ground's textures are laid and looked up, by stripes. Anisotropic lookups: ground that is seen at a
// grazing angle keeps what it would lose by a lookup as wide as a pixel's longer side. Walls: their strata
// lie level.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include <gtest/gtest.h>

#include "terrain/shading/materials.h"
#include "tests/library/host.h"
#include "tests/support/test_world.h"
#include "tests/support/world_io.h"

namespace karst {
namespace {

using test::HostPicture;
using test::HostWorld;
using test::Pixels;

constexpr int kWidth = 128;
constexpr int kHeight = 64;

// levels: grey, and every second mip of the near texture is dark.
enum class Stripes : std::uint8_t { along_t, along_s, levels };

// A world of one material, of stripes as wide as a voxel, 1 m. slope_high: of its rule, which does not keep
// it from any ground, because it is the first.
std::vector<std::byte> striped_file(const test::TestWorld& shape, Stripes stripes, float slope_high) {
  const std::vector<std::byte> plain = shape.file();
  core::MaterialSet set;
  set.count = 1;
  set.side = 64;
  set.repeat_log2 = 5;
  std::strcpy(set.materials[0].name, "stripes");
  set.materials[0].slope_high = slope_high;
  std::vector<std::byte> textures(texture_bytes(set), std::byte{128});
  if (stripes == Stripes::levels) set.repeat_log2 = 2;
  for (int level = 0; stripes == Stripes::levels && level < 7; ++level) {
    const std::size_t begin = texture_offset(set, core::TextureArray::near, level, 0);
    const std::size_t end = texture_offset(set, core::TextureArray::near, level, 1);
    for (std::size_t at = begin; at < end; at += 4) textures[at] = std::byte(level % 2 == 0 ? 190 : 66);
  }
  // The finest level has a texel a voxel; coarser ones are grey.
  const std::size_t side = 32;
  const std::size_t first = texture_offset(set, core::TextureArray::far, 0, 0);
  for (std::size_t texel = 0; texel < side * side; ++texel) {
    if (stripes == Stripes::levels) break;
    const std::size_t across = stripes == Stripes::along_t ? texel % side : texel / side;
    for (std::size_t c = 0; c < 3; ++c)
      textures[first + 4 * texel + c] = std::byte(across % 2 == 0 ? 60 : 196);
  }
  const core::WorldInfo info = shape.info();
  const std::vector<std::uint8_t> overrides(info.patches, 0);
  std::vector<std::byte> file;
  const Status status =
      core::write_world({info, &shape.octree(), core::read_patches(plain), {set, textures, overrides}}, file);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  return file;
}

Pixels draw(Renderer& renderer, const HostPicture& picture, const World& world, Vec3 eye, Vec3 target) {
  Target whole;
  whole.viewport = {0, 0, kWidth, kHeight};
  whole.framebuffer = picture.name();
  test::draw_frame(renderer, picture, {test::looking(world, eye, target, kWidth, kHeight)}, 0, &whole);
  return picture.read();
}

// Two pictures of the plain: by a walker who looks north, and from above.
struct Plain {
  Plain(Shading shading, std::uint32_t anisotropy, Stripes stripes = Stripes::along_t) {
    Needs needs;
    if (shading == Shading::deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    static const test::TestWorld kShape({64, 8, 64}, [](glm::ivec3 v) { return v.y < 3; });
    HostWorld host(needs, {}, striped_file(kShape, stripes, 2));
    HostPicture picture(kWidth, kHeight);
    if (host.world == nullptr) return;
    GlOptions options;
    options.shading = shading;
    options.detail = Detail::low;
    options.anisotropy = anisotropy;
    Renderer* renderer = nullptr;
    status = Renderer::create(*host.world, picture.loader(), options, renderer);
    if (renderer == nullptr) return;
    device = device_info(*renderer);
    const WorldInfo& info = host.world->info();
    const double ground = info.low_m.y + 2.5;
    const Vec3 walker{(info.low_m.x + info.high_m.x) / 2 + 0.3, ground + 1.7, info.high_m.z - 8};
    const Vec3 bird{walker.x, ground + 12, walker.z - 20};
    grazing = draw(*renderer, picture, *host.world, walker, {walker.x, walker.y - 1, walker.z - 10});
    above = draw(*renderer, picture, *host.world, bird, {bird.x, ground, bird.z - 0.01});
    renderer->destroy();
  }

  Status status;
  DeviceInfo device;
  Pixels grazing, above;
};

// A slope of 45 degrees, level stripes on its upright planes, looked at straight on; rows are level.
Pixels slope(Shading shading, float slope_high) {
  Needs needs;
  if (shading == Shading::deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
  test::TestWorld shape({32, 32, 32}, [](glm::ivec3 v) { return v.y < 31 - v.x; });
  // Steps are moved towards the plane through their middles, as far as the normals between them allow.
  shape.set_heights(3, [](glm::dvec3 p) { return 0.8 * 8192 * (31 - p.x - p.y); });
  HostWorld host(needs, {}, striped_file(shape, Stripes::along_s, slope_high));
  HostPicture picture(kWidth, kHeight);
  GlOptions options;
  options.shading = shading;
  options.detail = Detail::low;
  Renderer* renderer = nullptr;
  const Status status = Renderer::create(*host.world, picture.loader(), options, renderer);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  if (renderer == nullptr) return {};
  const WorldInfo& info = host.world->info();
  const Vec3 middle{(info.low_m.x + info.high_m.x) / 2, (info.low_m.y + info.high_m.y) / 2,
                    (info.low_m.z + info.high_m.z) / 2};
  const Pixels pixels = draw(*renderer, picture, *host.world, {middle.x + 6, middle.y + 6, middle.z}, middle);

  renderer->destroy();
  return pixels;
}

// Of brightness, along rows of a picture: the root mean square of what neighbours differ by.
double sharpness(const Pixels& pixels, int first, int last) {
  double sum = 0;
  int count = 0;
  for (int y = first; y < last; ++y) {
    for (int x = 1; x < kWidth; ++x, ++count) {
      const double step = pixels.at(x, y)[1] - pixels.at(x - 1, y)[1];
      sum += step * step;
    }
  }
  return std::sqrt(sum / count);
}

// The same along columns.
double sharpness_down(const Pixels& pixels, int first, int last) {
  double sum = 0;
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double step = pixels.at(x, y)[1] - pixels.at(x, y - 1)[1];
      sum += step * step;
    }
  }
  return std::sqrt(sum / ((last - first) * kWidth));
}

TEST(Anisotropy, GroundAtAGrazingAngleIsSharperAndFromAboveItStays) {
  const Plain without(Shading::forward, 1);
  const Plain forward(Shading::forward, 4);
  const Plain deferred(Shading::deferred, 4);
  for (const Plain* plain : {&without, &forward, &deferred}) {
    ASSERT_TRUE(plain->status.ok()) << plain->status.what() << " " << plain->status.field();
  }
  EXPECT_EQ(without.device.anisotropy, 1u);
  if (forward.device.anisotropy < 4) GTEST_SKIP() << "the driver has no EXT_texture_filter_anisotropic";

  // Ground 15 to 35 m away.
  const double blurred = sharpness(without.grazing, kHeight / 2, kHeight / 2 + 3);
  const double sharp = sharpness(forward.grazing, kHeight / 2, kHeight / 2 + 3);
  std::printf("neighbours differ by %.2f of 255, with 4 places by %.2f\n", blurred, sharp);
  EXPECT_GT(sharp, 1.5 * blurred);
  // llvmpipe takes the places of a lookup from one pixel of four; by the G-buffer they are of what all four
  // show, while a triangle's lie in its plane beyond its edges too.
  std::printf("deferred: %.4f of the pixels differ by more than 16\n",
              test::share_beyond(forward.grazing, deferred.grazing, 16));
  EXPECT_LE(test::share_beyond(forward.grazing, deferred.grazing, 16), 0.006);
  EXPECT_LE(test::share_beyond(forward.above, deferred.above, 8), 0.005);

  const double before = sharpness(without.above, 0, kHeight);
  const double after = sharpness(forward.above, 0, kHeight);
  std::printf("from above by %.2f, with 4 places by %.2f\n", before, after);
  EXPECT_GT(before, 1);
  EXPECT_NEAR(after / before, 1, 0.15);
}

// Stripes that run across the view, about two of them a pixel: the places together see both, where a single
// one sees the one or the other.
TEST(Anisotropy, ThePlacesOfALookupAreMixed) {
  const Plain without(Shading::forward, 1, Stripes::along_s);
  ASSERT_TRUE(without.status.ok());
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    const Plain with(shading, 4, Stripes::along_s);
    ASSERT_TRUE(with.status.ok());
    if (with.device.anisotropy < 4) GTEST_SKIP() << "the driver has no EXT_texture_filter_anisotropic";
    // Ground 5 to 8 m away; farther off without places all is grey.
    const double one = sharpness_down(without.grazing, 21, 28);
    const double mixed = sharpness_down(with.grazing, 21, 28);
    std::printf("rows differ by %.2f of 255, with 4 places by %.2f\n", one, mixed);
    EXPECT_GT(one, 20);
    // How many places a driver takes at an angle between is its own business; near the horizon all are taken.
    const bool pinned = std::strncmp(with.device.renderer, "llvmpipe", 8) == 0;
    EXPECT_LT(mixed, (pinned ? 0.5 : 1.0) * one);
    // Near the horizon, where the G-buffer's rounded normals would hide it, along the ground's axes and not
    // those that neighbouring pixels tell.
    if (shading == Shading::deferred) continue;
    EXPECT_LT(sharpness_down(with.grazing, 31, 34), 6);
  }
}

// Brightness of a row's middle.
double mean(const Pixels& pixels, int y) {
  double sum = 0;
  for (int x = kWidth / 2 - 16; x < kWidth / 2 + 16; ++x) sum += pixels.at(x, y)[1];
  return sum / 32;
}

// A pixel takes one mip of the near textures. Where one ends and the next begins no line shows.
TEST(Mips, EndWithoutALine) {
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    Needs needs;
    if (shading == Shading::deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
    const test::TestWorld shape({32, 8, 32}, [](glm::ivec3 v) { return v.y < 3; });
    HostWorld host(needs, {}, striped_file(shape, Stripes::levels, 2));
    HostPicture picture(kWidth, kHeight);
    GlOptions options;
    options.shading = shading;
    options.anisotropy = 1;
    Renderer* renderer = nullptr;
    ASSERT_TRUE(Renderer::create(*host.world, picture.loader(), options, renderer).ok());
    const WorldInfo& info = host.world->info();
    const double ground = info.low_m.y + 2.5;
    const Vec3 eye{(info.low_m.x + info.high_m.x) / 2, ground + 2.2, info.high_m.z - 8};
    const Pixels pixels = draw(*renderer, picture, *host.world, eye, {eye.x, eye.y - 6, eye.z - 10});
    renderer->destroy();
    double least = 255, most = 0, step = 0;
    for (int y = 0; y < kHeight * 2 / 3; ++y) {
      least = std::min(least, mean(pixels, y));
      most = std::max(most, mean(pixels, y));
      if (y > 0) step = std::max(step, std::abs(mean(pixels, y) - mean(pixels, y - 1)));
    }
    std::printf("rows are %.1f to %.1f bright, neighbours differ by %.1f at most\n", least, most, step);
    EXPECT_GT(most - least, 25);
    EXPECT_LT(step, 0.3 * (most - least));
  }
}

// A material that no level ground has is one of walls.
TEST(Walls, StrataLieLevelOnSlopes) {
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    const double ground = sharpness(slope(shading, 2), 0, kHeight);
    const double wall = sharpness(slope(shading, 0.6f), 0, kHeight);
    std::printf("along strata neighbours differ by %.2f of 255; of other ground by %.2f\n", wall, ground);
    EXPECT_GT(ground, 2);
    EXPECT_LT(wall, 0.35 * ground);
  }
}

TEST(Anisotropy, MoreThan16PlacesAreRefused) {
  const Plain plain(Shading::forward, 17);
  EXPECT_EQ(plain.status.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(plain.status.field(), "anisotropy");
}

}  // namespace
}  // namespace karst
