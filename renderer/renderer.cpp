// SPDX-License-Identifier: MIT
#include "renderer/renderer.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "renderer/gl/gl_state.h"
#include "renderer/passes/screen_pass.h"
#include "renderer/passes/shadow_pass.h"
#include "renderer/passes/sky_pass.h"
#include "renderer/passes/terrain_pass.h"
#include "renderer/resources/ground_objects.h"
#include "renderer/resources/material_textures.h"
#include "renderer/resources/object_table.h"

namespace karst::core {
namespace {

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

bool inside(std::int64_t value, std::int64_t least, std::int64_t most) {
  return value >= least && value <= most;
}

// Whether back faces are thrown away by pixels: of patches' slivers alone does the driver lose any.
bool culls_pixels(const RendererSettings& settings, const GlCaps& caps) {
  return caps.culls_unrounded && settings.patches;
}

// by_pixels: culls_pixels().
DrawState state_of(const ViewInput& input, const DrawTarget& target, bool by_pixels) {
  DrawState state;
  // Depth alone has no pixels' program that could.
  state.cull = !by_pixels || target.writes == Writes::depth;
  state.viewport = target.viewport;
  state.mirrored = input.camera.mirrored;
  const bool again = target.writes == Writes::colour;
  if (input.camera.reversed_depth) {
    state.depth_func = again ? GL_GEQUAL : GL_GREATER;
  } else {
    state.depth_func = again ? GL_LEQUAL : GL_LESS;
  }
  state.depth_writes = !again;
  state.colour_writes = target.writes != Writes::depth;
  state.depth_zero_to_one = target.depth_zero_to_one;
  state.linear = target.linear;
  return state;
}

bool wants_high(Precision precision, const GlCaps& caps) {
  return precision == Precision::automatic ? caps.software : precision == Precision::high;
}

// Where a processor renders, each place is as dear as a lookup.
int anisotropy_of(int wanted, const GlCaps& caps) {
  const int places = wanted > 0 ? wanted : caps.software ? 1 : RendererSettings::kAutomaticAnisotropy;
  return std::clamp(places, 1, std::max(1, caps.max_anisotropy));
}

}  // namespace

Status Renderer::create(const Gl& gl, const RendererSettings& settings) {
  destroy();
  message_[0] = '\0';
  device_ = {};
  settings_ = settings;
  if (const Status status = settings.validate(); !status.ok()) return status;
  device_.gl = gl;
  device_.first_unit = settings.first_unit;
  device_.first_block = settings.first_block;
  // Errors of the host must not be taken for karst's.
  pending_error_ = take_gl_errors(gl);
  if (const Status status = query_gl_caps(gl, settings.desktop, device_.caps); !status.ok()) {
    std::snprintf(message_, sizeof message_, "%s", device_.caps.version);
    return status;
  }
  const bool deferred = settings.shading == karst::Shading::automatic
                            ? device_.caps.software
                            : settings.shading == karst::Shading::deferred;
  if (!deferred) settings_.deferred_width = settings_.deferred_height = 0;
  settings_.precision = wants_high(settings.precision, device_.caps) ? Precision::high : Precision::medium;
  settings_.anisotropy = anisotropy_of(settings.anisotropy, device_.caps);
  if (const Status status = check_device(); !status.ok()) return status;
  created_ = true;  // from here on destroy() has something to do
  listen(true);
  const Status status = create_objects();
  reset_state(true);
  if (!status.ok()) destroy();
  return status;
}

Status Renderer::create_objects() {
  const Gl& gl = device_.gl;
  const ProgramSettings programs{.materials = std::max(static_cast<int>(settings_.material_count), 1),
                                 .detail = static_cast<int>(settings_.detail),
                                 .anisotropy = settings_.anisotropy,
                                 .high_precision = settings_.precision == Precision::high,
                                 .drape = settings_.drape_width > 0,
                                 .deferred = settings_.deferred(),
                                 .water = settings_.water,
                                 .curved = settings_.curved,
                                 .blend_map = settings_.blend_width > 0,
                                 .imagery = settings_.image_layers > 0,
                                 .voxel_materials = settings_.mesh_materials,
                                 .edges = settings_.smooth_edges,
                                 .share_depth = settings_.share_depth,
                                 .shadows = settings_.cascades > 0,
                                 .cull_pixels = culls_pixels(settings_, device_.caps),
                                 .first_unit = settings_.first_unit,
                                 .first_block = settings_.first_block,
                                 .label = device_.caps.debug};
  if (const Status status = programs_.create(gl, programs, message_); !status.ok()) return status;
  enter_upload(device_);
  const Status status = device_.objects.create(gl, object_rows(), settings_, device_.caps.debug);
  if (!status.ok()) return status;
  pages_.create(settings_);
  if (settings_.timers) {
    timer_.create(gl, device_.caps);
    shadow_timer_.create(gl, device_.caps);
  }
  if (take_gl_errors(gl) == GL_NO_ERROR) return {};
  return {StatusCode::limit_reached, "the driver could not make the buffers and textures", "GPU memory"};
}

void Renderer::destroy() {
  if (!created_) return;
  listen(false);
  const Gl& gl = device_.gl;
  timer_.destroy(gl);
  shadow_timer_.destroy(gl);
  programs_.destroy(gl);
  device_.objects.destroy(gl);  // which unmaps the vertices
  fences_.destroy(gl);
  forget();
}

void Renderer::forget() {
  timer_.forget();
  shadow_timer_.forget();
  programs_.forget();
  device_.objects.forget();
  fences_.forget();
  pages_.create(settings_);
  rim_vertices_ = 0;
  counts_ = {};
  created_ = false;
}

// OpenGL ES 3.0 promises textures of 2048, indices up to 2^24 - 1, 32 texture units and 24 uniform blocks; a
// Config within its ranges needs no more, images and hosts' numbers may.
Status Renderer::check_device() const {
  const GlCaps& caps = device_.caps;
  const auto limit = [](const char* field, std::int64_t value) {
    return Status{StatusCode::limit_reached, "more than the device can do", field,
                  static_cast<std::uint64_t>(value)};
  };
  if (settings_.deferred_width > caps.max_texture_size)
    return limit("deferred_width", settings_.deferred_width);
  if (settings_.deferred_height > caps.max_texture_size)
    return limit("deferred_height", settings_.deferred_height);
  if (settings_.drape_width > caps.max_texture_size) return limit("drape_width", settings_.drape_width);
  if (settings_.drape_height > caps.max_texture_size) return limit("drape_height", settings_.drape_height);
  if (page_table_rows(settings_) > caps.max_texture_size ||
      std::int64_t{settings_.all_pages()} * kPageVertices - 1 > caps.max_element_index) {
    return limit("vertex_pages", settings_.all_pages());
  }
  if (morph_texture_rows(settings_.all_rows()) > caps.max_texture_size)
    return limit("morph_rows", settings_.all_rows());
  if (std::int64_t{settings_.first_unit} + KARST_UNITS > caps.max_texture_units)
    return limit("first_unit", settings_.first_unit);
  if (std::int64_t{settings_.first_block} + KARST_BLOCKS > caps.max_uniform_bindings)
    return limit("first_block", settings_.first_block);
  return {};
}

// The driver's error messages.
void Renderer::listen(bool on) {
  const Gl& gl = device_.gl;
  if (!device_.caps.debug || !settings_.debug) return;
  gl.DebugMessageCallbackKHR(on ? on_debug_message : nullptr, on ? this : nullptr);
  if (!on) return;
  gl.Enable(GL_DEBUG_OUTPUT_KHR);
  gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS_KHR);
  gl.DebugMessageControlKHR(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_FALSE);
  gl.DebugMessageControlKHR(GL_DONT_CARE, GL_DEBUG_TYPE_ERROR_KHR, GL_DONT_CARE, 0, nullptr, GL_TRUE);
}

