// SPDX-License-Identifier: MIT
// karst in a host's context: whatever state the host leaves and whatever it has bound, the pictures are those
// of a clean context to the bit, the host's objects keep what they hold, errors of the host stay pending, and
// state is left as promised. In OpenGL ES 3 and in OpenGL 4.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "terrain/shadow/cascades.h"
#include "tests/gl/dirty_host.h"
#include "tests/gl/gl_fixture.h"
#include "tests/gl/noop_gl.h"

namespace karst::core {
namespace {

using test::Api;
using test::DirtyHost;
using test::HostContext;
using test::HostTarget;

constexpr int kLevel = 3;
constexpr std::uint32_t kFirstUnit = 3;
constexpr std::uint32_t kFirstBlock = 2;
constexpr Rect kViewport{8, 4, 80, 56};

enum class Ground { plain, rgba8, etc2, drape, deferred };  // deferred: rgba8, by way of a G-buffer

// What is drawn, prepared without a driver.
class Scene {
 public:
  Scene() : world_(test::hills_with_cave(kLevel)), drawn_(world_, test::NoopGl::reset(), settings()) {
    drawn_.lod.mode = LodMode::full;
    CameraSettings camera;
    camera.position = {11, 14, 24};
    camera.pitch_deg = -25;
    camera.aspect = double{kViewport.width} / kViewport.height;
    EXPECT_TRUE(drawn_.prepare(camera, input).ok());
    camera.reversed_depth = true;
    EXPECT_TRUE(make_camera(camera, reversed).ok());
    CameraMatrices matrices;
    matrices.position = camera.position;
    matrices.view_from_world = glm::transpose(world_from_view(input.camera));
    matrices.clip_from_view = input.camera.clip_from_view;
    for (int column = 0; column < 4; ++column) matrices.clip_from_view[column].x *= -1;
    EXPECT_TRUE(make_camera(matrices, mirrored).ok());
    const PointLight lamp{{11, 12, 15}, 12, {2, 1, 0}};
    lamps_[0] = lamp;
    input.lights = lamps_;
    fit_cascades();
    lay_out_pages();
  }

  const test::TestWorld& world() const { return world_; }
  const SkyVisibility& sky() { return drawn_.world().sky(); }
  std::uint32_t patches() const { return static_cast<std::uint32_t>(world_.surface().patches.size()); }
  std::uint32_t pages() const { return patches() * slot_pages(kLevel); }

  Status upload_patch(Renderer& renderer, PatchId p) {
    const std::vector<GpuVertex> vertices = world_.vertices(p, kLevel);
    const Volume& v = world_.surface().volume_of(p);
    return renderer.upload_vertices(input.pages, p, 0, vertices, {v.corner[0], v.corner[1], v.corner[2]}, p,
                                    {.needs = kShadeBlend | kShadeCave});
  }
  Status upload_row(Renderer& renderer, PatchId p) {
    std::array<std::uint16_t, kMorphRow> row{};
    const auto lods = drawn_.residency().thresholds().lods(drawn_.view().threshold_set());
    make_morph_row(world_.surface(), lods, p, row);
    return renderer.upload_morph_rows(p, row);
  }

  ViewInput input;
  Camera reversed;
  Camera mirrored;
  Cascade cascades[2];

 private:
  static test::DrawnSettings settings() {
    test::DrawnSettings settings;
    settings.picture.width = kViewport.width;
    settings.picture.height = kViewport.height;
    settings.loader = test::NoopGl::loader();
    return settings;
  }

  void fit_cascades() {
    FitCascades fit;
    fit.settings.count = 2;
    fit.settings.size = 512;
    fit.settings.reach_voxels = 64;
    fit.camera = &input.camera;
    fit.to_sun = light_direction(input.light);
    fit.world = drawn_.world().box();
    fit.light = &input.light_space;
    fit.cascades = cascades;
    EXPECT_TRUE(fit.validate().ok());
    fit.run();
    input.cascades = cascades;
  }

