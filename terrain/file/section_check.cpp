// SPDX-License-Identifier: MIT
#include "terrain/file/section_check.h"

#include "terrain/file/material_section.h"
#include "terrain/file/world_layout.h"
#include "terrain/measure/level_error.h"
#include "terrain/surface/bezier/case_tables.h"

#include <bit>
#include <cstring>

namespace karst::core {
namespace {

// Calls bad(entry), which tells whether an entry may not be so, for entries of a type that takes any bits.
template <class T, class Bad>
std::uint64_t find_entry(std::span<const std::byte> bytes, const Bad& bad) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    if (bad(world_layout::load<T>(bytes, at))) return at;
  }
  return bytes.size();
}

bool is_too_high(std::int16_t s) {
  return s > kMaxHeight || s < -kMaxHeight;
}

bool is_inside_out(const PatchBounds& b) {
  return b.min[0] > b.max[0] || b.min[1] > b.max[1] || b.min[2] > b.max[2];
}

}  // namespace

SectionCheck::SectionCheck(WorldSection section, const WorldInfo& info, std::uint32_t materials)
    : section_(section), info_(info), materials_(materials) {}

SectionCheck::Fault SectionCheck::feed(std::span<const std::byte> bytes) {
  Fault fault;
  const auto entry_fault = [&](std::uint64_t at, const char* what) {
    return at == bytes.size() ? Fault() : Fault{what, at};
  };
  switch (section_) {
    case WorldSection::keys:
      fault = feed_keys(bytes);
      break;
    case WorldSection::mask:
      fault = feed_mask(bytes);
      break;
    case WorldSection::samples:
      fault = entry_fault(find_entry<std::int16_t>(bytes, is_too_high),
                          "a height is beyond the largest displacement");
      break;
    case WorldSection::level_errors:
      fault = feed_level_errors(bytes);
      break;
    case WorldSection::bounds:
      fault =
          entry_fault(find_entry<PatchBounds>(bytes, is_inside_out), "a box's minimum is above its maximum");
      break;
    case WorldSection::overrides: {
      const auto unknown = [&](std::uint8_t material) { return material > materials_; };
      fault =
          entry_fault(find_entry<std::uint8_t>(bytes, unknown), "a patch has a material that is not there");
      break;
    }
    default:
      break;
  }
  fault.offset += at_;
  at_ += bytes.size();
  return fault;
}

SectionCheck::Fault SectionCheck::finish() const {
  if (section_ == WorldSection::mask && count_ != info_.height_blocks)
    return {"the mask's bits are not height_blocks of the patches", 0};
  if (section_ == WorldSection::keys && count_ != info_.volumes)
    return {"the keys are not of as many volumes as stated", 0};
  return {};
}

// last_ is 0 before the first: the key of no patch, because no corner lies on a side.
const char* SectionCheck::key_fault(PatchKey key) const {
  if (key.bits() >> PatchKey::kBits != 0 || key.region() != kOnlyRegion)
    return "a patch is of no region of the world";
  if (key.bits() <= last_) return "a patch's key is not above the one before";
  const glm::ivec3 corner = key.corner();
  const bool inside = corner.x >= 1 && corner.x < info_.extent.x && corner.y >= 1 &&
                      corner.y <= info_.extent.y && corner.z >= 1 && corner.z < info_.extent.z;
  if (!inside) return "a patch lies outside the extent";
  if (key.case_patch() >= kMaxCasePatches) return "a patch's key has no such case";
  if (key.case_patch() > 0 && key.bits() != last_ + 1) return "the patches of a volume do not follow another";
  return nullptr;
}

SectionCheck::Fault SectionCheck::feed_keys(std::span<const std::byte> bytes) {
  for (std::size_t at = 0; at + sizeof(PatchKey) <= bytes.size(); at += sizeof(PatchKey)) {
    const PatchKey key = PatchKey::from_bits(world_layout::load<std::uint64_t>(bytes, at));
    if (const char* what = key_fault(key); what != nullptr) return {what, at};
    count_ += key.case_patch() == 0 ? 1u : 0u;
    last_ = key.bits();
  }
  return {};
}

SectionCheck::Fault SectionCheck::feed_mask(std::span<const std::byte> bytes) {
  const std::uint64_t last_byte = info_.patches / 8;  // with unused bits, where there are any
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const auto bits = std::to_integer<unsigned>(bytes[k]);
    if (at_ + k == last_byte && bits >> (info_.patches % 8) != 0)
      return {"unused bits of the mask are not 0", k};
    count_ += static_cast<std::uint64_t>(std::popcount(bits));
  }
  return {};
}

// Errors and reaches fall or stay from each to the next, half a row each. Level 1 has none.
SectionCheck::Fault SectionCheck::feed_level_errors(std::span<const std::byte> bytes) {
  const auto half = static_cast<std::uint64_t>(info_.level - 1);
  for (std::size_t at = 0; at + sizeof(std::uint16_t) <= bytes.size(); at += sizeof(std::uint16_t)) {
    const auto value = world_layout::load<std::uint16_t>(bytes, at);
    if ((at_ + at) / sizeof(std::uint16_t) % half != 0 && value > last_)
      return {"a finer level's error is larger than a coarser one's", at};
    last_ = value;
  }
  return {};
}

}  // namespace karst::core
