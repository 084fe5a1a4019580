// SPDX-License-Identifier: MIT
#include "renderer/renderer.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>

#include "renderer/passes/present.h"
#include "renderer/passes/terrain_variants.h"
#include "renderer/resources/texture_layout.h"
#include "renderer/resources/variation_texture.h"
#include "terrain/draw/index_batches.h"
#include "terrain/field/sky_line.h"

namespace karst::core {
namespace {

// Levels of a full mip pyramid, and its texels; 0 x 0 has none.
constexpr int mip_levels(int width, int height) {
  return static_cast<int>(std::bit_width(static_cast<unsigned>(std::max(width, height))));
}
constexpr std::size_t mip_texels(int width, int height) {
  std::size_t texels = 0;
  for (int level = 0; level < mip_levels(width, height); ++level) {
    texels += static_cast<std::size_t>(std::max(width >> level, 1)) *
              static_cast<std::size_t>(std::max(height >> level, 1));
  }
  return texels;
}

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

bool inside(std::int64_t value, std::int64_t least, std::int64_t most) {
  return value >= least && value <= most;
}

// GL takes offsets into buffers as pointers.
const void* buffer_offset(std::size_t bytes) {
  return reinterpret_cast<const void*>(bytes);
}

}  // namespace

Status RendererSettings::validate() const {
  if (!inside(width, 1, kMaxPicture)) return invalid("not within 1..16384 pixels", "width");
  if (!inside(height, 1, kMaxPicture)) return invalid("not within 1..16384 pixels", "height");
  if (!inside(vertex_pages, 1, kMostPages))
    return invalid("not within its range", "vertex_pages", vertex_pages);
  if (!inside(morph_rows, 1, kMostPages)) return invalid("not within its range", "morph_rows", morph_rows);
  if (!inside(stream_indices, kLeastIndicesPerPatch, 1 << 26)) {
    return invalid("not within its range", "stream_indices", stream_indices);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!inside(extent[axis], 1, 1 << kMaxDepth)) return invalid("not within 1..512 voxels", "extent");
  }
  if (!inside(material_count, 0, kMostMaterials)) return invalid("not within 0..8", "material_count");
  if (material_count > 0 &&
      (!std::has_single_bit(material_side) || !inside(material_side, kLeastTextureSide, kMostTextureSide))) {
    return invalid("not a power of two within 16..1024", "material_side");
  }
  if (!inside(cascades, 0, kMostCascades)) return invalid("not within 0..3", "cascades");
  CascadeSettings shadows;
  shadows.size = shadow_size;
  if (!shadows.validate().ok()) return invalid("not a multiple of 16 within 512..2048", "shadow_size");
  if (shadow_bits != 16 && shadow_bits != 24) return invalid("neither 16 nor 24", "shadow_bits");
  if (drape_width != 0 || drape_height != 0) {
    if (!inside(drape_width, 1, kMaxPicture)) return invalid("not within 1..16384 pixels", "drape_width");
    if (!inside(drape_height, 1, kMaxPicture)) return invalid("not within 1..16384 pixels", "drape_height");
    if (!(drape_repeat >= 0x1p-10 && drape_repeat <= 0x1p10)) {
      return invalid("not within 2^-10..2^10", "drape_repeat");
    }
  }
  return {};
}

void RendererSettings::add_to(Budget& budget) const {
  const auto area = [](int a, int b) { return static_cast<std::size_t>(a) * static_cast<std::size_t>(b); };
  budget.add(GpuConsumer::vertices, std::size_t{vertex_pages} * kPageBytes);
  budget.add(GpuConsumer::page_table, area(page_rows(vertex_pages), kPageRowTexels) * sizeof(PageTexel));
  budget.add(GpuConsumer::morph_rows, area(morph_texture_rows(morph_rows), kPatchesPerRow * kMorphRow) * 2);
  budget.add(GpuConsumer::stream_indices, std::size_t{stream_indices} * 4);
  budget.add(GpuConsumer::uniforms, static_cast<std::size_t>(1 + cascades) * sizeof(shader::FrameBlock) +
                                        sizeof(shader::MaterialBlock));
  budget.add(GpuConsumer::shadow_maps, static_cast<std::size_t>(cascades) * area(shadow_size, shadow_size) *
                                           (shadow_bits == 16 ? 2 : 4));
  budget.add(GpuConsumer::textures,
             std::size_t{kVariationSide} * kVariationSide * kVariationSide + area(extent.x, extent.z) * 2 +
                 mip_texels(drape_width, drape_height) * 4 + area(kEntryRowTexels, kEntryRows));
  MaterialSet set;
  set.count = material_count;
  set.side = material_side;
  set.format = material_format;
  budget.add(GpuConsumer::materials, material_count == 0 ? kTextureArrays * 4 : texture_bytes(set));
  budget.add(GpuConsumer::targets, area(width, height) * (rgb565 ? 6 : 8));
}

