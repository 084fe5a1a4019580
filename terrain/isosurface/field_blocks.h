// SPDX-License-Identifier: MIT
// The samples of a field in memory of stated size, and where they lie in the world. Whoever loads, bakes or
// edits a field writes blocks of samples here; meshes of all levels are made of them (extract_block.h): a
// sample of a coarser level is every 2nd one of the finer, the same bits (L 4.2.1). Blocks that are all solid
// or all air take a table's entry and no samples (terrain/field/scalar_field.h). Where the plan has room for
// them, materials lie beside the samples (field_materials.h).
//
//   FieldBlocks field;                       // one in a world (terrain/world)
//   field.reset(info);                       // all of it is air
//   field.bytes().open({x, y, z}) ...        // 8 bits a sample; words() where info.sample_bits is 16
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/base/storage_plan.h"
#include "terrain/field/scalar_field.h"
#include "terrain/isosurface/field_materials.h"

namespace karst::core {

// Width of a cell between two samples of the finest level: 2^n lattice steps, n within these. 13 is a voxel.
inline constexpr int kLeastCellLog2 = 10;
inline constexpr int kMostCellLog2 = 13;
// A field is at most as wide as an octree of voxels.
inline constexpr std::int32_t kMostFieldVoxels = 1 << kMaxDepth;

inline constexpr float kLeastReach = 0.5f;
inline constexpr float kMostReach = 1024;

struct FieldInfo {
  // Of sample (0, 0, 0), voxels from the world's minimum corner; sample s lies s cells from there, axes as
  // the world's (y up).
  glm::ivec3 corner{0};
  int cell_log2 = 13;        // kLeastCellLog2..kMostCellLog2
  glm::ivec3 blocks{0};      // of 16^3 samples, each way
  int sample_bits = 8;       // or 16
  std::uint32_t stored = 0;  // blocks that take samples
  // What the largest sample stands for: so many cells from the surface, kLeastReach..kMostReach.
  float reach_cells = 2;
  bool has_materials = false;         // other than by rules
  std::uint32_t material_blocks = 0;  // blocks that take codes of materials; 0 without has_materials
  // Of a region of a ground, as its file says: then `corner` counts from the region's, sample (0, 0, 0) lies
  // half a voxel further each way, and the last blocks along x and z are not drawn: the region's sides are
  // the first samples and the first of those blocks.
  bool in_region = false;

  bool exists() const { return blocks.x > 0; }
  std::size_t table_blocks() const {
    return static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y) *
           static_cast<std::size_t>(blocks.z);
  }
  glm::ivec3 drawn_blocks() const { return in_region ? blocks - glm::ivec3(1, 0, 1) : blocks; }
  // Lattice steps: where sample (0, 0, 0) lies, and the size of all blocks that are drawn.
  glm::ivec3 low_steps() const { return corner * kStepsPerVoxel + (in_region ? kStepsPerVoxel / 2 : 0); }
  glm::ivec3 drawn_steps() const { return drawn_blocks() * (16 << cell_log2); }
  friend bool operator==(const FieldInfo&, const FieldInfo&) = default;
};

// invalid_argument naming the first field outside its range ("corner": not 0..kMostFieldVoxels; "cell_log2",
// "sample_bits"; "blocks": none, or wider than kMostFieldVoxels; "stored": more than there are;
// "reach_cells"; "material_blocks": more than there are, or without has_materials).
inline Status validate(const FieldInfo& info) {
  const auto invalid = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (info.cell_log2 < kLeastCellLog2 || info.cell_log2 > kMostCellLog2)
    return invalid("not within 10..13", "cell_log2");
  if (info.sample_bits != 8 && info.sample_bits != 16) return invalid("neither 8 nor 16", "sample_bits");
  const int most = kMostFieldVoxels << (13 - info.cell_log2) >> ScalarField<std::int8_t>::kBlockLog2;
  for (int axis = 0; axis < 3; ++axis) {
    if (info.blocks[axis] < 1 || info.blocks[axis] > most) return invalid("none, or too wide", "blocks");
    if (info.corner[axis] < 0 || info.corner[axis] > kMostFieldVoxels)
      return invalid("not within the world", "corner");
  }
  if (info.stored > info.table_blocks()) return invalid("more than there are", "stored");
  // Written so that NaN fails.
  if (!(info.reach_cells >= kLeastReach && info.reach_cells <= kMostReach))
    return invalid("not within 0.5..1024", "reach_cells");
  if (info.material_blocks > (info.has_materials ? info.table_blocks() : 0))
    return invalid("more than there are", "material_blocks");
  return {};
}

