// SPDX-License-Identifier: MIT
// Fields from files and shapes: read as they were written, refused where they are not whole, and the surface
// where the values have it.
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <unistd.h>

#include <glm/geometric.hpp>

#include "bake/fields/bake_field.h"
#include "bake/fields/field_file.h"
#include "terrain/file/world_reader.h"
#include "terrain/isosurface/extract_block.h"

namespace karst::bake {
using namespace core;
namespace {

class Folder {
 public:
  Folder() {
    char name[] = "/tmp/karst-field-XXXXXX";
    path_ = ::mkdtemp(name);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ + "/" + name, std::ios::binary) << bytes;
    return path_ + "/" + name;
  }

 private:
  std::string path_;
};

constexpr glm::ivec3 kSize(18, 20, 34);

double distance(glm::dvec3 at) {
  return glm::length(at - glm::dvec3(8.6, 9.7, 16.2)) - 6.4;
}

template <class T>
std::string samples(bool big = false) {
  std::string out;
  for (int z = 0; z < kSize.z; ++z) {
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const auto value = static_cast<T>(10 * distance(glm::dvec3(x, y, z)));
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof value);
        if (big) std::reverse(bytes, bytes + sizeof value);
        out.append(bytes, sizeof value);
      }
    }
  }
  return out;
}

std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string in = bytes, out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string nrrd(const std::string& type, const std::string& more) {
  return "NRRD0004\n# of a test\ntype: " + type + "\ndimension: 3\nsizes: 18 20 34\n" + more;
}

Error read(const std::string& path, FieldGrid& grid) {
  ReadField job;
  job.path = path;
  return job.run(grid);
}

TEST(FieldFile, IsReadInEveryEncoding) {
  const Folder folder;
  folder.write("apart.raw", "12\n" + samples<float>());
  const std::string files[] = {
      folder.write("raw.nrrd", nrrd("float", "encoding: raw\nendian: little\n\n") + samples<float>()),
      folder.write("big.nrrd", nrrd("float", "encoding: raw\nendian: big\n\n") + samples<float>(true)),
      folder.write("double.nrrd", nrrd("double", "encoding: raw\nendian: big\n\n") + samples<double>(true)),
      folder.write("gzip.nrrd",
                   nrrd("float", "encoding: gzip\nendian: little\n\n") + gzipped(samples<float>())),
      folder.write("apart.nhdr", nrrd("float", "encoding: raw\nline skip: 1\ndata file: apart.raw\n")),
      folder.write("end.nhdr", nrrd("float", "encoding: raw\nbyte skip: -1\ndata file: apart.raw\n"))};
  for (const std::string& file : files) {
    FieldGrid grid;
    const Error error = read(file, grid);
    ASSERT_TRUE(error.ok()) << error.text();
    ASSERT_EQ(grid.size, kSize);
    EXPECT_EQ(grid.spacing_m, 0);
    EXPECT_EQ(grid.at(3, 5, 7), static_cast<float>(10 * distance({3, 5, 7}))) << file;
    EXPECT_EQ(grid.at(17, 19, 33), static_cast<float>(10 * distance({17, 19, 33}))) << file;
  }
}

TEST(FieldFile, WholeNumbersOfAllSizes) {
  const Folder folder;
  const auto expect = [&](const char* type, const std::string& bytes, double value) {
    ReadField job;
    job.path = folder.write("field.raw", bytes);
    job.size = kSize;
    job.type = type;
    FieldGrid grid;
    const Error error = job.run(grid);
    ASSERT_TRUE(error.ok()) << error.text();
    EXPECT_EQ(double{grid.at(8, 9, 16)}, value) << type;
  };
  const double value = 10 * distance({8, 9, 16});  // -53.0
  expect("int8", samples<std::int8_t>(), std::trunc(value));
  expect("int16", samples<std::int16_t>(), std::trunc(value));
  expect("int32", samples<std::int32_t>(), std::trunc(value));
  expect("double", samples<double>(), double{static_cast<float>(value)});
  expect("uint8", std::string(samples<std::int8_t>().size(), '\xfe'), 254);
  expect("uint16", std::string(2 * samples<std::int8_t>().size(), '\xfe'), 0xfefe);
  expect("uint32", std::string(4 * samples<std::int8_t>().size(), '\x00'), 0);
}

