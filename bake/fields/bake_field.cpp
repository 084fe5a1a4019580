// SPDX-License-Identifier: MIT
#include "bake/fields/bake_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>

#include "app/common/json_writer.h"
#include "bake/base/parallel.h"
#include "bake/base/print_text.h"
#include "bake/fields/field_file.h"
#include "bake/fields/field_materials_file.h"
#include "bake/fields/field_world.h"
#include "platform/base/text.h"
#include "terrain/base/lattice.h"
#include "terrain/file/world_writer.h"

namespace karst::bake {
using namespace core;
namespace {

constexpr double kWarnOutOfReach = 0.01;  // of the surface's edges

// Where a world of so many blocks stands: the finest samples for which an octree's width holds them all.
Error place_field(glm::ivec3 blocks, FieldInfo& field, WorldInfo& info, double spacing_m) {
  for (int log2 = kMostCellLog2; log2 >= kLeastCellLog2; --log2) {
    const int shift = kMostCellLog2 - log2;
    const glm::ivec3 extent = glm::max((blocks * 16 + (1 << shift) - 1) >> shift, glm::ivec3(2));
    const int widest = std::max({extent.x, extent.y + 1, extent.z});
    if (widest > 1 << kMaxDepth) continue;
    info.depth = 1;
    while (1 << info.depth < widest) ++info.depth;
    info.extent = extent;
    info.voxel_size_m = spacing_m * (1 << shift);
    field.cell_log2 = log2;
    return {};
  }
  return "--field: its sides are not within 2 to 4080 samples: cut or resample it";
}

bool is_world_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(16, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return is_world(head);
}

class Baker {
 public:
  Baker(const BakeField& job, BakeField::Report& report) : job_(job), report_(report) {}

  Error run(std::vector<std::byte>& file) {
    if (Error error = load_materials(); !error.ok()) return error;
    if (Error error = read(); !error.ok()) return error;
    if (Error error = measure(); !error.ok()) return error;
    if (Error error = place(); !error.ok()) return error;
    if (job_.sample_bits == 16) {
      fill(field_.words());
    } else {
      fill(field_.bytes());
    }
    if (Error error = make_materials(); !error.ok()) return error;
    return write(file);
  }

 private:
  // Before all work, so that a mistake in their files costs no time.
  Error load_materials() {
    if (!has_materials()) return {};
    if (job_.materials.none && !job_.materials_path.empty())
      return "--field-materials: there are none by --materials none";
    bake_materials_.options = job_.materials;
    bake_materials_.threads = job_.threads;
    if (Error error = bake_materials_.load(); !error.ok()) return error;
    if (!bake_materials_.paints()) return {};
    return job_.materials.path + ": paint and blend_map are for voxels and grounds; say --field-materials";
  }

  bool has_materials() const { return job_.has_materials || !job_.materials_path.empty(); }

  // Rows of samples that the surface crosses, along y.
  std::array<float, 2> surface_rows() const {
    std::array<float, 2> rows{static_cast<float>(grid_.size.y), 0};
    const glm::ivec3 n = grid_.size;
    for (int y = 0; y + 1 < n.y; ++y) {
      for (int z = 0; z < n.z; ++z) {
        for (int x = 0; x < n.x; ++x) {
          if ((signed_value(grid_.at(x, y, z)) < 0) == (signed_value(grid_.at(x, y + 1, z)) < 0)) continue;
          rows[0] = std::min(rows[0], static_cast<float>(y));
          rows[1] = std::max(rows[1], static_cast<float>(y + 1));
        }
      }
    }
    if (rows[0] > rows[1]) rows = {0, static_cast<float>(n.y - 1)};
    return rows;
  }