  void lay_out_pages() {
    table_ = test::TestPages(patches(), pages());
    const std::uint32_t slot = slot_pages(kLevel);
    for (PatchId p = 0; p < patches(); ++p) table_.set(p, p * slot, slot);
    input.pages = table_.table();
    input.first_morph_row = 0;
  }

  test::TestWorld world_;
  test::DrawnWorld drawn_;
  test::TestPages table_{0, 0};
  PointLight lamps_[1];
};

std::vector<std::byte> noise(std::size_t bytes) {
  std::vector<std::byte> out(bytes);
  unsigned state = 7;
  for (std::byte& b : out) {
    state = state * 1664525u + 1013904223u;
    b = static_cast<std::byte>(state >> 24);
  }
  return out;
}

// All calls of a renderer's life, in a host that may be dirty, and the pictures of them.
class Guest {
 public:
  Guest(Scene& scene, HostContext& host, Ground ground, bool dirty, bool errors)
      : scene_(scene), host_(host), ground_(ground), errors_(errors), single_(host, 0), multi_(host, 4) {
    if (dirty) dirty_ = std::make_unique<DirtyHost>(host);
    Gl gl;
    EXPECT_TRUE(load_gl(host.loader(), host.api() == Api::desktop, gl).ok());
    create(gl);
    upload();
    draw_shadows();
    draw_views();
    call("destroy", kNothing, [&] {
      renderer_.destroy();
      return Status();
    });
    EXPECT_EQ(host.get<decltype(::glGetError)>("glGetError")(), GLenum{GL_NO_ERROR});
  }

  std::vector<std::vector<std::uint8_t>> pictures;
  std::vector<std::string> names;

 private:
  enum Promise { kNothing, kUpload, kAll };

  RendererSettings settings() const {
    RendererSettings settings;
    settings.vertex_pages = scene_.pages();
    settings.morph_rows = scene_.patches();
    settings.stream_indices = 20'000;  // several chunks
    settings.extent = scene_.world().extent();
    settings.sky = scene_.sky().grid();
    settings.cascades = ground_ == Ground::drape ? 0 : 2;
    settings.shadow_size = 512;
    settings.air_blocks = 2;
    settings.first_unit = kFirstUnit;
    settings.first_block = kFirstBlock;
    settings.desktop = host_.api() == Api::desktop;
    if (ground_ != Ground::plain && ground_ != Ground::drape) {
      settings.material_count = 3;
      settings.material_side = 16;
      settings.material_format = ground_ == Ground::etc2 ? TextureFormat::etc2 : TextureFormat::rgba8;
    }
    if (ground_ == Ground::deferred) {
      settings.deferred_width = kViewport.width + 3;
      settings.deferred_height = kViewport.height;
      settings.shading = karst::Shading::deferred;
    }
    if (ground_ == Ground::drape) {
      settings.drape_width = 33;
      settings.drape_height = 17;
    }
    return settings;
  }

  // A call in the middle of the host's work: framebuffer is bound for drawing.
  void call(const std::string& name, Promise promise, const std::function<Status()>& work,
            GLuint framebuffer = 0, bool takes_errors = false) {
    if (dirty_ != nullptr) dirty_->dirty(framebuffer, errors_);
    const Status status = work();
    ASSERT_TRUE(status.ok()) << name << ": " << status.what() << ' ' << status.field();
    if (dirty_ == nullptr) return;
    ASSERT_EQ(dirty_->wrong_error(errors_ && !takes_errors), "") << name;
    std::string wrong;
    if (promise == kAll) wrong = dirty_->wrong_state(kFirstUnit, kFirstBlock);
    if (promise == kUpload) wrong = dirty_->wrong_upload_state(kFirstUnit);
    if (wrong.empty() && (promise != kUpload || ++uploads_ % 50 == 0)) wrong = dirty_->changed_objects();
    ASSERT_EQ(wrong, "") << name;
  }

