// SPDX-License-Identifier: MIT
// karst-bench from outside, on a world of a few patches.
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::ProcessResult;

class Bench : public testing::Test {
 protected:
  void SetUp() override {
    test::TestWorld world = test::TestWorld::hills({24, 12, 20});
    world.roughen(3, 9, 700);
    world_ = folder_.write("world.karst", world.file());
  }
  ProcessResult bench(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {world_});
    return test::run_process(KARST_BENCH_PATH, arguments);
  }
  std::string file(const std::string& name) const { return folder_.path(name); }

  // Lines of a CSV file, by the names in its first.
  static std::vector<std::map<std::string, std::string>> rows(const std::string& path) {
    std::vector<std::map<std::string, std::string>> result;
    std::vector<std::string> names;
    std::istringstream text(test::read_text(path));
    for (std::string line; std::getline(text, line);) {
      std::vector<std::string> fields;
      std::istringstream cells(line + ",");
      for (std::string cell; std::getline(cells, cell, ',');) fields.push_back(cell);
      if (names.empty()) {
        names = fields;
        continue;
      }
      EXPECT_EQ(fields.size(), names.size()) << line;
      for (std::size_t i = 0; i < std::min(fields.size(), names.size()); ++i) {
        if (i == 0) result.emplace_back();
        result.back()[names[i]] = fields[i];
      }
    }
    return result;
  }

  test::Folder folder_;
  std::string world_;
};

TEST_F(Bench, ParetoMeasuresEverySettingOnEveryFlight) {
  const ProcessResult result =
      bench({"--suite", "pareto", "--size", "160x90", "--frames", "6", "--targets", "0.5,4", "--distances",
             "16", "--full", "--csv", file("a.csv"), "--json", file("a.json"), "--svg", file("a.svg")});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("teleport"), std::string::npos);
  const auto table = rows(file("a.csv"));
  ASSERT_EQ(table.size(), 16u);
  for (std::size_t i = 0; i < table.size(); ++i) {
    auto row = table[i];
    const double max = std::stod(row["error_max_px"]);
    EXPECT_GT(std::stod(row["error_pixels"]), 1000) << row["path"];
    EXPECT_GT(std::stod(row["frame_median_ms"]), 0);
    // A picture of the full level is its own reference; by error, the bound that is stated holds. The
    // reference surface between two of its pixels is known to a fraction of one.
    if (row["mode"] == "full") {
      EXPECT_EQ(max, 0) << row["path"];
      EXPECT_EQ(std::stod(row["colour_difference"]), 0) << row["path"];
    } else if (row["mode"] == "error") {
      EXPECT_LE(std::stod(row["bound_px"]), std::stod(row["target"]) * 1.001) << row["path"];
      EXPECT_LE(std::stod(row["error_p999_px"]), std::stod(row["target"]) + 0.25) << row["path"];
    }
    if (i % 4 == 1) {
      EXPECT_LE(std::stod(row["triangles"]), std::stod(table[i - 1].at("triangles")));
    }
  }
  EXPECT_EQ(test::read_text(file("a.svg")).rfind("<svg", 0), 0u);
  EXPECT_NE(test::read_text(file("a.json")).find("\"first_frame_ms\""), std::string::npos);
}

TEST_F(Bench, ParetoFliesAPathAndDrawsPeers) {
  const std::string path = folder_.write("mine.txt", "12 12 18 0 -20\n12 12 16 10 -20\n");
  const std::string peers =
      folder_.write("peers.csv", "peer,setting,frame_median_ms,error_p99_px\nOther & son,1,20,3\n");
  const std::vector<std::string> words = {"--suite", "pareto",      "--size", "64x36",       "--path",
                                          path,      "--targets",   "1",      "--distances", "none",
                                          "--svg",   file("a.svg"), "--csv",  file("a.csv")};
  auto with_peers = words;
  with_peers.insert(with_peers.end(), {"--peers", peers});
  ASSERT_EQ(bench(with_peers).code, 0);
  EXPECT_EQ(rows(file("a.csv")).size(), 1u);
  EXPECT_EQ(rows(file("a.csv"))[0]["path"], "mine");
  EXPECT_NE(test::read_text(file("a.svg")).find("Other &amp; son"), std::string::npos);
  auto without_errors = words;
  without_errors.emplace_back("--no-errors");
  ASSERT_EQ(bench(without_errors).code, 0);
  EXPECT_EQ(rows(file("a.csv"))[0]["error_max_px"], "");
}

