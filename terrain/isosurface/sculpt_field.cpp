// SPDX-License-Identifier: MIT
// All arithmetic is in double, each operation a plain IEEE one, so that a dab gives the same bits anywhere.
#include "terrain/isosurface/sculpt_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// Of each kept block: its number, then all of its samples, also where they are alike.
constexpr std::size_t kHead = sizeof(std::uint64_t);
// In the number, while blocks are exchanged: this one was.
constexpr std::uint64_t kDone = std::uint64_t{1} << 63;

Status check(const FieldDab& dab) {
  const auto invalid = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(dab.place[axis]) <= 1e6)) return invalid("beyond all fields", "place");
  }
  // Written so that NaN fails.
  if (!(dab.radius >= FieldDab::kLeast && dab.radius <= FieldDab::kMost))
    return invalid("not within 0.5..64 cells", "radius");
  if (!(dab.strength >= 0 && dab.strength <= 1)) return invalid("not within 0..1", "strength");
  if (!(std::abs(glm::length(dab.up) - 1) <= 1e-6)) return invalid("not of length 1", "up");
  return {};
}

template <class Sample>
class Sculpt {
 public:
  using Field = ScalarField<Sample>;
  using Samples = std::array<Sample, Field::kBlockSamples>;

  Sculpt(const FieldDab& dab, double reach, Field& field)
      : dab_(dab), field_(field), scale_(-double{Field::kSolid} / reach) {
    const double wide = dab.radius + (dab.tool == FieldDab::Tool::slope ? 0 : reach) + 1;
    const glm::dvec3 low = glm::ceil(dab.place - wide), high = glm::floor(dab.place + wide);
    first_ = glm::max(glm::ivec3(low), glm::ivec3(0));
    last_ = glm::min(glm::ivec3(high), field.samples() - 1);
  }

  bool reaches() const { return glm::all(glm::lessThanEqual(first_, last_)); }

  // Blocks that change: what of them takes room.
  void count(std::size_t& kept_bytes, std::uint32_t& opened) {
    each_block([&](glm::ivec3 block) {
      const bool has_samples = !field_.block(block).empty();
      // Most of what a dab reaches is alike, and stays so.
      if (!has_samples && !changes(block)) return;
      kept_bytes += kHead + sizeof(Samples);
      opened += has_samples ? 0 : 1;
    });
  }

  // Precondition: there is room.
  void run(std::span<std::byte> kept, FieldChange& change) {
    std::size_t used = 0;
    each_block([&](glm::ivec3 block) {
      if (field_.block(block).empty() && !changes(block)) return;
      const std::span<Sample> samples = field_.open(block);
      KARST_ASSERT(!samples.empty());
      if (!kept.empty()) {
        const std::uint64_t number = index(block);
        std::memcpy(kept.data() + used, &number, kHead);
        std::memcpy(kept.data() + used + kHead, samples.data(), sizeof(Samples));
      }
      used += kHead + sizeof(Samples);
      each_sample(block, [&](glm::ivec3 at, std::size_t n) {
        samples[n] = sculpted(at, samples[n]);
        return true;
      });
      field_.close(block);
    });
    change.first = first_;
    change.last = last_;
    change.kept_bytes = used;
  }

 private:
  std::uint64_t index(glm::ivec3 block) const {
    const glm::ivec3 n = field_.blocks();
    return static_cast<std::uint64_t>(block.x + n.x * (block.y + n.y * block.z));
  }
  template <class Visit>
  void each_block(const Visit& visit) {
    const glm::ivec3 low = first_ >> Field::kBlockLog2, high = last_ >> Field::kBlockLog2;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) visit(glm::ivec3(x, y, z));
      }
    }
  }
  // Calls visit(sample, its number in the block), which returns whether to go on.
  template <class Visit>
  void each_sample(glm::ivec3 block, const Visit& visit) const {
    const glm::ivec3 corner = block * Field::kBlock;
    const glm::ivec3 low = glm::max(first_, corner), high = glm::min(last_, corner + Field::kBlock - 1);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          const glm::ivec3 at(x, y, z);
          if (!visit(at, Field::offset(at - corner))) return;
        }
      }
    }
  }
  // Precondition: the block takes no samples.
  bool changes(glm::ivec3 block) const {
    const Sample all = field_.filling(block);
    bool found = false;
    each_sample(block, [&](glm::ivec3 at, std::size_t) {
      found = sculpted(at, all) != all;
      return !found;
    });
    return found;
  }
  Sample stored(double cells) const {
    const double value = std::floor(cells * scale_);
    return static_cast<Sample>(std::clamp(value, double{Field::kSolid}, double{Field::kAir}));
  }
  Sample sculpted(glm::ivec3 at, Sample before) const {
    const glm::dvec3 away = glm::dvec3(at) - dab_.place;
    const double distance = glm::length(away);
    switch (dab_.tool) {
      case FieldDab::Tool::add:
        return std::min(before, stored(distance - dab_.radius));
      case FieldDab::Tool::subtract:
        return std::max(before, stored(dab_.radius - distance));
      case FieldDab::Tool::slope:
        break;
    }
    if (distance >= dab_.radius) return before;
    const double t = 1 - distance / dab_.radius;
    const double share = dab_.strength * t * t * (3 - 2 * t);
    const double was = (static_cast<double>(before) + 0.5) / scale_;
    return stored(was + share * (glm::dot(away, dab_.up) - was));
  }

  const FieldDab& dab_;
  Field& field_;
  double scale_;
  glm::ivec3 first_{0}, last_{-1};
};