Status Renderer::upload_drape(std::span<const std::uint8_t> rgba) {
  return core::upload_drape(device_, settings_, rgba);
}

Status Renderer::set_materials(const MaterialSet& materials) {
  return core::set_materials(device_, settings_, materials);
}

Status Renderer::upload_blend_texels(const TexelRect& texels, std::span<const std::byte> bytes) {
  counts_.uploaded_bytes += bytes.size();
  return core::upload_blend_texels(device_, settings_, texels, bytes);
}

void Renderer::finish_blend_map() {
  if (settings_.blend_width > 0) core::finish_blend_map(device_);
}

Status Renderer::upload_textures(TextureArray array, int level, int first_layer, int layers,
                                 std::span<const std::byte> bytes) {
  return core::upload_textures(device_, settings_, array, level, first_layer, layers, bytes);
}

Status Renderer::upload_rim(std::span<const glm::ivec3> rim, std::int32_t plain_steps) {
  return core::upload_rim(device_, settings_, rim, plain_steps, rim_vertices_);
}

Status Renderer::upload_image(std::uint32_t layer, std::span<const std::byte> texels) {
  counts_.uploaded_bytes += texels.size();
  return core::upload_image(device_, settings_, layer, texels);
}

Status Renderer::upload_image_table(std::uint32_t view, int size, std::span<const std::uint16_t> part) {
  counts_.uploaded_bytes += part.size_bytes();
  return core::upload_image_table(device_, settings_, view, size, part);
}