TEST_F(Bench, ParetoNamesTheFileAtFault) {
  const std::string bad = folder_.write("bad.csv", "peer,frame_median_ms\nA,1,2\n");
  const ProcessResult peers =
      bench({"--suite", "pareto", "--size", "64x36", "--frames", "1", "--targets", "8", "--distances", "none",
             "--no-errors", "--svg", file("a.svg"), "--peers", bad});
  EXPECT_EQ(peers.code, 1);
  EXPECT_NE(peers.err.find(bad + ": a line has not as many values"), std::string::npos) << peers.err;
  const ProcessResult elevation = bench({"--suite", "pareto", "--elevation", bad, "--pixel-size", "1"});
  EXPECT_EQ(elevation.code, 1);
  EXPECT_NE(elevation.err.find(bad + ": not a PNG file"), std::string::npos) << elevation.err;
  EXPECT_EQ(bench({"--suite", "pareto", "--svg", file("none/a.svg")}).code, 1);
}

TEST_F(Bench, LodStandsBesideTheThesis) {
  test::TestWorld world({24, 12, 20}, [](glm::ivec3 v) { return v.y < 5; });
  world.roughen(4, 9, 700);
  const std::string level_4 = folder_.write("four.karst", world.file());
  const ProcessResult result =
      test::run_process(KARST_BENCH_PATH, {level_4, "--suite", "lod", "--size", "64x36", "--frames", "2"});
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* part :
       {"    4      1 |", "    4      2 |", "    4      4 |", "K:    0.25    0.40       5.4"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  EXPECT_EQ(result.out.find("    5      1 |"), std::string::npos) << "the world has no level 5";
  const ProcessResult coarse = bench({"--suite", "lod"});
  EXPECT_EQ(coarse.code, 1);
  EXPECT_NE(coarse.err.find("has neither level 4 nor level 5"), std::string::npos) << coarse.err;
}

// Lines of a text that hold a word.
std::string lines_with(const std::string& text, const std::string& word) {
  std::istringstream in(text);
  std::string result;
  for (std::string line; std::getline(in, line);) {
    if (line.find(word) != std::string::npos) result += line + "\n";
  }
  return result;
}

TEST_F(Bench, SelectFliesTheSameFramesEachTime) {
  const std::vector<std::string> words = {"--suite", "select", "--frames", "6",          "--rounds",
                                          "1",       "--size", "160x90",   "--error-px", "1"};
  const ProcessResult result = bench(words);
  ASSERT_EQ(result.code, 0) << result.err;
  const std::string lists = lines_with(result.out, "; lists ");
  for (const char* flight : {"low: ", "oblique: ", "still: "})
    EXPECT_NE(lists.find(flight), std::string::npos);
  const std::string once = "  1.00 selections a frame\n";
  EXPECT_EQ(lines_with(result.out, "selections a frame"), once + once + once);
  EXPECT_EQ(lists.find(": 0 patches"), std::string::npos) << lists;
  EXPECT_EQ(lists, lines_with(bench(words).out, "; lists "));
  // Complete frames have nothing that lacks, and need no second selection.
  std::vector<std::string> all = words;
  all.insert(all.end(), {"--generate-ms", "0"});
  const ProcessResult complete = bench(all);
  EXPECT_EQ(lines_with(complete.out, "0.0 lack something").size(),
            lines_with(complete.out, "; lists ").size());
  EXPECT_EQ(bench({"--suite", "select", "--json", "-"}).code, 2);
}

// The number behind a key, of the object with this name; NaN where it is none.
double number_of(const std::string& json, const std::string& name, const std::string& key) {
  const std::size_t object = json.find("\"name\": \"" + name + "\"");
  const std::size_t at = object == std::string::npos ? object : json.find("\"" + key + "\": ", object);
  if (at == std::string::npos) return std::nan("");
  return std::strtod(json.c_str() + at + key.size() + 4, nullptr);
}

TEST_F(Bench, ShadingComparesWhatIsSkipped) {
  const ProcessResult result =
      bench({"--suite", "shading", "--size", "96x54", "--rounds", "1", "--json", file("a.json")});
  ASSERT_EQ(result.code, 0) << result.err;
  const std::string json = test::read_text(file("a.json"));
  for (const char* name : {"frustum", "backface", "occlusion", "cascades", "all"}) {
    EXPECT_NE(result.out.find(std::string("\n") + name + " "), std::string::npos) << result.out;
    EXPECT_GT(number_of(json, name, "ns_a_pixel"), 0) << name;
    EXPECT_GT(number_of(json, name, "cpu_ratio"), 0) << name;
    // What is skipped changes no pixel.
    EXPECT_EQ(number_of(json, name, "difference_max"), 0) << name;
  }
  // Drawing two shadow maps anew in each frame is what a small world's frame costs most.
  EXPECT_LT(number_of(json, "cascades", "cpu_ratio"), 0.95);
  EXPECT_GT(number_of(json, "shadows", "difference_max"), 20) << "the flights see shadows";
  EXPECT_LE(number_of(json, "precision", "difference_max"), 4);
  EXPECT_NE(json.find("\"textures\": null"), std::string::npos);
}

TEST_F(Bench, FramesAreTimedOnThreeFlights) {
  const ProcessResult result =
      bench({"--suite", "frames", "--size", "96x54", "--frames", "3", "--json", file("a.json")});
  ASSERT_EQ(result.code, 0) << result.err;
  const std::string json = test::read_text(file("a.json"));
  for (const char* name : {"low", "oblique", "high"}) {
    EXPECT_NE(result.out.find(std::string("\n") + name + " "), std::string::npos) << result.out;
    EXPECT_GT(number_of(json, name, "median"), 0) << name;
    EXPECT_GE(number_of(json, name, "p95"), number_of(json, name, "median")) << name;
    EXPECT_GT(number_of(json, name, "triangles"), 10) << name;
  }
  EXPECT_NE(json.find("\"size\": [\n    96,\n    54\n  ]"), std::string::npos) << json;
  EXPECT_NE(json.find("\"gpu_used\": "), std::string::npos);
  EXPECT_EQ(bench({"--suite", "frames", "--path", file("a")}).code, 2);
}

#ifdef KARST_BAKE_PATH
TEST_F(Bench, ShadingComparesTexturesOfTwoWorlds) {
  for (const char* format : {"etc2", "rgba8"}) {
    const ProcessResult baked =
        test::run_process(KARST_BAKE_PATH, {"--sample", "hills", "--no-ground", "--voxel", "16", "--levels",
                                            "2", "--material-side", "16", "--material-format", format, "-o",
                                            file(format), "--quiet"});
    ASSERT_EQ(baked.code, 0) << baked.err;
  }
  const std::vector<std::string> words = {file("etc2"), "--suite", "shading", "--size", "96x54",
                                          "--rounds",   "1",       "--json",  "-",      "--against"};
  const auto against = [&](const std::string& world) {
    auto all = words;
    all.push_back(world);
    return test::run_process(KARST_BENCH_PATH, all);
  };
  const ProcessResult result = against(file("rgba8"));
  ASSERT_EQ(result.code, 0) << result.err;
  const double difference = number_of(result.out, "textures", "difference_mean");
  EXPECT_GT(difference, 0);
  EXPECT_LT(difference, 3);
  const auto value = [&](const std::string& key) {
    const std::size_t at = result.out.find("\"" + key + "\": ");
    return at == std::string::npos ? 0 : std::strtod(result.out.c_str() + at + key.size() + 4, nullptr);
  };
  // The near array's half, and a quarter of the far one's but for mips of less than a block.
  EXPECT_LT(value("on_bytes"), 0.52 * value("off_bytes"));
  EXPECT_GT(value("albedo"), 30);
  EXPECT_GT(value("brightness"), 25);
  EXPECT_GT(value("slope"), 15);

  const ProcessResult other = against(world_);
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.err.find("baked another way"), std::string::npos) << other.err;
}
#endif

