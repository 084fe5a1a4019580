// SPDX-License-Identifier: MIT
#include "terrain/blocks/block_pool.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "terrain/base/check.h"
#include "terrain/base/lattice.h"

namespace karst::core {
namespace {

std::uint64_t hash_of(const ChosenBlock& block) {
  const BlockKey& k = block.block;
  std::uint64_t h =
      std::uint64_t{k.x} | std::uint64_t{k.y} << 16 | std::uint64_t{k.z} << 32 | std::uint64_t{k.level} << 48;
  // The finaliser of splitmix64 (S. Vigna), twice.
  for (const std::uint64_t more : {block.around, std::uint64_t{0}}) {
    h ^= h >> 30;
    h *= 0xbf58476d1ce4e5b9ull;
    h ^= h >> 27;
    h *= 0x94d049bb133111ebull;
    h ^= (h >> 31) + more;
  }
  return h;
}

}  // namespace

std::size_t BlockPool::Storage::head_count(std::uint32_t meshes) {
  return std::bit_ceil(std::size_t{meshes} + 1);
}

std::size_t BlockPool::Storage::room_bytes() {
  return std::max(ExtractBlock<std::int8_t>::room_bytes(), ExtractBlock<std::int16_t>::room_bytes());
}

void BlockPool::create(const Storage& storage) {
  storage_ = storage;
  frame_ = 0;
  reset();
}

void BlockPool::reset() {
  free_mesh_ = kNone;
  for (auto n = static_cast<std::uint32_t>(storage_.meshes.size()); n-- > 0;) {
    storage_.meshes[n] = {};
    storage_.meshes[n].next = free_mesh_;
    free_mesh_ = n;
  }
  std::fill(storage_.heads.begin(), storage_.heads.end(), kNone);
  reset_pages(pages_, storage_.next_page);
  reset_pages(index_pages_, storage_.next_index_page);
}

void BlockPool::reset_pages(Pages& pages, std::span<std::uint32_t> next) {
  pages = {};
  pages.kept.fill(kNoPage);
  pages.free = static_cast<std::uint32_t>(next.size());
  for (std::uint32_t n = 0; n < pages.free; ++n) next[n] = n + 1 < pages.free ? n + 1 : kNoPage;
  pages.first = next.empty() ? kNoPage : 0;
}

std::uint32_t& BlockPool::head_of(const ChosenBlock& block) {
  return storage_.heads[hash_of(block) & (storage_.heads.size() - 1)];
}

std::uint32_t BlockPool::find(const ChosenBlock& block) {
  for (std::uint32_t n = head_of(block); n != kNone; n = storage_.meshes[n].next) {
    if (storage_.meshes[n].block != block) continue;
    ask(n);
    return n;
  }
  return kNone;
}

// Precondition: so many are free.
std::uint32_t BlockPool::take(Pages& pages, std::span<std::uint32_t> next, std::uint32_t count) {
  if (count == 0) return kNoPage;
  const std::uint32_t first = pages.first;
  std::uint32_t last = first;
  for (std::uint32_t n = 1; n < count; ++n) last = next[last];
  pages.first = next[last];
  next[last] = kNoPage;
  pages.free -= count;
  return first;
}

void BlockPool::keep_back(std::uint32_t first) {
  if (first == kNoPage) return;
  std::uint32_t last = first;
  while (storage_.next_page[last] != kNoPage) last = storage_.next_page[last];
  std::uint32_t& kept = pages_.kept[frame_ % kFramesInFlight];
  storage_.next_page[last] = kept;
  kept = first;
}

void BlockPool::set_free(Pages& pages, std::span<std::uint32_t> next, std::uint32_t first) {
  if (first == kNoPage) return;
  std::uint32_t last = first;
  for (++pages.free; next[last] != kNoPage; ++pages.free) last = next[last];
  next[last] = pages.first;
  pages.first = first;
}

void BlockPool::release(std::uint32_t slot) {
  set_free(pages_, storage_.next_page, std::exchange(pages_.kept[slot], kNoPage));
}

bool BlockPool::has_kept() const {
  return std::any_of(pages_.kept.begin(), pages_.kept.end(), [](std::uint32_t p) { return p != kNoPage; });
}

void BlockPool::unlink(std::uint32_t n) {
  std::uint32_t* at = &head_of(storage_.meshes[n].block);
  while (*at != n) at = &storage_.meshes[*at].next;
  *at = storage_.meshes[n].next;
}

void BlockPool::give_up(std::uint32_t n) {
  Mesh& mesh = storage_.meshes[n];
  if (!mesh.old) unlink(n);
  if (mesh.drawn != 0 && frame_ - mesh.drawn < kFramesInFlight) {
    keep_back(mesh.first_page);
  } else {
    set_free(pages_, storage_.next_page, mesh.first_page);
  }
  // Only the CPU reads them.
  set_free(index_pages_, storage_.next_index_page, mesh.first_index_page);
  mesh = {};
  mesh.next = free_mesh_;
  free_mesh_ = n;
}

// Of those that this frame does not ask for.
bool BlockPool::give_up_oldest() {
  std::uint32_t oldest = kNone;
  for (std::uint32_t n = 0; n < storage_.meshes.size(); ++n) {
    const Mesh& mesh = storage_.meshes[n];
    if (!mesh.used || mesh.asked == frame_) continue;
    if (oldest == kNone || frame_ - mesh.asked > frame_ - storage_.meshes[oldest].asked) oldest = n;
  }
  if (oldest == kNone) return false;
  give_up(oldest);
  return true;
}

Status BlockPool::extract(const FieldBlocks& field, const ChosenBlock& block, std::uint32_t& vertices,
                          std::uint32_t& indices) {
  return field.with([&]<class Sample>(const ScalarField<Sample>& samples) {
    ExtractBlock<Sample> job;
    job.field = &samples;
    if (field.materials().exists()) job.materials = &field.materials();
    job.level = block.block.level;
    job.corner = block.block.place() * (kIsoCells << job.level);
    job.around = unpack_around(block.around);
    job.sides = sides_of(field.info(), block.block);
    job.vertices = storage_.made;
    job.triangles = storage_.triangles;
    typename ExtractBlock<Sample>::Result result;
    const Status status = job.run(storage_.room, result);
    vertices = result.vertices;
    indices = 3 * result.triangles;
    return status;
  });
}

std::uint16_t BlockPool::rim_value(std::uint32_t n, std::uint32_t at) const {
  const Mesh& mesh = storage_.meshes[n];
  KARST_ASSERT(at < mesh.rim);
  at += mesh.indices;
  std::uint32_t page = mesh.first_index_page;
  for (; at >= kIndexPage; at -= kIndexPage) page = storage_.next_index_page[page];
  return storage_.indices[std::size_t{page} * kIndexPage + at];
}

std::uint32_t BlockPool::vertex_place(std::uint32_t n, std::uint32_t vertex) const {
  std::uint32_t page = storage_.meshes[n].first_page;
  for (; vertex >= kPageVertices; vertex -= kPageVertices) page = storage_.next_page[page];
  return page * kPageVertices + vertex;
}

Status BlockPool::make(const FieldBlocks& field, const ChosenBlock& block, std::uint32_t& out,
                       MeshUpload& upload) {
  std::uint32_t vertices = 0, indices = 0;
  if (const Status status = extract(field, block, vertices, indices); !status.ok()) return status;
  FindRuns runs;
  runs.vertices = std::span<const IsoVertex>(storage_.made).first(vertices);
  runs.triangles = std::span<const std::uint16_t>(storage_.triangles).first(indices);
  runs.sides = sides_of(field.info(), block.block);
  runs.out = storage_.triangles.subspan(indices);
  const auto rim = runs.sides == 0 ? 0u : static_cast<std::uint32_t>(runs.run());
  const std::uint32_t pages = pages_for(vertices), index_pages = index_pages_for(indices + rim);
  const auto full = [&]() -> const char* {
    if (free_mesh_ == kNone) return "field_meshes";
    if (pages_.free < pages) return "field_vertex_pages";
    return index_pages_.free < index_pages ? "field_index_pages" : nullptr;
  };
  for (const char* what = full(); what != nullptr; what = full()) {
    if (!give_up_oldest()) return {StatusCode::limit_reached, "the isosurface has no room", what};
  }
  out = free_mesh_;
  Mesh& mesh = storage_.meshes[out];
  free_mesh_ = mesh.next;
  mesh = {};
  mesh.block = block;
  mesh.used = true;
  mesh.asked = frame_;
  mesh.vertices = vertices;
  mesh.indices = indices;
  mesh.rim = rim;
  mesh.first_page = take(pages_, storage_.next_page, pages);
  mesh.first_index_page = take(index_pages_, storage_.next_index_page, index_pages);
  std::uint32_t& head = head_of(block);
  mesh.next = head;
  head = out;

  std::uint32_t page = mesh.first_index_page;
  const std::uint32_t values = indices + rim;
  for (std::uint32_t done = 0; done < values; done += kIndexPage, page = storage_.next_index_page[page]) {
    std::copy_n(storage_.triangles.begin() + done, std::min(kIndexPage, values - done),
                storage_.indices.begin() + static_cast<std::ptrdiff_t>(std::size_t{page} * kIndexPage));
  }
  // A step of the page is 1 / kIsoStepsPerCell of the block's cell.
  const FieldInfo& info = field.info();
  upload.size = block.block.level + info.cell_log2 - std::countr_zero(unsigned{kIsoStepsPerCell});
  // A region may lie further away than 32 bits of steps.
  const glm::i64vec3 low =
      glm::i64vec3(region_) * std::int64_t{kStepsPerVoxel} +
      glm::i64vec3(info.low_steps() +
                   block.block.place() * (kIsoCells << (block.block.level + info.cell_log2)));
  glm::ivec3 rest;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t origin = low[axis] >> (upload.size + kLatticeBits);
    upload.origin[axis] = static_cast<std::int32_t>(origin);
    rest[axis] = static_cast<int>((low[axis] - (origin << (upload.size + kLatticeBits))) >> upload.size);
  }
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const IsoVertex& from = storage_.made[v];
    GpuVertex& to = storage_.vertices[v];
    for (int axis = 0; axis < 3; ++axis)
      to.position[axis] = to.morph[axis] = static_cast<std::int16_t>(from.place[axis] + rest[axis]);
    to.normal = from.normal;
    to.morph_normal = vertex_material(static_cast<std::uint8_t>(from.material));
  }
  upload.first_page = mesh.first_page;
  upload.vertices = std::span<const GpuVertex>(storage_.vertices).first(vertices);
  return {};
}

}  // namespace karst::core