void Renderer::set_sky(const SkyAtlas& sky) {
  KARST_ASSERT(sky.cells == settings_.sky.cells && sky.count == settings_.sky.count);
  settings_.sky = sky;
}

Status Renderer::upload_sky(const SkyVisibility& sky, std::size_t place) {
  return core::upload_sky(device_, settings_, sky, place);
}

Status Renderer::upload_vertices(const PageTable& pages, PatchId patch, std::uint32_t first,
                                 std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                                 PatchShading shading) {
  fences_.wait(device_.gl);
  return pages_.upload(device_, pages, patch, first, vertices, origin, row, shading);
}

Status Renderer::upload_shading(const PageTable& pages, PatchId patch, std::uint32_t vertices,
                                glm::ivec3 origin, std::uint32_t row, PatchShading shading) {
  return pages_.upload_shading(pages, patch, vertices, origin, row, shading);
}

Status Renderer::upload_node(const PageTable& pages, std::uint32_t page, const NodePage& node,
                             std::span<const GpuVertex, kNodePageVertices> vertices) {
  fences_.wait(device_.gl);
  return pages_.upload_node(device_, pages, page, node, vertices);
}

Status Renderer::upload_mesh(const PageTable& pages, const MeshPages& chain, const MeshPage& mesh,
                             std::span<const GpuVertex> vertices) {
  fences_.wait(device_.gl);
  return pages_.upload_mesh(device_, pages, chain, mesh, vertices);
}

Status Renderer::upload_morph_rows(std::uint32_t first_row, std::span<const std::uint16_t> rows) {
  return pages_.upload_morph_rows(device_, first_row, rows);
}

Status Renderer::set_air(std::uint32_t view, const shader::KarstAir& block) {
  if (view >= static_cast<std::uint32_t>(settings_.air_blocks)) {
    return invalid("the settings have fewer air_blocks", "view", view);
  }
  device_.gl.BindBuffer(GL_UNIFORM_BUFFER, air_block(view));
  device_.gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
  device_.gl.BindBuffer(GL_UNIFORM_BUFFER, 0);
  return {};
}

GLuint Renderer::air_block(std::uint32_t view) const {
  if (view >= static_cast<std::uint32_t>(settings_.air_blocks)) return 0;
  return name_of(device_, nth(Object::air_block_0, static_cast<int>(view)));
}

GLuint Renderer::shadow_maps() const {
  return name_of(device_, Object::shadow_maps);
}

GLuint Renderer::shared_depth() const {
  return settings_.share_depth && settings_.deferred() ? name_of(device_, Object::geometry_depth) : 0;
}

void Renderer::begin(const PageTable& pages) {
  fences_.wait(device_.gl);
  if (!pages_.flush(device_, pages)) counts_.vertices_lost = true;
}

Status Renderer::draw_cascade(int index, const CascadeInput& input) {
  if (!inside(index, 0, settings_.cascades - 1)) return invalid("none of the settings' cascades", "index");
  begin(input.pages);
  Status status;
  if (!counts_.vertices_lost) {
    shadow_timer_.begin(device_.gl);
    status = draw_shadow_map(device_, settings_, programs_, index, input, counts_);
    shadow_timer_.end(device_.gl);
  }
  reset_state(true);
  return status;
}

Status Renderer::draw(const ViewInput& input, const DrawTarget& target) {
  if (const Status status = input.light.validate(); !status.ok()) return status;
  if (input.cascades.size() > static_cast<std::size_t>(settings_.cascades)) {
    return invalid("more than the settings' cascades", "cascades", input.cascades.size());
  }
  const Rect& view = target.viewport;
  if (!inside(view.width, 1, RendererSettings::kMaxPicture) ||
      !inside(view.height, 1, RendererSettings::kMaxPicture)) {
    return invalid("not within 1..16384 pixels", "viewport");
  }
  if (is_deferred(input, target) && settings_.share_depth && (view.x != 0 || view.y != 0)) {
    return invalid("must begin where the depth that is shared does, at 0, 0", "viewport");
  }
  if (target.depth_zero_to_one && !device_.caps.clip_control) {
    return {StatusCode::unsupported, "the driver lacks clip control", "depth_zero_to_one"};
  }
  begin(input.pages);
  const shader::FrameBlock block = make_view_block(settings_, input, target);
  use_block(device_, Object::material_block, KARST_BINDING_MATERIALS, {});
  use_block(device_, Object::frame_block, KARST_BINDING_FRAME, as_bytes(block));
  timer_.begin(device_.gl);
  const Status status =
      is_deferred(input, target) ? draw_deferred(input, target) : draw_forward(input, target);
  timer_.end(device_.gl);
  reset_state(false);
  return status;
}