Status Renderer::create(const Gl& gl, const RendererSettings& settings) {
  destroy();
  message_[0] = '\0';
  if (const Status status = settings.validate(); !status.ok()) return status;
  gl_ = gl;
  settings_ = settings;
  caps_ = {};
  if (const Status status = query_gl_caps(gl_, caps_); !status.ok()) {
    std::snprintf(message_, sizeof message_, "%s", caps_.version);
    return status;
  }
  if (const Status status = check_device(); !status.ok()) return status;
  created_ = true;  // from here on destroy() has something to do
  if (caps_.debug && settings_.debug) {
    gl_.Enable(GL_DEBUG_OUTPUT_KHR);
    gl_.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS_KHR);
    gl_.DebugMessageCallbackKHR(on_debug_message, this);
    gl_.DebugMessageControlKHR(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_FALSE);
    gl_.DebugMessageControlKHR(GL_DONT_CARE, GL_DEBUG_TYPE_ERROR_KHR, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  }
  Status status = programs_.create(
      gl_, {std::max(static_cast<int>(settings_.material_count), 1), settings_.high_precision}, message_);
  if (status.ok()) status = create_targets();
  if (status.ok()) status = create_shadow_maps();
  if (status.ok()) {
    create_buffers();
    create_textures();
    create_materials();
    timer_.create(gl_, caps_);
    shadow_timer_.create(gl_, caps_);
    label_objects();
    if (take_error() != GL_NO_ERROR) {
      status = {StatusCode::limit_reached, "the driver could not make the buffers and textures",
                "GPU memory"};
    }
  }
  if (!status.ok()) destroy();
  return status;
}

void Renderer::destroy() {
  if (!created_) return;
  if (caps_.debug && settings_.debug) gl_.DebugMessageCallbackKHR(nullptr, nullptr);
  timer_.destroy(gl_);
  shadow_timer_.destroy(gl_);
  programs_.destroy(gl_);
  GLuint* const buffers[] = {&vertex_buffer_, &index_buffer_, &frame_buffer_, &material_buffer_};
  GLuint* const arrays[] = {&vertex_array_, &no_attributes_};
  GLuint* const textures[] = {
      &page_table_, &morph_entries_, &morph_rows_, &material_arrays_[0], &material_arrays_[1], &variation_,
      &sky_line_,   &drape_,         &depth_,      &shadow_maps_};
  GLuint* const framebuffers[] = {&target_, &colour_target_};
  for (GLuint& name : cascade_buffers_) {
    if (name != 0) gl_.DeleteBuffers(1, &name);
    name = 0;
  }
  for (GLuint& name : shadow_targets_) {
    if (name != 0) gl_.DeleteFramebuffers(1, &name);
    name = 0;
  }
  for (GLuint* name : buffers) gl_.DeleteBuffers(1, name);
  for (GLuint* name : arrays) gl_.DeleteVertexArrays(1, name);
  for (GLuint* name : textures) {
    if (*name != 0) gl_.DeleteTextures(1, name);
  }
  for (GLuint* name : framebuffers) gl_.DeleteFramebuffers(1, name);
  gl_.DeleteRenderbuffers(1, &colour_);
  for (GLuint* name : buffers) *name = 0;
  for (GLuint* name : arrays) *name = 0;
  for (GLuint* name : textures) *name = 0;
  for (GLuint* name : framebuffers) *name = 0;
  colour_ = 0;
  for (GLsync& fence : fences_) {
    if (fence != nullptr) gl_.DeleteSync(fence);
    fence = nullptr;
  }
  changed_page_rows_.reset();
  mapped_ = nullptr;  // deleting the buffer unmapped it
  pending_ = {};
  has_picture_ = false;
  created_ = false;
}