  void create(const Gl& gl) {
    call(
        "create", kAll, [&] { return renderer_.create(gl, settings()); }, 0, true);
    EXPECT_EQ(renderer_.pending_error() != GL_NO_ERROR, dirty_ != nullptr && errors_);
    EXPECT_EQ(host_.integer(GL_DRAW_FRAMEBUFFER_BINDING), 0);
  }

  void upload() {
    call("sky", kUpload, [&] { return renderer_.upload_sky(scene_.sky()); });
    upload_ground();
    for (PatchId p = 0; p < scene_.patches(); ++p) {
      call("vertices", kNothing, [&] { return scene_.upload_patch(renderer_, p); });
      if (testing::Test::HasFatalFailure()) return;
      call("row", kUpload, [&] { return scene_.upload_row(renderer_, p); });
    }
    call("air", kNothing, [&] { return renderer_.set_air(1, {}); });
  }

  void upload_ground() {
    const RendererSettings& s = renderer_.settings();
    if (ground_ == Ground::drape) {
      const auto texels = noise(static_cast<std::size_t>(s.drape_width * s.drape_height) * 4);
      call("drape", kUpload, [&] {
        return renderer_.upload_drape({reinterpret_cast<const std::uint8_t*>(texels.data()), texels.size()});
      });
    }
    if (s.material_count == 0) return;
    MaterialSet set;
    set.count = s.material_count;
    set.side = s.material_side;
    set.format = s.material_format;
    set.materials[1].slope_high = 0.8f;
    set.materials[1].fray = 1;
    set.materials[2].cave = 1;
    set.materials[2].height_high = 9;
    call("materials", kNothing, [&] { return renderer_.set_materials(set); });
    for (const TextureArray array : {TextureArray::far, TextureArray::near}) {
      for (int level = 0; level < texture_levels(set.side, array); ++level) {
        const auto bytes = noise(texture_image_bytes(set.format, set.side, array, level) * set.count);
        call("textures", kUpload,
             [&] { return renderer_.upload_textures(array, level, 0, static_cast<int>(set.count), bytes); });
      }
    }
  }

  void draw_shadows() {
    for (int n = 0; n < renderer_.settings().cascades; ++n) {
      CascadeInput input;
      input.cascade = scene_.cascades[n];
      input.items = scene_.input.items;
      input.pages = scene_.input.pages;
      input.index_table = scene_.input.index_table;
      input.max_level = scene_.input.max_level;
      // What the host leaves there does not matter either.
      input.draw_more = [](void* user) {
        const auto& guest = *static_cast<Guest*>(user);
        EXPECT_EQ(guest.host_.integer(GL_DEPTH_TEST), GL_TRUE);
        if (guest.dirty_ == nullptr) return;
        EXPECT_EQ(guest.dirty_->wrong_error(guest.errors_), "");
        guest.dirty_->dirty(0, guest.errors_);
      };
      input.user = this;
      call("cascade", kAll, [&] {
        const Status status = renderer_.draw_cascade(n, input);
        EXPECT_EQ(host_.integer(GL_DRAW_FRAMEBUFFER_BINDING), 0);
        EXPECT_EQ(host_.integer(GL_READ_FRAMEBUFFER_BINDING), 0);
        return status;
      });
      if (testing::Test::HasFatalFailure()) return;
    }
  }

  void draw(const std::string& name, const HostTarget& to, const ViewInput& input, DrawTarget target,
            bool clear = true) {
    if (testing::Test::HasFatalFailure()) return;
    target.framebuffer = to.name();
    if (clear) to.clear(input.camera.reversed_depth ? 0.0f : 1.0f);
    const auto framebuffer = static_cast<int>(to.name());
    if (dirty_ == nullptr)
      host_.get<decltype(::glBindFramebuffer)>("glBindFramebuffer")(GL_FRAMEBUFFER, to.name());
    call(
        name, kNothing,
        [&] {
          const Status status = renderer_.draw(input, target);
          EXPECT_EQ(host_.integer(GL_DRAW_FRAMEBUFFER_BINDING), framebuffer);
          if (dirty_ != nullptr) {
            EXPECT_EQ(dirty_->wrong_state(kFirstUnit, kFirstBlock), "") << name;
          }
          return status;
        },
        to.name());
    pictures.push_back(to.picture());
    names.push_back(name);
  }