  Error make_materials() {
    if (!has_materials()) return {};
    const WorldInfo& info = report_.info;
    const float voxels = std::ldexp(1.0f, report_.field.cell_log2 - kMostCellLog2);  // a sample
    const std::array<float, 2> rows = surface_rows();
    bake_materials_.grid.voxel_m = info.voxel_size_m;
    bake_materials_.grid.origin_m = {info.origin_m[0], info.origin_m[1], info.origin_m[2]};
    bake_materials_.grid.extent = info.extent;
    bake_materials_.grid.depth = info.depth;
    bake_materials_.heights = {rows[0] * voxels, rows[1] * voxels};
    if (Error error = bake_materials_.run(materials_); !error.ok()) return error;
    report_.materials = materials_.set.count;
    if (job_.materials_path.empty()) return {};
    FillMaterials fill;
    fill.path = job_.materials_path;
    fill.size = grid_.size;
    fill.materials = &materials_.set;
    fill.threads = job_.threads;
    return fill.run(field_);
  }

  Error read() {
    if (!job_.shape.empty()) {
      if (Error error = fill_shape(job_.shape, job_.size, job_.spacing_m, job_.threads, grid_); !error.ok())
        return error;
    } else if (job_.type.empty() && is_world_file(job_.path)) {
      Error error = read_world_surface(job_.path, job_.spacing_m, job_.threads, grid_);
      if (!error.ok()) return error;
    } else {
      ReadField read;
      read.path = job_.path;
      read.size = job_.type.empty() ? glm::ivec3(0) : job_.size;
      read.type = job_.type;
      if (Error error = read.run(grid_); !error.ok()) return error;
      if (job_.spacing_m > 0) grid_.spacing_m = job_.spacing_m;
      if (grid_.spacing_m <= 0) {
        grid_.spacing_m = 1;
        report_.warnings.push_back(job_.path +
                                   " does not say how far apart samples are: 1 m is taken; say "
                                   "--field-spacing M");
      }
    }
    const auto [least, most] = std::ranges::minmax_element(grid_.values);
    report_.least = double{*least};
    report_.most = double{*most};
    report_.size = grid_.size;
    report_.spacing_m = grid_.spacing_m;
    return {};
  }

  std::string subject() const { return job_.path.empty() ? "--field-shape " + job_.shape : job_.path; }

  // Below 0 where it is solid.
  double signed_value(float value) const {
    const double above = double{value} - job_.iso;
    return job_.solid_above ? -above : above;
  }

  // Calls visit(a, b) for the values at the ends of all edges that the surface crosses.
  template <class Visit>
  void each_crossing(const Visit& visit) const {
    const glm::ivec3 n = grid_.size;
    for (int z = 0; z < n.z; ++z) {
      for (int y = 0; y < n.y; ++y) {
        for (int x = 0; x < n.x; ++x) {
          const double a = signed_value(grid_.at(x, y, z));
          const auto look = [&](double b) {
            if ((a < 0) != (b < 0)) visit(a, b);
          };
          if (x + 1 < n.x) look(signed_value(grid_.at(x + 1, y, z)));
          if (y + 1 < n.y) look(signed_value(grid_.at(x, y + 1, z)));
          if (z + 1 < n.z) look(signed_value(grid_.at(x, y, z + 1)));
        }
      }
    }
  }

  // What change of the value is a cell's width: so much do 9 of 10 edges that are crossed change at most. One
  // factor for all values leaves every crossing where it is.
  Error measure() {
    std::vector<float> changes;
    each_crossing([&](double a, double b) { changes.push_back(static_cast<float>(std::abs(b - a))); });
    report_.crossings = changes.size();
    if (changes.empty()) {
      std::string text;
      print(text, ": nothing crosses --field-iso %.6g: its values lie within %.6g to %.6g", job_.iso,
            report_.least, report_.most);
      return subject() + text;
    }
    const auto tenth = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() * 9 / 10);
    std::ranges::nth_element(changes, tenth);
    report_.value_a_cell = double{*tenth};
    const double reach = job_.reach_cells * report_.value_a_cell;
    each_crossing([&](double a, double b) {
      report_.out_of_reach += std::max(std::abs(a), std::abs(b)) > reach ? 1u : 0u;
    });
    const double share = static_cast<double>(report_.out_of_reach) / static_cast<double>(report_.crossings);
    if (share > kWarnOutOfReach) {
      std::string text;
      print(text,
            ": at %.2g %% of its edges values change too much for --field-reach %.3g: the surface is "
            "moved there; take more",
            100 * share, job_.reach_cells);
      report_.warnings.push_back(subject() + text);
    }
    return {};
  }