template <class Sample>
Status sculpt(const FieldDab& dab, double reach, ScalarField<Sample>& field, std::span<std::byte> kept,
              FieldChange& change) {
  Sculpt<Sample> job(dab, reach, field);
  if (!job.reaches()) return {};
  std::size_t bytes = 0;
  std::uint32_t opened = 0;
  job.count(bytes, opened);
  if (opened > field.free_blocks()) {
    return {StatusCode::limit_reached, "the field takes more samples", "field_sample_blocks",
            opened - field.free_blocks()};
  }
  if (!kept.empty() && bytes > kept.size())
    return {StatusCode::limit_reached, "too short for what the dab changes", "kept", bytes};
  if (bytes > 0) job.run(kept, change);
  return {};
}

template <class Sample>
bool are_alike(std::span<const Sample> samples) {
  using Field = ScalarField<Sample>;
  if (samples[0] != Field::kAir && samples[0] != Field::kSolid) return false;
  return std::ranges::all_of(samples, [&](Sample s) { return s == samples[0]; });
}

template <class Sample>
void swap_blocks(ScalarField<Sample>& field, std::span<std::byte> kept, FieldChange& change) {
  using Field = ScalarField<Sample>;
  using Samples = std::array<Sample, Field::kBlockSamples>;
  const glm::ivec3 n = field.blocks();
  change = {field.samples(), glm::ivec3(-1), kept.size()};
  const auto swap_those = [&](bool alike) {
    for (std::size_t at = 0; at < kept.size(); at += kHead + sizeof(Samples)) {
      std::uint64_t number = 0;
      Samples wanted, now;
      std::memcpy(&number, kept.data() + at, kHead);
      std::memcpy(&wanted, kept.data() + at + kHead, sizeof wanted);
      if ((number & kDone) != 0 || are_alike<Sample>(wanted) != alike) continue;
      const auto b = static_cast<int>(number);
      const glm::ivec3 block(b % n.x, b / n.x % n.y, b / n.x / n.y);
      change.first = glm::min(change.first, block * Field::kBlock);
      change.last = glm::max(change.last, block * Field::kBlock + Field::kBlock - 1);
      const std::span<const Sample> samples = field.block(block);
      if (samples.empty()) {
        now.fill(field.filling(block));
      } else {
        std::ranges::copy(samples, now.begin());
      }
      if (alike) {
        field.fill(block, wanted[0]);
      } else {
        const std::span<Sample> out = field.open(block);
        KARST_ASSERT(!out.empty());
        std::ranges::copy(wanted, out.begin());
      }
      number |= kDone;
      std::memcpy(kept.data() + at, &number, kHead);
      std::memcpy(kept.data() + at + kHead, &now, sizeof now);
    }
  };
  // What blocks that will be alike give back is enough for the others.
  swap_those(true);
  swap_those(false);
  for (std::size_t at = 0; at < kept.size(); at += kHead + sizeof(Samples)) {
    std::uint64_t number = 0;
    std::memcpy(&number, kept.data() + at, kHead);
    number &= ~kDone;
    std::memcpy(kept.data() + at, &number, kHead);
  }
}

}  // namespace

Status sculpt_field(const FieldDab& dab, FieldBlocks& field, std::span<std::byte> kept, FieldChange& change) {
  change = {};
  if (const Status status = check(dab); !status.ok()) return status;
  const double reach = double{field.info().reach_cells};
  return field.info().sample_bits == 16 ? sculpt(dab, reach, field.words(), kept, change)
                                        : sculpt(dab, reach, field.bytes(), kept, change);
}

void swap_field(FieldBlocks& field, std::span<std::byte> kept, FieldChange& change) {
  if (field.info().sample_bits == 16) {
    swap_blocks(field.words(), kept, change);
  } else {
    swap_blocks(field.bytes(), kept, change);
  }
}

}  // namespace karst::core