  void draw_views() {
    ViewInput input = scene_.input;
    if (ground_ == Ground::drape) input.cascades = {};
    const DrawTarget whole{.viewport = kViewport};
    DrawTarget target = whole;
    draw("whole", single_, input, whole);
    target.sky = false;
    draw("no sky", single_, input, target);
    target = whole;
    target.linear = true;
    draw("linear", single_, input, target);
    draw("four samples", multi_, input, whole);
    target = whole;
    target.writes = Writes::depth;
    draw("depth alone", multi_, input, target);
    target.writes = Writes::colour;
    draw("depth, then colour", multi_, input, target, false);
    static_cast<void>(renderer_.end_frame());
    // The next frame, in which something changed.
    call("vertices", kNothing, [&] { return scene_.upload_patch(renderer_, 0); });
    input.camera = scene_.mirrored;
    draw("mirrored", single_, input, whole);
    input.camera = scene_.reversed;
    draw("reversed", single_, input, whole);
    target = whole;
    target.depth_zero_to_one = renderer_.caps().clip_control;
    draw("reversed, 0..1", single_, input, target);
    static_cast<void>(renderer_.end_frame());
  }

  Scene& scene_;
  HostContext& host_;
  Ground ground_;
  bool errors_;
  HostTarget single_, multi_;
  std::unique_ptr<DirtyHost> dirty_;
  int uploads_ = 0;
  Renderer renderer_;
};

using Pixel = std::array<std::uint8_t, 4>;

Pixel pixel(const std::vector<std::uint8_t>& picture, int x, int y) {
  Pixel p{};
  std::copy_n(picture.begin() + (y * HostTarget::kWidth + x) * 4, 4, p.begin());
  return p;
}

// How many pixels differ by more than a little.
int differences(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b, bool flip = false) {
  int count = 0;
  for (int y = 0; y < HostTarget::kHeight; ++y) {
    for (int x = 0; x < HostTarget::kWidth; ++x) {
      const Pixel p = pixel(a, x, y);
      const Pixel q = pixel(b, flip ? HostTarget::kWidth - 1 - x : x, y);
      int most = 0;
      for (std::size_t c = 0; c < 4; ++c) most = std::max(most, std::abs(p[c] - q[c]));
      count += most > 24 ? 1 : 0;
    }
  }
  return count;
}

// That the pictures show what their names say, so that equal ones mean something.
void expect_sense(const Guest& guest, Ground ground) {
  const bool drape = ground == Ground::drape;
  const auto named = [&](const char* name) -> const std::vector<std::uint8_t>& {
    const auto at = std::find(guest.names.begin(), guest.names.end(), name);
    EXPECT_NE(at, guest.names.end()) << name;
    return guest.pictures[static_cast<std::size_t>(at - guest.names.begin())];
  };
  constexpr int kPixels = HostTarget::kWidth * HostTarget::kHeight;
  const auto& whole = named("whole");
  const Pixel background = pixel(whole, 0, 0);
  int outside = 0;
  for (int y = 0; y < HostTarget::kHeight; ++y) {
    for (int x = 0; x < HostTarget::kWidth; ++x) {
      const bool inside = x >= kViewport.x && x < kViewport.x + kViewport.width && y >= kViewport.y &&
                          y < kViewport.y + kViewport.height;
      if (!inside && pixel(whole, x, y) == background) ++outside;
    }
  }
  EXPECT_EQ(outside, kPixels - kViewport.width * kViewport.height) << "outside the viewport nothing is drawn";
  EXPECT_GT(differences(whole, named("no sky")), kPixels / 20);
  EXPECT_EQ(pixel(named("no sky"), kViewport.x + 2, kViewport.y + kViewport.height - 2), background);
  // The target encodes light as sRGB, which the image over the world is already.
  if (drape) {
    EXPECT_LT(differences(whole, named("linear")), kPixels / 20);
  } else {
    EXPECT_GT(differences(whole, named("linear")), kPixels / 20);
  }
  EXPECT_GT(differences(named("four samples"), named("depth alone")), kPixels / 2);
  if (ground == Ground::deferred) {
    // Views in two steps do not go by the G-buffer: samples of its edges are alike.
    EXPECT_LT(differences(named("depth, then colour"), named("four samples")), kPixels / 5);
  } else {
    EXPECT_EQ(named("depth, then colour"), named("four samples"));
  }
  EXPECT_LT(differences(whole, named("four samples")), kPixels / 3);
  EXPECT_LT(differences(whole, named("mirrored"), true), kPixels / 20);
  EXPECT_GT(differences(whole, named("mirrored")), kPixels / 20);
  EXPECT_LT(differences(whole, named("reversed")), kPixels / 100);
  EXPECT_LT(differences(whole, named("reversed, 0..1")), kPixels / 100);
}

void expect_equal(const Guest& a, const Guest& b) {
  ASSERT_EQ(a.names, b.names);
  for (std::size_t i = 0; i < a.pictures.size(); ++i)
    EXPECT_TRUE(a.pictures[i] == b.pictures[i])
        << a.names[i] << ": " << differences(a.pictures[i], b.pictures[i]);
}

// Of the same views, drawn in other ways.
void expect_alike(const Guest& a, const Guest& b) {
  ASSERT_EQ(a.names, b.names);
  for (std::size_t i = 0; i < a.pictures.size(); ++i) {
    if (a.names[i] == "four samples") continue;
    EXPECT_LE(differences(a.pictures[i], b.pictures[i]), HostTarget::kWidth * HostTarget::kHeight / 200)
        << a.names[i];
  }
}

struct Case {
  Api api;
  Ground ground;
  const char* name;
};

class State : public testing::TestWithParam<Case> {};

TEST_P(State, OfTheHostDoesNotMatterAndIsLeftAsPromised) {
  Scene scene;
  HostContext host(GetParam().api);
  ASSERT_TRUE(host.ok());
  const Guest clean(scene, host, GetParam().ground, false, false);
  if (HasFatalFailure()) return;
  expect_sense(clean, GetParam().ground);
  for (const bool errors : {false, true}) {
    const Guest dirty(scene, host, GetParam().ground, true, errors);
    if (HasFatalFailure()) return;
    expect_equal(dirty, clean);
  }
}

TEST(GBuffer, ShowsWhatShadingWhileDrawingShows) {
  Scene scene;
  HostContext host(Api::es);
  ASSERT_TRUE(host.ok());
  const Guest forward(scene, host, Ground::rgba8, false, false);
  const Guest deferred(scene, host, Ground::deferred, false, false);
  expect_alike(forward, deferred);
}

INSTANTIATE_TEST_SUITE_P(Hosts, State,
                         testing::Values(Case{Api::es, Ground::plain, "EsPlain"},
                                         Case{Api::es, Ground::rgba8, "EsMaterials"},
                                         Case{Api::es, Ground::etc2, "EsEtc2"},
                                         Case{Api::es, Ground::drape, "EsDrape"},
                                         Case{Api::es, Ground::deferred, "EsDeferred"},
                                         Case{Api::desktop, Ground::deferred, "DesktopDeferred"},
                                         Case{Api::desktop, Ground::plain, "DesktopPlain"},
                                         Case{Api::desktop, Ground::rgba8, "DesktopMaterials"},
                                         Case{Api::desktop, Ground::etc2, "DesktopEtc2"},
                                         Case{Api::desktop, Ground::drape, "DesktopDrape"}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace karst::core