// OpenGL ES 3.0 promises textures of 2048 and indices up to 2^24 - 1; a Config within its ranges needs no
// more, pictures may.
Status Renderer::check_device() const {
  const auto limit = [](const char* field, std::int64_t value) {
    return Status{StatusCode::limit_reached, "more than the device can do", field,
                  static_cast<std::uint64_t>(value)};
  };
  const std::int32_t most_pixels = std::min(caps_.max_texture_size, caps_.max_renderbuffer_size);
  if (settings_.width > std::min(most_pixels, caps_.max_viewport[0])) return limit("width", settings_.width);
  if (settings_.height > std::min(most_pixels, caps_.max_viewport[1]))
    return limit("height", settings_.height);
  if (settings_.drape_width > caps_.max_texture_size) return limit("drape_width", settings_.drape_width);
  if (settings_.drape_height > caps_.max_texture_size) return limit("drape_height", settings_.drape_height);
  if (page_rows(settings_.vertex_pages) > caps_.max_texture_size ||
      std::int64_t{settings_.vertex_pages} * kPageVertices - 1 > caps_.max_element_index) {
    return limit("vertex_pages", settings_.vertex_pages);
  }
  if (morph_texture_rows(settings_.morph_rows) > caps_.max_texture_size)
    return limit("morph_rows", settings_.morph_rows);
  return {};
}

Status Renderer::create_targets() {
  gl_.GenRenderbuffers(1, &colour_);
  gl_.BindRenderbuffer(GL_RENDERBUFFER, colour_);
  gl_.RenderbufferStorage(GL_RENDERBUFFER, settings_.rgb565 ? GL_RGB565 : GL_RGBA8, settings_.width,
                          settings_.height);
  depth_ =
      make_texture(KARST_UNIT_DEPTH, GL_DEPTH_COMPONENT24, 1, settings_.width, settings_.height, GL_NEAREST);
  gl_.GenFramebuffers(1, &target_);
  gl_.GenFramebuffers(1, &colour_target_);
  for (const GLuint framebuffer : {colour_target_, target_}) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
    if (framebuffer == target_) {
      gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
    }
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      return {StatusCode::limit_reached, "the driver could not make a framebuffer of this size",
              "width, height"};
    }
  }
  return {};
}

void Renderer::create_buffers() {
  constexpr GLsizei kStride = sizeof(GpuVertex);
  gl_.GenBuffers(1, &vertex_buffer_);
  gl_.GenBuffers(1, &index_buffer_);
  gl_.GenBuffers(1, &frame_buffer_);
  gl_.GenVertexArrays(1, &no_attributes_);
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(settings_.vertex_pages * kPageBytes), nullptr,
                 GL_DYNAMIC_DRAW);
  gl_.VertexAttribIPointer(KARST_LOCATION_POSITION, 4, GL_SHORT, kStride, buffer_offset(0));
  gl_.VertexAttribIPointer(KARST_LOCATION_MORPH, 4, GL_SHORT, kStride, buffer_offset(kStride / 2));
  gl_.EnableVertexAttribArray(KARST_LOCATION_POSITION);
  gl_.EnableVertexAttribArray(KARST_LOCATION_MORPH);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer_);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(settings_.stream_indices) * 4, nullptr,
                 GL_STREAM_DRAW);
  gl_.BindVertexArray(0);
  gl_.BindBuffer(GL_UNIFORM_BUFFER, frame_buffer_);
  gl_.BufferData(GL_UNIFORM_BUFFER, sizeof(shader::FrameBlock), nullptr, GL_DYNAMIC_DRAW);
}

GLuint Renderer::make_texture(GLenum unit, GLenum format, int levels, int width, int height, GLenum filter) {
  GLuint texture = 0;
  gl_.GenTextures(1, &texture);
  gl_.ActiveTexture(GL_TEXTURE0 + unit);
  gl_.BindTexture(GL_TEXTURE_2D, texture);
  gl_.TexStorage2D(GL_TEXTURE_2D, levels, format, width, height);
  const GLint smaller = static_cast<GLint>(levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : filter);
  const GLint wrap = levels > 1 ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, smaller);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  return texture;
}