TEST(FieldFile, SpacingIsTakenWhereItIsAlike) {
  const Folder folder;
  const auto with = [&](const std::string& line) {
    return folder.write("field.nrrd", nrrd("float", line + "encoding: raw\n\n") + samples<float>());
  };
  FieldGrid grid;
  ASSERT_TRUE(read(with("spacings: 0.25 0.25 0.25\n"), grid).ok());
  EXPECT_EQ(grid.spacing_m, 0.25);
  ASSERT_TRUE(read(with("space directions: (2,0,0) (0,2,0) (0,0,2)\n"), grid).ok());
  EXPECT_EQ(grid.spacing_m, 2);
  EXPECT_NE(read(with("spacings: 1 1 2\n"), grid).text().find("resample"), std::string::npos);
}

TEST(FieldFile, WhatIsNotWholeIsRefused) {
  const Folder folder;
  std::string cut = samples<float>();
  cut.pop_back();
  std::string nan = samples<float>();
  const float none = std::nanf("");
  std::memcpy(nan.data() + 400, &none, sizeof none);
  const struct {
    std::string bytes;
    const char* says;
  } cases[] = {{"P5 1 1 1\n", "not NRRD"},
               {nrrd("float", "encoding: raw\n\n") + cut, "fewer samples"},
               {nrrd("float", "encoding: gzip\n\n") + gzipped(cut), "fewer samples"},
               {nrrd("float", "encoding: gzip\n\n") + "this is not gzip at all", "gzip stream"},
               {nrrd("float", "encoding: raw\n\n") + nan, "not a number"},
               {nrrd("float", "encoding: bzip2\n\n") + cut, "neither raw nor gzip"},
               {nrrd("block", "encoding: raw\n\n") + cut, "not a type"},
               {nrrd("float", "encoding: raw\ndata file: nowhere.raw\n"), "cannot be opened"},
               {nrrd("float", "encoding: raw\ndata file: part%03d.raw 0 3 1\n"), "not one file"},
               {"NRRD0004\ntype: float\ndimension: 3\nsizes: 9 9 100000\n\n", "2 to 4080"},
               {"NRRD0004\ntype: float\ndimension: 3\nsizes: 4000 4000 4000\n\n", "67108864"},
               {"NRRD0004\ntype: float\ndimension: 4\n", "is not 3"},
               {"NRRD0004\ntype: float\ndimension: 3\n\n", "no sizes"}};
  for (const auto& c : cases) {
    FieldGrid grid;
    const Error error = read(folder.write("field.nrrd", c.bytes), grid);
    EXPECT_NE(error.text().find(c.says), std::string::npos) << c.says << ": " << error.text();
  }
}

// The field of a world file, and how far the vertices of its finest blocks are off a surface.
struct Baked {
  std::vector<std::byte> file;
  std::vector<std::uint32_t> table;
  std::vector<std::byte> samples;
  FieldBlocks field;

  Error load(const BakeField& job, BakeField::Report& report) {
    if (Error error = job.run(report, file); !error.ok()) return error;
    WorldReader reader;
    EXPECT_TRUE(reader.open(ByteSource::of(file)).ok());
    EXPECT_TRUE(reader.verify().ok());
    const FieldInfo& info = reader.field();
    EXPECT_EQ(info.stored, report.field.stored);
    table.resize(info.table_blocks());
    samples.resize(FieldBlocks::kBlockBytes * info.stored * static_cast<std::size_t>(info.sample_bits / 8));
    field.create({table, samples});
    return Error("field", reader.read_field(field));
  }

