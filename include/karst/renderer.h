// SPDX-License-Identifier: MIT
// Pictures: karst as a guest in the simulator's OpenGL context and framebuffer. Every call is made on the
// thread of the context that was current in create(), which is current again.
//
// OpenGL state. karst reads none (create() asks for the device's limits, and takes errors that are pending
// there), and assumes none but the framebuffer that is bound for drawing in draw(), which must have depth. It
// neither clears nor invalidates it. After each call these are as OpenGL has them initially, whatever they
// were (destroy(), and draw() where it returns an error, change none):
//   program, vertex array, array, uniform and pixel unpack buffer 0; active texture unit 0; of units
//   first_unit
//   .. first_unit + 12 the textures that karst used and the samplers, and uniform blocks first_block and
//   first_block + 1, unbound
//   scissor, depth and stencil test, blending, culling, polygon offset, rasterizer discard, sample coverage,
//   alpha to coverage, primitive restart, dithering; depth function, mask and range; colour mask; cull face
//   and front face; unpacking of pixels where the context has them: sample mask and shading, clip distances,
//   clip control, depth clamp, polygon mode, logic operation, multisampling, framebuffer sRGB, provoking
//   vertex
// The viewport is that of what was drawn last. create() and begin_frame() leave framebuffer 0 bound; draw()
// leaves Target::framebuffer bound for drawing where pixels are shaded once (Needs::deferred_width), and
// what was bound where not. Everything else stays as it is: blend and stencil functions, values of polygon
// offset, packing of pixels. Queries, transform feedback and conditional rendering of the simulator must not
// be active.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/export.h"
#include "karst/status.h"
#include "karst/types.h"
#include "karst/world.h"