  Error place() {
    FieldInfo& info = report_.field;
    info.blocks = (grid_.size + 15) / 16;
    info.sample_bits = job_.sample_bits;
    info.reach_cells = static_cast<float>(job_.reach_cells);
    info.stored = static_cast<std::uint32_t>(info.table_blocks());
    WorldInfo& world = report_.info;
    world.level = 1;
    if (Error error = place_field(info.blocks, info, world, grid_.spacing_m); !error.ok()) return error;
    if (grid_.is_placed) {
      for (int axis = 0; axis < 3; ++axis) world.origin_m[axis] = grid_.low_m[axis];
    } else {
      world.origin_m[0] = -0.5 * (grid_.size.x - 1) * grid_.spacing_m;
      world.origin_m[2] = -0.5 * (grid_.size.z - 1) * grid_.spacing_m;
    }
    const std::string name =
        job_.shape.empty() ? job_.path.substr(job_.path.find_last_of('/') + 1) : job_.shape;
    for (std::size_t k = 0; k < std::min(name.size(), kWorldNameBytes - 1); ++k)
      world.name[k] = name[k] >= ' ' && name[k] <= '~' ? name[k] : '_';
    table_.resize(info.table_blocks());
    samples_.resize(info.table_blocks() * FieldBlocks::kBlockBytes *
                    static_cast<std::size_t>(job_.sample_bits / 8));
    if (!job_.materials_path.empty()) {
      material_table_.resize(info.table_blocks());
      codes_.resize(info.table_blocks() * FieldBlocks::kBlockBytes);
    }
    field_.create({table_, samples_, material_table_, codes_});
    return Error(subject(), field_.reset(info));
  }

  // Beyond the grid's sides samples are as at them.
  template <class Sample>
  void fill(ScalarField<Sample>& field) {
    using Field = ScalarField<Sample>;
    const double scale = -double{Field::kSolid} / (job_.reach_cells * report_.value_a_cell);
    const glm::ivec3 blocks = field.blocks();
    for (int b = 0; b < blocks.x * blocks.y * blocks.z; ++b) {
      const glm::ivec3 block(b % blocks.x, b / blocks.x % blocks.y, b / blocks.x / blocks.y);
      const std::span<Sample> out = field.open(block);
      for (int n = 0; n < static_cast<int>(out.size()); ++n) {
        const glm::ivec3 at = glm::min(block * 16 + glm::ivec3(n & 15, n >> 4 & 15, n >> 8), grid_.size - 1);
        const double value = std::floor(signed_value(grid_.at(at.x, at.y, at.z)) * scale);
        out[static_cast<std::size_t>(n)] =
            static_cast<Sample>(std::clamp(value, double{Field::kSolid}, double{Field::kAir}));
      }
      field.close(block);
    }
  }

  Error write(std::vector<std::byte>& file) {
    std::array<Octree::Octet, 1> octets{};
    Octree none;
    if (Error error = Error("world", none.create(octets, report_.info.depth)); !error.ok()) return error;
    WorldWriter writer;
    writer.info = report_.info;
    writer.octree = &none;
    writer.field = &field_;
    writer.materials = materials_.view();
    file.clear();
    file.reserve(static_cast<std::size_t>(writer.file_bytes()));
    const auto append = [&](std::span<const std::byte> bytes) {
      file.insert(file.end(), bytes.begin(), bytes.end());
      return true;
    };
    const Status status = writer.run(ByteSink::to(append));
    report_.field.stored = static_cast<std::uint32_t>(
        table_.size() - field_.with([](const auto& f) { return std::size_t{f.free_blocks()}; }));
    if (const FieldMaterials& codes = field_.materials(); codes.exists()) {
      report_.field.has_materials = true;
      report_.field.material_blocks =
          static_cast<std::uint32_t>(material_table_.size() - std::size_t{codes.free_blocks()});
    }
    return Error("world", status);
  }

