// SPDX-License-Identifier: MIT
// What the samples of a field are made of (L 5.3): a byte beside the distance, in blocks of 16^3. It says two
// of the world's materials and the share of the second in sevenths, or one alone: of the nine that there are,
// with "by rules", each pair with six shares takes fewer codes than a byte has. Blocks that are all alike
// take a table's entry and no codes.
//
// Codes up to 8 are one material alone: its number plus 1, or 0: the materials' rules decide (materials.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"
namespace karst::core {

// Of a world (terrain/shading/materials.h).
inline constexpr unsigned kMostFieldMaterials = 8;

// Materials as codes have them: their numbers plus 1, or 0.
struct MaterialMix {
  std::uint8_t first = 0;
  std::uint8_t second = 0;    // first, where it is alone, else more than first
  std::uint8_t sevenths = 0;  // of the second, 1..6; 0 where first is alone

  friend bool operator==(const MaterialMix&, const MaterialMix&) = default;
};
inline constexpr int kMixShares = 7;

namespace material_code {

inline constexpr unsigned kAlone = kMostFieldMaterials + 1;
inline constexpr unsigned kCount = kAlone + kAlone * (kAlone - 1) / 2 * (kMixShares - 1);
static_assert(kCount <= 255, "255 marks blocks that take codes, in files");

constexpr std::array<MaterialMix, kCount> make_mixes() {
  std::array<MaterialMix, kCount> mixes{};
  unsigned n = 0;
  for (unsigned m = 0; m < kAlone; ++m)
    mixes[n++] = {static_cast<std::uint8_t>(m), static_cast<std::uint8_t>(m), 0};
  for (unsigned second = 1; second < kAlone; ++second) {
    for (unsigned first = 0; first < second; ++first) {
      for (unsigned share = 1; share < kMixShares; ++share) {
        mixes[n++] = {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second),
                      static_cast<std::uint8_t>(share)};
      }
    }
  }
  return mixes;
}
inline constexpr std::array<MaterialMix, kCount> kMixes = make_mixes();

}  // namespace material_code

// Precondition: code < material_code::kCount.
constexpr MaterialMix mix_of(std::uint8_t code) {
  return material_code::kMixes[code];
}
// Precondition: as MaterialMix says.
constexpr std::uint8_t code_of(MaterialMix mix) {
  if (mix.sevenths == 0) return mix.first;
  const unsigned pair = mix.second * (mix.second - 1u) / 2 + mix.first;
  return static_cast<std::uint8_t>(material_code::kAlone + pair * (kMixShares - 1) + mix.sevenths - 1);
}

// A vertex's: what GpuVertex::morph_normal holds of meshes. Bits 0..3 first, 4..7 second, 8..10 sevenths.
constexpr std::uint16_t vertex_material(std::uint8_t code) {
  const MaterialMix mix = mix_of(code);
  return static_cast<std::uint16_t>(mix.first | mix.second << 4 | mix.sevenths << 8);
}

// Coordinates as ScalarField has them.
class FieldMaterials {
 public:
  using Sample = std::uint8_t;
  static constexpr int kBlockLog2 = 4;
  static constexpr int kBlock = 1 << kBlockLog2;
  static constexpr std::size_t kBlockSamples = std::size_t{kBlock} * kBlock * kBlock;

  // All is 0. table: as many as there are blocks, or more; pool: a multiple of kBlockSamples. Borrowed.
  // invalid_argument ("table").
  Status create(glm::ivec3 blocks, std::span<std::uint32_t> table, std::span<std::uint8_t> pool) {
    const auto count = static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y) *
                       static_cast<std::size_t>(blocks.z);
    if (table.size() < count) return {StatusCode::invalid_argument, "too short", "table", count};
    blocks_ = blocks;
    table_ = table.first(count);
    pool_ = pool;
    for (std::uint32_t& entry : table_) entry = kAlike;
    const auto slots = static_cast<std::uint32_t>(pool.size() / kBlockSamples);
    free_ = kNone;
    free_count_ = 0;
    for (std::uint32_t slot = slots; slot-- > 0;) give_back(slot);
    return {};
  }
  void clear() { *this = {}; }

  bool exists() const { return blocks_.x > 0; }
  glm::ivec3 blocks() const { return blocks_; }
  std::uint32_t free_blocks() const { return free_count_; }

  std::uint8_t at(glm::ivec3 sample) const {
    const glm::ivec3 s = glm::clamp(sample, glm::ivec3(0), blocks_ * kBlock - 1);
    const std::uint32_t entry = table_[index(s >> kBlockLog2)];
    if (entry >= kAlike) return static_cast<std::uint8_t>(entry);
    return pool_[std::size_t{entry} * kBlockSamples + offset(s & (kBlock - 1))];
  }

  // The codes of a block, in x, then y, then z; empty where all are alike.
  std::span<const std::uint8_t> block(glm::ivec3 block) const {
    const std::uint32_t entry = table_[index(block)];
    return entry >= kAlike ? std::span<const std::uint8_t>() : slot_codes(entry);
  }
  // What all codes of a block are, where it takes none.
  std::uint8_t filling(glm::ivec3 block) const { return static_cast<std::uint8_t>(table_[index(block)]); }

  // Codes of a block, to be written; they are what the block was. Empty: the pool is full.
  std::span<std::uint8_t> open(glm::ivec3 block) {
    std::uint32_t& entry = table_[index(block)];
    if (entry < kAlike) return slot_codes(entry);
    if (free_ == kNone) return {};
    const auto all = static_cast<std::uint8_t>(entry);
    entry = free_;
    const std::span<std::uint8_t> out = slot_codes(entry);
    std::memcpy(&free_, out.data(), sizeof free_);
    --free_count_;
    for (std::uint8_t& code : out) code = all;
    return out;
  }
  // Gives a block's codes back where all are alike.
  void close(glm::ivec3 block) {
    const std::span<const std::uint8_t> codes = this->block(block);
    if (codes.empty()) return;
    for (const std::uint8_t code : codes) {
      if (code != codes[0]) return;
    }
    fill(block, codes[0]);
  }
  // Makes all codes of a block alike; what it took is given back.
  void fill(glm::ivec3 block, std::uint8_t all) {
    std::uint32_t& entry = table_[index(block)];
    if (entry < kAlike) give_back(entry);
    entry = kAlike | all;
  }

  static constexpr std::size_t offset(glm::ivec3 inside) {
    return static_cast<std::size_t>(inside.x + kBlock * (inside.y + kBlock * inside.z));
  }

 private:
  static constexpr std::uint32_t kAlike = 0xffffff00u;  // and the code
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::size_t index(glm::ivec3 block) const {
    return static_cast<std::size_t>(block.x) +
           static_cast<std::size_t>(blocks_.x) *
               (static_cast<std::size_t>(block.y) +
                static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(block.z));
  }
  std::span<std::uint8_t> slot_codes(std::uint32_t slot) const {
    return pool_.subspan(std::size_t{slot} * kBlockSamples, kBlockSamples);
  }
  // Free slots are a list through their own first bytes.
  void give_back(std::uint32_t slot) {
    std::memcpy(slot_codes(slot).data(), &free_, sizeof free_);
    free_ = slot;
    ++free_count_;
  }

  glm::ivec3 blocks_{0};
  std::span<std::uint32_t> table_;
  std::span<std::uint8_t> pool_;
  std::uint32_t free_ = kNone;
  std::uint32_t free_count_ = 0;
};

}  // namespace karst::core