namespace karst {

// What an eye sees. Matrices are in columns, as OpenGL has them.
struct ViewState {
  Vec3 eye{};
  // Rotation from the simulator's frame to the eye's: x right, y up, z backwards. Roll included; with
  // determinant -1 the picture is mirrored.
  double view_from_world[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  // Any perspective or parallel projection, off-axis and with an oblique near plane too; lengths in metres.
  double clip_from_view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  // How the eye moves, metres a frame: what it will see is read ahead, and nothing that would come too late.
  // Without has_motion: as it moved in the last eight frames.
  Vec3 motion{};
  bool has_motion = false;
  bool reversed_depth = false;  // the projection has 1 at the near plane: what is greater passes
  std::uint32_t width_px = 0, height_px = 0;  // of the picture, 1..16384
  double error_px = 4;  // wanted: no drawn point is further from the full surface. 0.01..1000
  double weight = 1;    // 1/64..64: where memory is short, a view of half the weight has twice the error
};

// Sets view_from_world so that the eye looks to the target, with up upwards. False where that is no
// direction.
KARST_API bool look_at(ViewState& view, Vec3 target, Vec3 up) noexcept;
// Sets clip_from_view: a symmetric perspective of square pixels, from width_px and height_px.
KARST_API void set_perspective(ViewState& view, double fov_y_deg, double near_m, double far_m) noexcept;

struct Sun {
  Vec3 towards{0.643, 0.528, 0.574};  // in the simulator's frame; need not have unit length
  double visibility_m = 0;  // where 5 % of a black thing's contrast is left; 0: 18 times the world's width
};

enum class Output : std::uint8_t {
  display,  // tone curve and sRGB, for framebuffers of 8 bits that encode nothing themselves
  linear    // light, a sunlit white surface being about 3.5: for HDR targets and the host's own tone curve
};

struct FrameInput {
  // 1..Needs::views; a view keeps its place in the list from frame to frame.
  std::span<const ViewState> views{};
  Sun sun{};
  // For making vertices, at the frame's end; 0: the frame waits until nothing lacks, and ends with io where
  // heights cannot be read.
  double work_ms = 3;
  std::uint32_t shadow_view = 0;  // whose place the shadow maps are around
  // Draws the simulator's own casters into a shadow map that is bound, with viewport and depth test set and
  // all else initial. clip_from_world: for places less `eye`. May be null. What is nearer to the sun than all
  // of the terrain is clipped, unless the vertex shader keeps it: gl_Position.z = max(gl_Position.z, -1.0).
  void (*draw_casters)(void* user, const double clip_from_world[16], Vec3 eye) = nullptr;
  void* user = nullptr;
  bool casters_moved = true;  // since the last frame: maps are drawn anew. Unused without draw_casters
};

// What a frame had to give up, and what to raise.
enum FrameLimit : std::uint32_t {
  kLimitVertexMemory = 1,  // Needs::vertex_bytes: the picture or what casts shadows is coarser
  kLimitWork = 2,          // FrameInput::work_ms: coarser until more vertices are made, or edits measured
  kLimitDrawItems = 4,     // more patches in view than the plan draws: distant parts are missing
  kLimitFile = 8,  // heights or tiles could not be read: coarser until they can; asked again 4 times a second
  kLimitTiles = 16  // Needs::max_cpu_bytes: no room for more tiles of the ground; it is coarser
};

struct FrameResult {
  double error_px[kMostViews] = {};  // the bound that each view keeps
  std::uint32_t made = 0;            // patches whose vertices were made for it
  std::uint32_t lacking = 0;         // patches that are drawn coarser than wanted
  std::uint64_t triangles = 0;       // of all views
  std::uint64_t uploaded_bytes = 0;
  std::uint32_t limits = 0;  // FrameLimit bits
  bool complete = false;     // nothing lacks that memory has room for
};

struct Target {
  Rect viewport{};
  bool sky = true;  // false: what is there stays where there is no terrain
  Output output = Output::display;
  // The one that is bound for drawing, which draw() binds again after its own: its name where the plan has
  // Needs::deferred_width; unused without.
  std::uint32_t framebuffer = 0;
  // Depth reaches the buffer by way of 0..1, not -1..1; matrices stay as they are. With reversed_depth and a
  // float depth buffer depth is then as fine far away as nearby: near may be 0.1 m and far 100 km. Needs
  // DeviceInfo::clip_control, else unsupported. Whoever draws into the same depth sets glClipControl alike.
  bool depth_zero_to_one = false;
  // Without clip control: where the projection's far plane is more than 2,048 times as far as its near plane,
  // depth is in two ranges, as depth_ranges() tells, so that near may be 0.1 m and far 100 km on any driver.
  // What is in one of them alone is drawn once; where one range does, this changes nothing. Whoever draws
  // into the same depth draws once for each range. Not with depth_zero_to_one.
  bool two_ranges = false;
};

// A range of depth: what lies between two distances along the view goes to a part of the buffer.
struct DepthRange {
  double near_m = 0, far_m = 0;           // of the projection to draw it with, all else as the view has it
  float buffer_near = 0, buffer_far = 1;  // for glDepthRangef
};
// What Target::two_ranges makes of a view: returns 1 or 2, the nearer range first. The ranges overlap a
// little. One, the view's own, of parallel views, oblique near planes, endless far planes and reversed depth.
KARST_API std::uint32_t depth_ranges(const ViewState& view, DepthRange (&ranges)[2]) noexcept;

// Light and air of a view, for the simulator's own shaders to look alike; linear light.
struct Air {
  float sun_towards[3], sun_rgb[3], zenith_rgb[3], horizon_rgb[3], sky_rgb[3], ground_rgb[3];
  float haze_per_m;
  float horizon_display_rgb[3];  // horizon_rgb as Output::display shows it: to clear with
  std::uint32_t block;           // uniform buffer of air_glsl()'s block KarstAir, for this view
  std::uint32_t shadow_texture;  // GL_TEXTURE_2D_ARRAY with comparison, for karst_shadow_maps; 0: none
};

struct GlOptions {
  std::uint32_t first_unit = 0;   // of 13 texture units
  std::uint32_t first_block = 0;  // of 2 uniform blocks
  bool desktop = false;           // a context of OpenGL 4.3 or later instead of OpenGL ES 3.0
  Shading shading = Shading::automatic;
  Detail detail = Detail::medium;
  Precision precision = Precision::automatic;
  // Of ground seen at a grazing angle: places at most that a lookup in its textures, or the drape, mixes
  // along a pixel's longer side, where the driver has EXT_texture_filter_anisotropic. 1..16, 1: none; 0: 4,
  // or 1 where a processor renders.
  std::uint32_t anisotropy = 0;
  bool smooth_edges = false;  // silhouettes, where shading is deferred; else by samples of the host's target
  // Where shading is deferred, the depth of all targets is DeviceInfo::depth_texture, which the host attaches
  // to its framebuffers: 4 bytes a pixel less, and faster. Viewports then begin at 0, 0, and draw() clears
  // that depth.
  bool share_depth = false;
  bool timers = false;  // GPU times of passes, in costs(); the host must not time with such queries meanwhile
  bool debug = false;   // the driver's errors go to the world's log; wants a debug context of one's own
  double drape_repeat = 1;  // times that the drape covers the world on each axis, 2^-10..2^10
};

class KARST_API Renderer {
 public:
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  // Makes all GL objects; none is made later. One renderer a world at a time; it lives in the world's memory.
  // unsupported, limit_reached: the device cannot do it; the log has the driver's words.
  static Status create(World& world, const GlLoader& loader, const GlOptions& options,
                       Renderer*& out) noexcept;
  void destroy() noexcept;       // deletes them
  void context_lost() noexcept;  // instead: forgets them, without calling GL

  // The image over the world: rgba of 8 bits, row 0 in the north, as large as the plan says.
  Status set_drape(std::span<const std::uint8_t> rgba) noexcept;

  // Chooses the levels of all views together, so that they share the memory and none takes from another;
  // makes what must be there; draws shadow maps. invalid_argument names the view's or the sun's field.
  Status begin_frame(const FrameInput& input, FrameResult& result) noexcept;
  // Draws a view of the frame into the bound framebuffer, any number of times.
  Status draw(std::uint32_t view, const Target& target) noexcept;
  // Makes vertices for the next frames while the GPU works, for work_ms.
  Status end_frame() noexcept;

  Air air(std::uint32_t view) const noexcept;
  // Functions for fragment shaders of #version 300 es, to be put after the precision lines; places are less
  // the eye, in the simulator's frame and metres:
  //   vec3 karst_light(vec3 from_eye, vec3 normal, vec3 albedo)  sun, with shadows, and sky
  //   vec3 karst_haze(vec3 light, vec3 from_eye)                 and water, where the world has any
  //   vec4 karst_display(vec3 light)                             Output::display
  static const char* air_glsl() noexcept;

 protected:
  Renderer() = default;
  ~Renderer() = default;
};

}  // namespace karst