void Renderer::create_textures() {
  page_table_ = make_texture(KARST_UNIT_PAGE_TABLE, GL_RG32UI, 1, kPageRowTexels,
                             page_rows(settings_.vertex_pages), GL_NEAREST);
  morph_rows_ = make_texture(KARST_UNIT_MORPH_ROWS, GL_R16F, 1, kPatchesPerRow * kMorphRow,
                             morph_texture_rows(settings_.morph_rows), GL_NEAREST);
  morph_entries_ =
      make_texture(KARST_UNIT_MORPH_ENTRIES, GL_R8UI, 1, kEntryRowTexels, kEntryRows, GL_NEAREST);
  std::uint8_t entries[kEntryRowTexels * kEntryRows] = {};
  static_cast<void>(build_morph_entries(kMaxLevel, entries));  // fails for wrong sizes only
  gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kEntryRowTexels, kEntryRows, GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                    entries);

  if (settings_.drape_width > 0) {
    drape_ =
        make_texture(KARST_UNIT_DRAPE, GL_RGBA8, mip_levels(settings_.drape_width, settings_.drape_height),
                     settings_.drape_width, settings_.drape_height, GL_LINEAR);
    // One level a pixel: half the texels of trilinear filtering.
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
  }

  sky_line_ =
      make_texture(KARST_UNIT_SKY_LINE, GL_R16F, 1, settings_.extent.x, settings_.extent.z, GL_LINEAR);
  float row[1 << kMaxDepth];
  std::fill(std::begin(row), std::end(row), -1e4f);  // below everything: no cave anywhere
  for (int z = 0; z < settings_.extent.z; ++z) {
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, z, settings_.extent.x, 1, GL_RED, GL_FLOAT, row);
  }
}

void Renderer::label_objects() {
  if (!caps_.debug) return;
  const auto label = [&](GLenum kind, GLuint name, const char* text) {
    gl_.ObjectLabelKHR(kind, name, -1, text);
  };
  label(GL_BUFFER_KHR, vertex_buffer_, "vertices");
  label(GL_BUFFER_KHR, index_buffer_, "stream_indices");
  label(GL_BUFFER_KHR, frame_buffer_, "frame block");
  label(GL_VERTEX_ARRAY_KHR, vertex_array_, "terrain");
  label(GL_TEXTURE, page_table_, "page_table");
  label(GL_TEXTURE, morph_entries_, "morph_entries");
  label(GL_TEXTURE, morph_rows_, "morph_rows");
  label(GL_TEXTURE, material_arrays_[0], "albedo_height");
  label(GL_TEXTURE, material_arrays_[1], "normal_roughness");
  label(GL_TEXTURE, variation_, "variation");
  label(GL_TEXTURE, sky_line_, "sky_line");
  label(GL_TEXTURE, depth_, "depth");
  if (shadow_maps_ != 0) label(GL_TEXTURE, shadow_maps_, "shadow_maps");
  if (drape_ != 0) label(GL_TEXTURE, drape_, "drape");
  label(GL_RENDERBUFFER, colour_, "colour");
  label(GL_FRAMEBUFFER, target_, "target");
  label(GL_FRAMEBUFFER, colour_target_, "target without depth");
  for (std::size_t i = 0; i < kShaderVariants; ++i) {
    label(GL_PROGRAM_KHR, programs_[static_cast<ShaderVariant>(i)], kShaderTexts[i].name);
  }
}

Status Renderer::upload_drape(std::span<const std::uint8_t> rgba) {
  const std::size_t bytes =
      static_cast<std::size_t>(settings_.drape_width) * static_cast<std::size_t>(settings_.drape_height) * 4;
  if (drape_ == 0) return invalid("the settings have no image", "drape_width");
  if (rgba.size() < bytes) return invalid("too short", "rgba", bytes);
  gl_.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_DRAPE);
  gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, settings_.drape_width, settings_.drape_height, GL_RGBA,
                    GL_UNSIGNED_BYTE, rgba.data());
  gl_.GenerateMipmap(GL_TEXTURE_2D);
  return {};
}

void Renderer::upload_sky_line(const Octree& octree) {
  gl_.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_SKY_LINE);
  SkyLine rows(octree, settings_.extent);
  float row[1 << kMaxDepth];
  for (int z = 0; z < settings_.extent.z; ++z) {
    rows.next(row);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, z, settings_.extent.x, 1, GL_RED, GL_FLOAT, row);
  }
}

void Renderer::wait_for_frame() {
  GLsync& fence = fences_[frame_ % kFramesInFlight];
  if (fence == nullptr) return;
  constexpr GLuint64 kHangs = 1'000'000'000;  // nanoseconds; a GPU that takes longer is reset by its driver
  gl_.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, kHangs);
  gl_.DeleteSync(fence);
  fence = nullptr;
}