bool Renderer::is_deferred(const ViewInput& input, const DrawTarget& target) const {
  return settings_.deferred() && target.viewport.width <= settings_.deferred_width &&
         target.viewport.height <= settings_.deferred_height && !input.camera.parallel &&
         !input.has_long_chords && input.show == Show::materials && target.writes == Writes::all;
}

// Draws what is drawn with depth once, or in each of two ranges; the nearer one first, which hides much.
template <class Draw>
Status Renderer::in_ranges(const ViewInput& input, const DrawTarget& target, Draw&& draw) {
  const DepthRanges ranges = ranges_of(input, target);
  if (ranges.count == 1) return draw(input);
  const shader::FrameBlock block = make_view_block(settings_, input, target);
  Status status;
  for (int range = 0; range < ranges.count && status.ok(); ++range)
    status = draw(enter_range(device_, ranges, range, input, block));
  leave_ranges(device_);
  return status;
}

Status Renderer::draw_forward(const ViewInput& input, const DrawTarget& target) {
  enter_draw(device_, state_of(input, target, culls_pixels(settings_, device_.caps)));
  bind_textures(device_);
  const bool edge = target.writes != Writes::depth && sees_edge(settings_, input, rim_vertices_);
  const auto draw = [&](const ViewInput& part) {
    Status status;
    if (!counts_.vertices_lost) {
      status = draw_terrain(device_, settings_, programs_, part, target, counts_);
    }
    if (status.ok() && edge) {
      draw_edge(device_, programs_,
                input.cascades.empty() ? ShaderVariant::edge : ShaderVariant::edge_shadowed, rim_vertices_,
                counts_);
    }
    return status;
  };
  const Status status = in_ranges(input, target, draw);
  if (status.ok() && target.sky && target.writes != Writes::depth) {
    draw_sky(device_, programs_, input.camera.reversed_depth, counts_);
  }
  return status;
}

Status Renderer::draw_deferred(const ViewInput& input, const DrawTarget& target) {
  DrawState state = state_of(input, target, culls_pixels(settings_, device_.caps));
  state.viewport = {0, 0, target.viewport.width, target.viewport.height};
  device_.gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, name_of(device_, Object::geometry_target));
  enter_draw(device_, state);
  bind_textures(device_);
  const bool edge = sees_edge(settings_, input, rim_vertices_);
  clear_geometry(device_, input);
  const Status status = in_ranges(input, target, [&](const ViewInput& part) {
    Status drawn;
    if (!counts_.vertices_lost) drawn = draw_geometry(device_, settings_, programs_, part, counts_);
    if (edge) draw_edge(device_, programs_, ShaderVariant::edge_geometry, rim_vertices_, counts_);
    return drawn;
  });
  device_.gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
  ViewInput shaded = input;
  if (edge) shaded.shading |= kShadeBlend;  // which the wall needs
  if (status.ok() && !counts_.vertices_lost)
    draw_screen(device_, settings_, programs_, shaded, target, counts_);
  // The background is drawn for its own pixels alone: llvmpipe runs both sides of a branch for all of them.
  if (status.ok() && target.sky && !settings_.smooth_edges)
    draw_sky(device_, programs_, input.camera.reversed_depth, counts_);
  return status;
}

void Renderer::reset_state(bool unbind) const {
  if (unbind) device_.gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
  unbind_textures(device_);
  core::reset_state(device_);
}

FrameCounts Renderer::end_frame() {
  fences_.end_frame(device_.gl);
  counts_.uploaded_bytes += pages_.take_uploaded_bytes();
  return std::exchange(counts_, {});
}

void GL_APIENTRY Renderer::on_debug_message(GLenum /*source*/, GLenum /*type*/, GLuint /*id*/,
                                            GLenum /*severity*/, GLsizei /*length*/, const GLchar* text,
                                            const void* user) {
  // The user pointer is the renderer that registered it, which is not const.
  auto* self = const_cast<Renderer*>(static_cast<const Renderer*>(user));
  if (self->message_[0] == '\0') std::snprintf(self->message_, sizeof self->message_, "%s", text);
}

}  // namespace karst::core