TEST_F(Bench, FlightIsAPathThatParetoFlies) {
  const std::vector<std::string> words = {"--suite", "flight", "--size", "160x90", "--frames", "3"};
  const ProcessResult overview = bench(words);
  ASSERT_EQ(overview.code, 0) << overview.err;
  auto low_words = words;
  low_words.insert(low_words.end(), {"--flight", "low"});
  const ProcessResult low = bench(low_words);
  ASSERT_EQ(low.code, 0) << low.err;
  std::vector<std::string> lines[2];
  int flight = 0;
  for (const ProcessResult* result : {&overview, &low}) {
    std::istringstream text(result->out);
    for (std::string line; std::getline(text, line);) {
      if (line.empty() || line[0] == '#') continue;
      lines[flight].push_back(line);
      // Some of the picture is sky and some is not.
      const double pixels = std::strtod(line.c_str() + line.find('#') + 1, nullptr);
      EXPECT_GT(pixels, 160 * 90 / 10) << line;
      EXPECT_LT(pixels, 160 * 90) << line;
    }
    ASSERT_EQ(lines[flight++].size(), 3u);
  }
  EXPECT_EQ(lines[0][0], lines[0][2]) << "the whole world is seen from one place";
  EXPECT_NE(lines[1][0], lines[1][2]);
  const std::string path = folder_.write("low.txt", low.out);
  const ProcessResult flown = bench({"--suite", "pareto", "--size", "64x36", "--path", path, "--targets", "4",
                                     "--distances", "none", "--no-errors", "--csv", file("a.csv")});
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_EQ(rows(file("a.csv"))[0]["path"], "low");
  EXPECT_EQ(bench({"--suite", "flight", "--targets", "4"}).code, 2);
  EXPECT_EQ(bench({"--suite", "pareto", "--flight", "low"}).code, 2);
}