Status Renderer::draw(const FrameInput& input, FrameCounts& counts) {
  counts = {};
  if (const Status status = input.light.validate(); !status.ok()) return status;
  if (input.cascades.size() > static_cast<std::size_t>(settings_.cascades)) {
    return invalid("more than the settings' cascades", "cascades", input.cascades.size());
  }
  begin_frame(input.pages);
  counts = pending_;
  pending_ = {};
  const int upright_height = (input.quarter_turns & 1) != 0 ? settings_.width : settings_.height;
  shader::FrameBlock block =
      make_frame_block(input.camera, input.least_cos2, input.light, settings_.extent, upright_height);
  turn_frame_block(block, input.quarter_turns);
  set_drape(settings_.extent, settings_.drape_repeat, block);
  set_cascades(input.camera, input.light_space, input.cascades, settings_.shadow_size, block);
  const PixelSkips& skips = input.skips;
  block.least_work = {skips.triplanar ? 0 : 3, skips.blend ? 0 : 2, skips.detail ? 0 : 1, skips.sun ? 0 : 1};
  set_lights(input.camera, input.lights, settings_.cascades == 0, block);
  use_block(frame_buffer_, block);

  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_);
  gl_.Viewport(0, 0, settings_.width, settings_.height);
  timer_.begin(gl_);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Enable(GL_CULL_FACE);
  gl_.CullFace(GL_BACK);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_LESS);
  if (drape_ != 0) {
    // The sky is one colour here; its own shading would cost as much a pixel as the terrain's.
    const glm::vec3 sky = encode_picture(block.sky_horizon);
    gl_.ClearColor(sky.r, sky.g, sky.b, 1.0f);
    gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  } else {
    const GLenum colour = GL_COLOR_ATTACHMENT0;
    gl_.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, &colour);  // terrain and sky cover every pixel
    gl_.Clear(GL_DEPTH_BUFFER_BIT);
  }

  push_group("terrain");
  const auto shading =
      static_cast<std::uint8_t>(input.shading | (input.cascades.empty() ? 0 : kShadeShadows));
  gl_.UseProgram(programs_[drape_ != 0 ? ShaderVariant::drape : terrain_variant(shading)]);
  const ExpandIndices expand{input.index_table, input.items, input.pages, {}};
  Status status;
  if (!counts.vertices_lost) {
    status = settings_.show == Show::materials || drape_ != 0 ? draw_items(expand, input.max_level, counts)
                                                              : draw_shown(input, expand, counts);
  }
  pop_group();
  if (!status.ok()) return status;

  if (drape_ == 0) draw_sky(counts);
  if (!settings_.keep_depth) {
    const GLenum depth = GL_DEPTH_ATTACHMENT;
    gl_.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, &depth);
  }
  timer_.end(gl_);
  fences_[frame_++ % kFramesInFlight] = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  has_picture_ = true;
  return {};
}

// A call for each run of items of one level.
Status Renderer::draw_shown(const FrameInput& input, const ExpandIndices& expand, FrameCounts& counts) {
  const GLuint program =
      programs_[settings_.show == Show::cascades ? ShaderVariant::show_cascades : ShaderVariant::show_levels];
  gl_.UseProgram(program);
  const GLint shown_level = gl_.GetUniformLocation(program, "shown_level");
  for (std::size_t first = 0; first < input.items.size();) {
    const std::uint8_t level = input.items[first].level;
    std::size_t end = first + 1;
    while (end < input.items.size() &&
           (input.items[end].level == level || settings_.show == Show::cascades)) {
      ++end;
    }
    if (shown_level >= 0) gl_.Uniform1i(shown_level, level);
    ExpandIndices run = expand;
    run.items = input.items.subspan(first, end - first);
    if (const Status status = draw_items(run, input.max_level, counts); !status.ok()) return status;
    first = end;
  }
  return {};
}

void Renderer::draw_sky(FrameCounts& counts) {
  push_group("sky");
  // Where nothing was drawn the depth is still 1, which is the sky's.
  gl_.DepthFunc(GL_EQUAL);
  gl_.DepthMask(GL_FALSE);
  gl_.BindVertexArray(no_attributes_);
  gl_.UseProgram(programs_[ShaderVariant::sky]);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.DepthMask(GL_TRUE);
  pop_group();
  counts.draw_calls += 1;
  counts.triangles += 1;
}

void Renderer::begin_frame(const PageTable& pages) {
  wait_for_frame();
  flush_uploads(pages);
}

void Renderer::use_block(GLuint buffer, const shader::FrameBlock& block) {
  gl_.BindBuffer(GL_UNIFORM_BUFFER, buffer);
  gl_.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, KARST_BINDING_FRAME, buffer);
}