  template <class Sample, class Distance>
  double mean_off(const ScalarField<Sample>& of, const Distance& off) const {
    std::vector<std::byte> room(ExtractBlock<Sample>::room_bytes() + 16);
    void* aligned = room.data();
    std::size_t space = room.size();
    std::align(16, ExtractBlock<Sample>::room_bytes(), aligned, space);
    std::vector<IsoVertex> vertices(28'000);
    std::vector<std::uint16_t> indices(120'000);
    double sum = 0;
    std::size_t count = 0;
    const glm::ivec3 n = of.blocks();
    for (int b = 0; b < n.x * n.y * n.z; ++b) {
      ExtractBlock<Sample> job;
      job.field = &of;
      job.corner = glm::ivec3(b % n.x, b / n.x % n.y, b / n.x / n.y) * 16;
      job.vertices = vertices;
      job.triangles = indices;
      typename ExtractBlock<Sample>::Result result;
      EXPECT_TRUE(job.run({static_cast<std::byte*>(aligned), space}, result).ok());
      for (std::uint32_t v = 0; v < result.vertices; ++v) {
        const auto& place = vertices[v].place;
        const glm::dvec3 at =
            glm::dvec3(job.corner) + glm::dvec3(place[0], place[1], place[2]) / double{kIsoStepsPerCell};
        sum += std::abs(off(at));
        ++count;
      }
    }
    EXPECT_GT(count, 300u);
    return sum / static_cast<double>(count);
  }
};

TEST(BakeField, TheSurfaceIsWhereTheValuesHaveIt) {
  const Folder folder;
  for (const bool above : {false, true}) {
    for (const int bits : {8, 16}) {
      BakeField job;
      std::string bytes;
      for (int n = 0; n < kSize.x * kSize.y * kSize.z; ++n) {
        const glm::dvec3 at(n % kSize.x, n / kSize.x % kSize.y, n / kSize.x / kSize.y);
        const auto value = static_cast<float>(300 + (above ? -20 : 20) * distance(at));
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
      job.path = folder.write("field.raw", bytes);
      job.size = kSize;
      job.type = "float";
      job.spacing_m = 0.5;
      job.iso = 300;
      job.solid_above = above;
      job.sample_bits = bits;
      Baked baked;
      BakeField::Report report;
      const Error error = baked.load(job, report);
      ASSERT_TRUE(error.ok()) << error.text();
      EXPECT_TRUE(report.warnings.empty());
      EXPECT_EQ(report.info.voxel_size_m, 0.5);
      EXPECT_EQ(report.info.extent, glm::ivec3(32, 32, 48));
      EXPECT_LT(baked.field.with([](const auto& f) { return f.at({8, 9, 16}); }), 0);
      EXPECT_GT(baked.field.with([](const auto& f) { return f.at({0, 0, 0}); }), 0);
      // What linear crossings of edges have of it, and what 8 bits add.
      const double off = baked.field.with([&](const auto& f) { return baked.mean_off(f, distance); });
      EXPECT_LE(off, bits == 8 ? 0.02 : 0.015);
    }
  }
}

TEST(BakeField, ShapesAndSamples) {
  for (const char* shape : {"sphere", "torus", "gyroid", "noise", "caves"}) {
    BakeField job;
    job.shape = shape;
    job.size = {33, 40, 33};
    Baked baked;
    BakeField::Report report;
    const Error error = baked.load(job, report);
    ASSERT_TRUE(error.ok()) << error.text();
    EXPECT_GT(report.field.stored, 0u) << shape;
    if (std::string(shape) != "sphere") continue;
    EXPECT_LE(baked.mean_off(baked.field.bytes(),
                             [](glm::dvec3 p) { return glm::length(p - glm::dvec3(16, 19.5, 16)) - 11.2; }),
              0.02);
  }
}

TEST(BakeField, ALargeOneHasFinerCellsThanVoxels) {
  BakeField job;
  job.shape = "sphere";
  job.size = {600, 40, 33};
  BakeField::Report report;
  std::vector<std::byte> file;
  ASSERT_TRUE(job.run(report, file).ok());
  EXPECT_EQ(report.field.cell_log2, 12);
  EXPECT_EQ(report.info.voxel_size_m, 2);
  EXPECT_EQ(report.info.extent, glm::ivec3(304, 24, 24));
}

TEST(BakeField, NothingAndTooMuchAreTold) {
  const Folder folder;
  BakeField job;
  BakeField::Report report;
  std::vector<std::byte> file;
  job.path = folder.write("field.nrrd", nrrd("float", "encoding: raw\n\n") + samples<float>());
  job.iso = 1e6;
  EXPECT_NE(job.run(report, file).text().find("nothing crosses"), std::string::npos);
  // A step: most of its crossings change slowly, a part by far more than samples reach.
  std::string steep;
  for (int n = 0; n < 32 * 32 * 32; ++n) {
    const double height = n / 32 % 32 - 15.3;
    const auto value = static_cast<float>(n % 32 < 2 ? 100 * height : height);
    steep.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  job.path = folder.write("steep.raw", steep);
  job.size = glm::ivec3(32);
  job.type = "float";
  job.iso = 0;
  ASSERT_TRUE(job.run(report, file).ok());
  ASSERT_EQ(report.warnings.size(), 2u);
  EXPECT_NE(report.warnings[0].find("--field-spacing"), std::string::npos);
  EXPECT_NE(report.warnings[1].find("--field-reach"), std::string::npos);
}

}  // namespace
}  // namespace karst::bake
