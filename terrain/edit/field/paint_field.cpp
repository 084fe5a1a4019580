// SPDX-License-Identifier: MIT
// All arithmetic is in double, each operation a plain IEEE one, so that an edit gives the same bits anywhere.
#include "terrain/edit/field/paint_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "karst/edit.h"
#include "terrain/base/check.h"
#include "terrain/edit/brush.h"

namespace karst::core {
namespace {

// An edit in cells.
Status check(const Edit& edit, std::uint32_t materials) {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (edit.tool != EditTool::paint) return refuse("a field's materials are painted", "tool");
  if (const Status status = check_field_brush(edit); !status.ok()) return status;
  if (edit.material != kNoMaterial && edit.material >= materials)
    return refuse("not the number of a material", "material");
  return {};
}

class Painter {
 public:
  Painter(const PaintField& job, const Edit& edit)
      : job_(job), edit_(edit), material_(edit.material == kNoMaterial ? 0u : edit.material + 1u) {
    const BrushBox box = brush_box(edit);
    const glm::dvec3 samples(job.field->info().blocks * FieldReach::kBlock);
    reach_ = {glm::ivec3(glm::clamp(glm::ceil(box.low), glm::dvec3(0), samples)),
              glm::ivec3(glm::clamp(glm::floor(box.high), glm::dvec3(-1), samples - 1.0))};
  }

  Status run(FieldChange& changed) {
    FieldMaterials& materials = job_.field->materials();
    std::uint32_t opened = 0;
    each_block([&](glm::ivec3 block) {
      const bool alike = !materials.exists() || materials.block(block).empty();
      opened += alike && changes(block) ? 1u : 0u;
    });
    const std::uint32_t free = materials.exists() ? materials.free_blocks() : 0;
    if (opened > free) {
      return {StatusCode::limit_reached, "the field takes more materials", "field_material_blocks",
              opened - free};
    }
    if (!materials.exists()) return {};
    each_block([&](glm::ivec3 block) {
      if (!changes(block)) return;
      const std::span<std::uint8_t> codes = materials.open(block);
      KARST_ASSERT(!codes.empty());
      if (job_.log != nullptr) {
        keep_block(*job_.log, CellKind::field_materials, index(block), std::as_bytes(codes), job_.kept_in,
                   !changed.changed);
      }
      changed.join(reach_.first_in(block), reach_.last_in(block));
      reach_.each_sample(block, [&](glm::ivec3 at, std::size_t n) {
        codes[n] = painted(at, codes[n]);
        return true;
      });
      materials.close(block);
    });
    return {};
  }

 private:
  std::size_t index(glm::ivec3 block) const {
    const glm::ivec3 n = job_.field->info().blocks;
    return static_cast<std::size_t>(block.x + n.x * (block.y + n.y * block.z));
  }
  bool is_air(glm::ivec3 block) const {
    return job_.field->with([&](const auto& f) { return f.block(block).empty() && f.filling(block) > 0; });
  }
  template <class Visit>
  void each_block(const Visit& visit) const {
    reach_.each_block([&](glm::ivec3 block) {
      if (!is_air(block)) visit(block);
    });
  }
  std::uint8_t painted(glm::ivec3 at, std::uint8_t code) const {
    return mix_in(code, material_, edit_.amount * brush_weight(edit_, glm::dvec3(at)));
  }
  bool changes(glm::ivec3 block) const {
    const FieldMaterials& materials = job_.field->materials();
    const std::span<const std::uint8_t> codes =
        materials.exists() ? materials.block(block) : std::span<const std::uint8_t>();
    const std::uint8_t all = materials.exists() && codes.empty() ? materials.filling(block) : std::uint8_t{0};
    bool found = false;
    reach_.each_sample(block, [&](glm::ivec3 at, std::size_t n) {
      const std::uint8_t before = codes.empty() ? all : codes[n];
      found = painted(at, before) != before;
      return !found;
    });
    return found;
  }

  const PaintField& job_;
  const Edit& edit_;
  unsigned material_;
  FieldReach reach_;
};

}  // namespace

std::uint8_t mix_in(std::uint8_t code, unsigned material, double share) {
  const MaterialMix mix = mix_of(code);
  std::array<double, kMostFieldMaterials + 1> weights{};
  weights[mix.first] += (1 - share) * (kMixShares - mix.sevenths);
  weights[mix.second] += (1 - share) * mix.sevenths;
  weights[material] += share * kMixShares;
  // The lesser number where two weigh alike.
  unsigned most = 0;
  for (unsigned m = 1; m < weights.size(); ++m) most = weights[m] > weights[most] ? m : most;
  unsigned next = most == 0 ? 1 : 0;
  for (unsigned m = 0; m < weights.size(); ++m) {
    if (m != most && weights[m] > weights[next]) next = m;
  }
  const unsigned first = std::min(most, next), second = std::max(most, next);
  const double of_second = weights[second] / (weights[first] + weights[second]);
  const auto sevenths = static_cast<std::uint8_t>(std::floor(of_second * kMixShares + 0.5));
  if (sevenths == 0 || sevenths == kMixShares)
    return static_cast<std::uint8_t>(sevenths == 0 ? first : second);
  return code_of({static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second), sevenths});
}

Status PaintField::run(const Edit& edit, FieldChange& changed) const {
  changed = {};
  const Edit own = in_cells(edit, field->info());
  if (const Status status = check(own, materials); !status.ok()) return status;
  return Painter(*this, own).run(changed);
}

void exchange_paint(FieldBlocks& field, UndoPart part, FieldChange& changed) {
  changed = {};
  const auto are_alike = [](std::span<const std::uint8_t> codes) {
    return std::ranges::all_of(codes, [&](std::uint8_t c) { return c == codes[0]; });
  };
  exchange_blocks(field.materials(), part, are_alike, changed);
}

std::uint8_t material_at(const FieldBlocks& field, const glm::dvec3& place) {
  if (!field.materials().exists()) return 0;
  const glm::ivec3 low(glm::floor(place));
  const glm::ivec3 nearest(glm::floor(place + 0.5));
  glm::ivec3 best = nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 8; ++n) {
    const glm::ivec3 at = low + glm::ivec3(n & 1, n >> 1 & 1, n >> 2);
    const glm::dvec3 way = glm::dvec3(at) - place;
    const double square = glm::dot(way, way);
    const bool solid = field.with([&](const auto& f) { return f.at(at); }) < 0;
    if (!solid || square >= least) continue;
    least = square;
    best = at;
  }
  return field.materials().at(best);
}

}  // namespace karst::core