class FieldBlocks {
 public:
  struct Storage {
    std::span<std::uint32_t> table;  // by block
    std::span<std::byte> samples;
    std::span<std::uint32_t> material_table = {};  // by block, or empty: there is no room for materials
    std::span<std::uint8_t> materials = {};

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::fields, config.field_blocks, table);
      visit(Consumer::fields, std::size_t{config.field_sample_blocks} * kBlockBytes, samples);
      const bool any = config.field_material_blocks > 0;
      visit(Consumer::fields, any ? config.field_blocks : 0, material_table);
      visit(Consumer::fields, std::size_t{config.field_material_blocks} * kBlockBytes, materials);
    }
  };
  // Config::field_sample_blocks are so large; blocks of 16 bits take two.
  static constexpr std::size_t kBlockBytes = ScalarField<std::int8_t>::kBlockSamples;

  void create(const Storage& storage) { storage_ = storage; }

  // Begins anew: all is air, and by rules. Errors of validate(); limit_reached ("field_blocks",
  // "field_sample_blocks", "field_material_blocks", with what is needed): then there is no field.
  Status reset(const FieldInfo& info) {
    clear();
    if (const Status status = validate(info); !status.ok()) return status;
    if (info.table_blocks() > storage_.table.size())
      return {StatusCode::limit_reached, "the field has more blocks", "field_blocks", info.table_blocks()};
    const std::size_t needed = std::size_t{info.stored} * (info.sample_bits == 16 ? 2 : 1);
    if (needed * kBlockBytes > storage_.samples.size())
      return {StatusCode::limit_reached, "the field has more samples", "field_sample_blocks", needed};
    const std::size_t codes = storage_.materials.size() / kBlockBytes;
    if (info.has_materials && (storage_.material_table.empty() || info.material_blocks > codes))
      return {StatusCode::limit_reached, "the field has more materials", "field_material_blocks",
              std::max(info.material_blocks, 1u)};
    Status status;
    if (info.sample_bits == 16) {
      const std::size_t count = storage_.samples.size() / (2 * kBlockBytes) * kBlockBytes;
      auto* const words = std::launder(reinterpret_cast<std::int16_t*>(storage_.samples.data()));
      status = words_.create(info.blocks, storage_.table, {words, count});
    } else {
      auto* const bytes = std::launder(reinterpret_cast<std::int8_t*>(storage_.samples.data()));
      status = bytes_.create(info.blocks, storage_.table, {bytes, storage_.samples.size()});
    }
    if (status.ok() && !storage_.material_table.empty())
      status = materials_.create(info.blocks, storage_.material_table, storage_.materials);
    if (status.ok()) info_ = info;
    return status;
  }
  void clear() {
    info_ = {};
    materials_.clear();
  }

  bool exists() const { return info_.exists(); }
  const FieldInfo& info() const { return info_; }
  // Precondition: exists(), and info().sample_bits says so.
  ScalarField<std::int8_t>& bytes() {
    KARST_ASSERT(exists() && info_.sample_bits == 8);
    return bytes_;
  }
  ScalarField<std::int16_t>& words() {
    KARST_ASSERT(exists() && info_.sample_bits == 16);
    return words_;
  }
  // They exist where there is room for them.
  FieldMaterials& materials() { return materials_; }
  const FieldMaterials& materials() const { return materials_; }
  // Calls use(field) with the one that there is, constant.
  template <class Use>
  auto with(Use&& use) const {
    return info_.sample_bits == 16 ? use(words_) : use(bytes_);
  }

 private:
  Storage storage_;
  FieldInfo info_;
  ScalarField<std::int8_t> bytes_;
  ScalarField<std::int16_t> words_;
  FieldMaterials materials_;
};

}  // namespace karst::core