Status Renderer::draw_items(ExpandIndices expand, int max_level, FrameCounts& counts) {
  if (expand.items.empty()) return {};
  gl_.BindVertexArray(vertex_array_);
  const auto bytes = static_cast<GLsizeiptr>(settings_.stream_indices) * 4;
  for (ExpandIndices::Chunk chunk; chunk.next_item < expand.items.size();) {
    // Invalidating lets the driver give fresh memory while the GPU still reads the last chunk.
    void* mapped = gl_.MapBufferRange(GL_ELEMENT_ARRAY_BUFFER, 0, bytes,
                                      GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
    if (mapped == nullptr)
      return {StatusCode::limit_reached, "the driver cannot map the index stream", "GPU memory"};
    expand.out = {static_cast<std::uint32_t*>(mapped), settings_.stream_indices};
    const Status status = chunk.next_item == 0 ? expand.validate(max_level) : Status();
    if (status.ok()) chunk = expand.run(chunk.next_item);
    const bool intact = gl_.UnmapBuffer(GL_ELEMENT_ARRAY_BUFFER) == GL_TRUE;
    if (!status.ok()) return status;
    counts.left_out += chunk.left_out;
    // What was written is lost where a driver says so (a change of the screen's mode): the next frame draws
    // it.
    if (!intact || chunk.indices == 0) continue;
    gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(chunk.indices), GL_UNSIGNED_INT, buffer_offset(0));
    counts.draw_calls += 1;
    counts.triangles += chunk.indices / 3;
  }
  return {};
}

// GL's rows go upwards; pictures' go downwards.
void Renderer::read_pixels(void* rgba) {
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl_.ReadPixels(0, 0, settings_.width, settings_.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
  const std::size_t row = static_cast<std::size_t>(settings_.width) * 4;
  auto* top = static_cast<std::uint8_t*>(rgba);
  auto* bottom = top + row * static_cast<std::size_t>(settings_.height - 1);
  for (; top < bottom; top += row, bottom -= row) std::swap_ranges(top, top + row, bottom);
}

Status Renderer::read_colour(std::span<std::uint8_t> rgba) {
  const std::size_t bytes =
      static_cast<std::size_t>(settings_.width) * static_cast<std::size_t>(settings_.height) * 4;
  if (!has_picture_) return invalid("nothing was drawn yet", "picture");
  if (rgba.size() < bytes) return invalid("too short", "rgba", bytes);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_);
  read_pixels(rgba.data());
  return {};
}

Status Renderer::read_depth(std::span<float> depth) {
  const std::size_t pixels =
      static_cast<std::size_t>(settings_.width) * static_cast<std::size_t>(settings_.height);
  if (!has_picture_ || !settings_.keep_depth) return invalid("no depth was kept", "keep_depth");
  if (depth.size() < pixels) return invalid("too short", "depth", pixels);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_target_);
  gl_.Viewport(0, 0, settings_.width, settings_.height);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.BindVertexArray(no_attributes_);
  gl_.UseProgram(programs_[ShaderVariant::depth_copy]);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  read_pixels(depth.data());
  has_picture_ = false;
  for (float& value : depth.first(pixels)) {
    std::uint8_t bytes[4];
    std::memcpy(bytes, &value, 4);
    const unsigned bits =
        static_cast<unsigned>(bytes[0]) << 16 | static_cast<unsigned>(bytes[1]) << 8 | bytes[2];
    value = static_cast<float>(bits) / 16777215.0f;
  }
  return {};
}

GLenum Renderer::take_error() {
  const GLenum first = gl_.GetError();
  // Errors are flags, one a kind: a handful at most. A lost context gives errors without end.
  for (int i = 0; first != GL_NO_ERROR && i < 16 && gl_.GetError() != GL_NO_ERROR;) ++i;
  return first;
}

void Renderer::push_group(const char* name) {
  if (caps_.debug) gl_.PushDebugGroupKHR(GL_DEBUG_SOURCE_APPLICATION_KHR, 0, -1, name);
}

void Renderer::pop_group() {
  if (caps_.debug) gl_.PopDebugGroupKHR();
}

void GL_APIENTRY Renderer::on_debug_message(GLenum /*source*/, GLenum /*type*/, GLuint /*id*/,
                                            GLenum /*severity*/, GLsizei /*length*/, const GLchar* text,
                                            const void* user) {
  // The user pointer is the renderer that registered it, which is not const.
  auto* self = const_cast<Renderer*>(static_cast<const Renderer*>(user));
  if (self->message_[0] == '\0') std::snprintf(self->message_, sizeof self->message_, "%s", text);
}

}  // namespace karst::core