  const BakeField& job_;
  BakeField::Report& report_;
  FieldGrid grid_;
  std::vector<std::uint32_t> table_;
  std::vector<std::byte> samples_;
  std::vector<std::uint32_t> material_table_;
  std::vector<std::uint8_t> codes_;
  FieldBlocks field_;
  BakeMaterials bake_materials_;
  BakedMaterials materials_;
};

}  // namespace

Error BakeField::run(Report& report, std::vector<std::byte>& file) const {
  report = Report();
  return Baker(*this, report).run(file);
}

std::string field_report_text(const BakeField& job, const BakeField::Report& report, std::size_t bytes,
                              double seconds) {
  std::string out;
  print(out, "input         %s, %d x %d x %d samples, %.6g m apart, values %.6g to %.6g\n",
        job.path.empty() ? job.shape.c_str() : job.path.c_str(), report.size.x, report.size.y, report.size.z,
        report.spacing_m, report.least, report.most);
  print(out, "surface       at %.6g, solid is what is %s; %llu edges cross it, %llu beyond reach\n", job.iso,
        job.solid_above ? "above" : "below", static_cast<unsigned long long>(report.crossings),
        static_cast<unsigned long long>(report.out_of_reach));
  print(out, "samples       %d bits that reach %.3g cells; a cell is %.6g of the value\n", job.sample_bits,
        job.reach_cells, report.value_a_cell);
  print(out, "blocks        %d x %d x %d, of which %u hold samples\n", report.field.blocks.x,
        report.field.blocks.y, report.field.blocks.z, report.field.stored);
  if (report.materials > 0) {
    print(out, "materials     %u, by rules%s", report.materials,
          report.field.has_materials ? " and by sample" : "\n");
    if (report.field.has_materials)
      print(out, "; %u blocks have more than one\n", report.field.material_blocks);
  }
  print(out, "file          %zu bytes, in %.2f s\n", bytes, seconds);
  return out;
}

std::string field_report_json(const BakeField& job, const BakeField::Report& report, std::size_t bytes,
                              double seconds) {
  app::JsonWriter json;
  const auto each = [&](const char* name, glm::ivec3 v) {
    json.key(name).begin_array();
    for (int axis = 0; axis < 3; ++axis) json.value(v[axis]);
    json.end_array();
  };
  json.begin_object();
  json.key("field").begin_object();
  json.field("input", std::string_view(job.path.empty() ? job.shape : job.path));
  each("size", report.size);
  json.field("spacing_m", report.spacing_m).field("least", report.least).field("most", report.most);
  json.field("iso", job.iso).field("solid", job.solid_above ? "above" : "below");
  json.field("crossings", report.crossings).field("out_of_reach", report.out_of_reach);
  json.field("value_a_cell", report.value_a_cell).field("sample_bits", job.sample_bits);
  json.field("reach_cells", job.reach_cells);
  each("blocks", report.field.blocks);
  json.field("stored", std::uint64_t{report.field.stored});
  json.field("materials", std::uint64_t{report.materials});
  json.field("material_blocks", std::uint64_t{report.field.material_blocks}).end_object();
  json.field("file_bytes", std::uint64_t{bytes}).field("seconds", seconds);
  json.key("warnings").begin_array();
  for (const std::string& warning : report.warnings) json.value(std::string_view(warning));
  json.end_array().end_object();
  return json.text();
}

}  // namespace karst::bake