TEST_F(Bench, CoreWritesJson) {
  const ProcessResult result = bench({"--rounds", "1", "--json", "-"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out.rfind("{\n", 0), 0u);
  ASSERT_EQ(bench({"--rounds", "1", "--json", file("core.json")}).code, 0);
  EXPECT_NE(test::read_text(file("core.json")).find("\"patches\""), std::string::npos);
}

TEST(BenchMotion, FliesWithReadingAheadAndWithout) {
  const ProcessResult result = test::run_process(
      KARST_BENCH_PATH, {"--suite", "motion", "--size", "64x36", "--frames", "12", "--error-px", "16"});
  ASSERT_EQ(result.code, 0) << result.err;
  int flights = 0;
  std::istringstream text(result.out);
  for (std::string line; std::getline(text, line);) flights += line.find("%") != std::string::npos ? 1 : 0;
  EXPECT_EQ(flights, 8) << result.out;
}

TEST(BenchSweep, MakesItsOwnGrounds) {
  const std::vector<std::string> words = {"--suite",  "sweep", "--size",  "64x36", "--frames",     "2",
                                          "--rounds", "1",     "--jumps", "1",     "--disk-sleep", "1",
                                          "--json",   "-"};
  const ProcessResult result = test::run_process(KARST_BENCH_PATH, words);
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream text(result.out);
  int grounds = 0;
  for (std::string line; std::getline(text, line);) {
    if (line.find("\"samples_a_side\"") != std::string::npos) ++grounds;
    // The first frame after a jump shows ground in all of its pixels.
    if (line.find("\"open_pixels\"") != std::string::npos) {
      EXPECT_NE(line.find("\"open_pixels\": 0"), std::string::npos) << line;
    }
  }
  EXPECT_EQ(grounds, 4);
  const ProcessResult world = test::run_process(KARST_BENCH_PATH, {"a.karst", "--suite", "sweep"});
  EXPECT_EQ(world.code, 2);
  EXPECT_NE(world.err.find("take no WORLD"), std::string::npos) << world.err;
}

}  // namespace
}  // namespace karst::core
