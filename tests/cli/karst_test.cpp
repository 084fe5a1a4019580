// SPDX-License-Identifier: MIT
// karst from outside: results, messages, exit codes, and what is left in the folder.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process.h"
#include "tests/support/test_world.h"
#include "tests/support/world_damage.h"

namespace karst::core {
namespace {

using test::Folder;
using test::ProcessResult;
using test::read_text;
using Names = std::vector<std::string>;

std::vector<std::byte> small_world(int level = 2, glm::ivec3 extent = {16, 12, 14}) {
  test::TestWorld world = test::TestWorld::hills(extent);
  world.roughen(level, 9, 500);
  return world.file();
}

class Karst : public testing::Test {
 protected:
  void SetUp() override { world_ = folder_.write("world.karst", small_world()); }

  // "bench" is a program of its own.
  static ProcessResult run(std::vector<std::string> arguments,
                           const std::vector<std::string>& environment = {}) {
    const bool bench = !arguments.empty() && arguments[0] == "bench";
    if (bench) arguments.erase(arguments.begin());
    return test::run_process(bench ? KARST_BENCH_PATH : KARST_APP_PATH, arguments, environment);
  }
  ProcessResult render(std::vector<std::string> arguments, const std::vector<std::string>& environment = {}) {
    arguments.insert(arguments.begin(), {"render", world_, "--size", "64x36"});
    return run(arguments, environment);
  }
  std::string file(const std::string& name) const { return folder_.path(name); }

  // One line to stderr that begins with the command and holds each of the parts; nothing to stdout.
  static void expect_error(const ProcessResult& result, int code, const Names& parts) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.err.rfind("karst", 0), 0u) << result.err;
    for (const std::string& part : parts)
      EXPECT_NE(result.err.find(part), std::string::npos) << part << "\n" << result.err;
  }

  Folder folder_;
  std::string world_;
};

// "name": , as JSON has it.
std::string json_key(const std::string& name) {
  std::string text(1, '"');
  text += name;
  text += "\": ";
  return text;
}

struct PngSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

PngSize png_size(const std::string& path) {
  const std::string bytes = read_text(path);
  if (bytes.size() < 24 || bytes.substr(1, 3) != "PNG" || bytes.substr(bytes.size() - 8, 4) != "IEND")
    return {};
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  return {number(16), number(20)};
}

TEST_F(Karst, OutputsAreNeitherInputsNorEachOther) {
  const std::string before = test::read_text(world_);
  const std::string png = file("a.png");
  std::ofstream(file("path.txt")) << "0 9000 0 0 -90\n0 9000 0 0 -90\n";
  const Names path = {"render", world_, "--path", file("path.txt")};
  const auto with = [](Names words, const Names& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  expect_error(run({"render", world_, "-o", world_}), 1, {"--output", "is also WORLD"});
  expect_error(run({"render", world_, "-o", png, "--stats", world_}), 1, {"--stats", "is also WORLD"});
  expect_error(run({"render", world_, "-o", png, "--stats", png}), 1, {"--output", "is also --stats"});
  expect_error(run(with(path, {"-o", file("f%d.png"), "--stats", file("f1.png")})), 1, {"is also --stats"});
  expect_error(run({"view", world_, "--headless", "--frames", "1", "--stats", world_}), 1, {"is also WORLD"});
  EXPECT_EQ(test::read_text(world_), before);
}

TEST_F(Karst, WhatDoesNotReachStandardOutputIsAFailure) {
  for (const std::string& words :
       {std::string("--help"), std::string("--version"), std::string("info --help"), "info " + world_,
        "budget " + world_, std::string("budget --list-boards"),
        "render " + world_ + " --size 16x16 --stats -",
        "view " + world_ + " --headless --size 16x16 --frames 1 --stats -"}) {
    const auto result =
        test::run_process("/bin/sh", {"-c", std::string(KARST_APP_PATH) + " " + words + " >/dev/full"});
    expect_error(result, 1, {"standard output: cannot write"});
  }
}

// What is printed goes to no file that was opened in the place of a closed one.
TEST_F(Karst, ClosedStandardFilesAreNoneOfItsOwn) {
  const std::string before = read_text(world_);
  for (const std::string& words : {"render " + world_ + " --size 16x16 -o " + file("a.png") + " --stats -",
                                   "info " + world_, std::string("--help")}) {
    for (const char* closed : {">&-", "<&- >&- 2>&-"}) {
      const auto result =
          test::run_process("/bin/sh", {"-c", std::string(KARST_APP_PATH) + " " + words + " " + closed});
      EXPECT_EQ(result.code, 1) << words << closed;
    }
  }
  EXPECT_EQ(read_text(world_), before);
  EXPECT_EQ(png_size(file("a.png")).width, 16u);
}

TEST_F(Karst, HelpAndVersion) {
  for (const Names& words : {Names{"--help"}, Names{"-h"}, Names{"render", "--help"}, Names{"info", "-h"},
                             Names{"budget", "--help"}, Names{"bench", "--help"}}) {
    const ProcessResult result = run(words);
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.out.rfind("usage: karst", 0), 0u);
    EXPECT_NE(result.out.find("\n  karst"), std::string::npos) << "an example";
    EXPECT_EQ(result.err, "");
  }
  EXPECT_EQ(run({"--version"}).out, "karst " KARST_VERSION "\n");
  const ProcessResult none = run({});
  EXPECT_EQ(none.code, 2);
  EXPECT_EQ(none.out, "");
}

TEST_F(Karst, UsageErrors) {
  const std::string out = file("a.png");
  const struct {
    Names words;
    std::string part;
  } cases[] = {
      {{"draw"}, "unknown command 'draw'"},
      {{"render"}, "which WORLD?"},
      {{"render", world_}, "nothing to do"},
      {{"render", world_, world_, "-o", out}, "more than one WORLD"},
      {{"render", world_, "-o"}, "'-o' needs a value"},
      {{"render", world_, "-o", ""}, "--output: the file name is empty"},
      {{"render", world_, "-o", "--size"}, "'-o' needs a value, not '--size'"},
      {{"render", world_, "-o", "x.d/a.jpg"}, "--output: pictures are PNG, not jpg; name it x.d/a.png"},
      {{"render", world_, "-o", "a%04d.TIFF"}, "name it a%04d.png"},
      {{"render", world_, "-o", out, "-o", out}, "given twice"},
      {{"render", world_, "-o", out, "--colour", "red"}, "unknown option '--colour'"},
      {{"render", world_, "-o", out, "--help=yes"}, "takes no value"},
      {{"render", world_, "-o", file("%s.png")}, "%04d"},
      {{"render", world_, "-o", file("%d%d.png")}, "%04d"},
      {{"render", world_, "-o", out, "--size", "64"}, "--size: '64' is not WIDTHxHEIGHT"},
      {{"render", world_, "-o", out, "--size", "0x36"}, "--size: 0 is not in 1 to 16384"},
      {{"render", world_, "-o", out, "--size", "64x2147483648"}, "--size"},
      {{"render", world_, "-o", out, "--size", "99999999999999999999x1"}, "--size"},
      {{"render", world_, "-o", out, "--camera", "1,2,3,4"}, "--camera: '1,2,3,4' is not 5 numbers"},
      {{"render", world_, "-o", out, "--camera", "1,2,3,4,5,6"}, "is not 5 numbers"},
      {{"render", world_, "-o", out, "--camera", "1,2,nan,4,5"}, "--camera: 'nan' is not a number"},
      {{"render", world_, "-o", out, "--camera", "1,2,1e999,4,5"}, "is not a number"},
      {{"render", world_, "-o", out, "--camera", "1,2,3,4,5", "--path", "p"}, "exclude each other"},
      {{"render", world_, "-o", out, "--sun", "10"}, "--sun: '10' is not 2 numbers"},
      {{"render", world_, "-o", out, "--sun", "10,91"}, "--sun: not within -90..90 degrees"},
      {{"render", world_, "-o", out, "--fov", "171"}, "--fov: 171 is not in 1 to 170"},
      {{"render", world_, "-o", out, "--level", "7"}, "--level: 7 is not in 1 to 6"},
      {{"render", world_, "-o", out, "--level", "2.5"}, "--level: '2.5' is not a whole number"},
      {{"render", world_, "-o", out, "--lod-distance", "-1"}, "--lod-distance"},
      {{"render", world_, "-o", out, "--lod", "near"}, "--lod: 'near' is not one of error distance full"},
      {{"render", world_, "-o", out, "--error-px", "0"}, "--error-px: 0 is not in 0.01 to 1000"},
      {{"render", world_, "-o", out, "--drape", ""}, "--drape: the file name is empty"},
      {{"render", world_, "-o", out, "--size", "1x65"},
       "--size: 1x65: one side is more than 64 times the other"},
      {{"render", world_, "-o", out, "--drape-repeat", "2"}, "--drape-repeat needs a --drape"},
      {{"render", world_, "-o", out, "--drape", "a.png", "--drape-repeat", "0"},
       "--drape-repeat: 0 is not in"},
      {{"render", world_, "-o", out, "--shadows", "4"}, "--shadows: 4 is not in 0 to 3"},
      {{"render", world_, "-o", out, "--shadow-size", "1000"}, "--shadow-size: not a multiple of 16"},
      {{"render", world_, "-o", out, "--shadow-reach", "3"}, "--shadow-reach: 3 is not in 4 to"},
      {{"render", world_, "-o", out, "--haze", "0"}, "--haze"},
      {{"render", world_, "-o", out, "--no-skip", "sky"}, "--no-skip: 'sky' is none of frustum backface"},
      {{"render", world_, "-o", out, "--show", "sky"}, "--show: 'sky' is not one of materials"},
      {{"render", world_, "-o", out, "--precision", "low"},
       "--precision: 'low' is not one of auto medium high"},
      {{"render", world_, "-o", out, "--max-memory", "0"}, "--max-memory"},
      {{"info"}, "takes one WORLD"},
      {{"info", world_, world_}, "takes one WORLD"},
      {{"budget", "--level", "3"}, "--level needs a WORLD"},
      {{"budget", world_, "--level", "0"}, "--level: 0 is not in 1 to 6"},
      {{"bench"}, "takes one WORLD"},
      {{"bench", world_, "--suite", "all"}, "--suite: 'all' is not one of core lod pareto shading shadows"},
      {{"bench", world_, "--suite", "pareto", "--targets", "1,x"}, "--targets: 'x' is not a number"},
      {{"bench", world_, "--suite", "pareto", "--targets", "0"}, "--targets: 0 is not in 0.01 to 1000"},
      {{"bench", world_, "--suite", "pareto", "--elevation", "a.png"}, "--elevation: needs --pixel-size"},
      {{"bench", world_, "--suite", "pareto", "--targets", "none", "--distances", "none"}, "nothing to"},
  };
  for (const auto& c : cases) expect_error(run(c.words), 2, {c.part});
  EXPECT_EQ(folder_.names(), Names{"world.karst"});
}

TEST_F(Karst, DrawsAPicture) {
  const ProcessResult result = render({"-o", file("a.png")});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(png_size(file("a.png")).width, 64u);
  EXPECT_EQ(png_size(file("a.png")).height, 36u);
  EXPECT_EQ(folder_.names(), (Names{"a.png", "world.karst"}));
  // The same again, over the old file.
  const std::string first = read_text(file("a.png"));
  EXPECT_EQ(render({"--output=" + file("a.png"), "--camera", "8,6,20,10,-5"}).code, 0);
  EXPECT_NE(read_text(file("a.png")), first);
  EXPECT_EQ(render({"-o", file("a.png")}).code, 0);
  EXPECT_EQ(read_text(file("a.png")), first);
}

TEST_F(Karst, CoarserLevelsNeedLessMemory) {
  EXPECT_EQ(render({"-o", file("a.png"), "--level", "1", "--max-memory", "16"}).code, 0);
  EXPECT_EQ(png_size(file("a.png")).width, 64u);
}

TEST_F(Karst, PathsMakeNumberedPictures) {
  const std::string path =
      folder_.write("path.txt", "# two frames\n8 9 18 10 -20\n\n  8\t9 17 15 -20  # second\r\n");
  ASSERT_EQ(render({"--path", path, "-o", file("a.png")}).code, 0);
  EXPECT_EQ(folder_.names(), (Names{"a_0000.png", "a_0001.png", "path.txt", "world.karst"}));
  ASSERT_EQ(render({"--path", path, "-o", file("b%02d%%.png"), "--stats", file("s.json")}).code, 0);
  EXPECT_EQ(folder_.names(),
            (Names{"a_0000.png", "a_0001.png", "b00%.png", "b01%.png", "path.txt", "s.json", "world.karst"}));
  EXPECT_EQ(read_text(file("a_0001.png")), read_text(file("b01%.png")));
  // A path of one frame is one picture; without -o only statistics are made.
  const std::string one = folder_.write("one.txt", "8 9 17 15 -20");
  ASSERT_EQ(render({"--path", one, "-o", file("c.png")}).code, 0);
  EXPECT_EQ(read_text(file("c.png")), read_text(file("a_0001.png")));
  const ProcessResult only_statistics = render({"--path", one, "--stats", "-"});
  EXPECT_EQ(only_statistics.code, 0);
  EXPECT_EQ(only_statistics.out.rfind("{\n  \"frames\": 1,", 0), 0u) << only_statistics.out;
}

TEST_F(Karst, StatisticsHaveTheDocumentedKeys) {
  ASSERT_EQ(render({"--stats", file("s.json")}).code, 0);
  const std::string text = read_text(file("s.json"));
  for (const char* key : {"frames",
                          "size",
                          "renderer",
                          "frame_ms",
                          "median",
                          "p99",
                          "max",
                          "cpu_ms",
                          "cull_lod",
                          "generate",
                          "upload",
                          "submit",
                          "gpu_ms",
                          "shadow",
                          "terrain",
                          "triangles",
                          "draw_calls",
                          "patches",
                          "total",
                          "resident",
                          "drawn",
                          "culled_frustum",
                          "culled_backface",
                          "culled_occluded",
                          "skips",
                          "bytes",
                          "cpu_budget",
                          "cpu_used",
                          "gpu_budget",
                          "heap_calls_after_init",
                          "gl_objects_after_init",
                          "error_px",
                          "bound",
                          "flags"}) {
    EXPECT_NE(text.find(json_key(key)), std::string::npos) << key;
  }
  // Two shadow maps, terrain and sky; or the G-buffer, what is in it, and sky.
  const bool deferred = text.find("\"way\": \"deferred\"") != std::string::npos;
  EXPECT_NE(text.find(deferred ? "\"draw_calls\": 5," : "\"draw_calls\": 4,"), std::string::npos) << text;
  EXPECT_NE(text.find(json_key("heap_calls_after_init") + "0,"), std::string::npos) << text;
  EXPECT_NE(text.find(json_key("gl_objects_after_init") + "0,"), std::string::npos) << text;
}

// What docs/formats.md says of --stats is what is written, by karst render and karst view.
TEST_F(Karst, EveryFieldOfTheStatisticsIsDocumented) {
  const std::string page = read_text(KARST_SOURCE_DIR "/docs/formats.md");
  const std::size_t begin = page.find("\n## Statistics");
  ASSERT_NE(begin, std::string::npos);
  const std::string section = page.substr(begin, page.find("\n## ", begin + 1) - begin);
  const std::size_t view_begins = section.find("\n### `karst view`");
  ASSERT_NE(view_begins, std::string::npos);
  const auto check = [&](const std::string& json, const std::string& part) {
    int fields = 0;
    for (std::size_t at = json.find("\": "); at != std::string::npos; at = json.find("\": ", at + 1)) {
      const std::size_t start = json.rfind('"', at - 1) + 1;
      const std::string name = json.substr(start, at - start);
      EXPECT_NE(part.find("`" + name + "`"), std::string::npos) << name;
      ++fields;
    }
    EXPECT_GT(fields, 20) << json;
  };
  check(render({"--stats", "-"}).out, section.substr(0, view_begins));
  check(run({"view", world_, "--headless", "--size", "64x36", "--frames", "2", "--stats", "-"}).out,
        section.substr(view_begins));
}

// A turning camera: maps are drawn once, and again only where more of the world has become resident; drawing
// them in every frame gives the same pictures.
TEST_F(Karst, ShadowMapsAreKeptWhileTheCameraTurns) {
  std::string path;
  for (int frame = 0; frame < 24; ++frame) path += "8 12 8 " + std::to_string(30 * frame % 360) + " -30\n";
  const std::string turning = folder_.write("turning.txt", path);
  const auto run = [&](const std::string& pictures, const std::vector<std::string>& options) {
    std::vector<std::string> words{"--path", turning, "-o", file(pictures), "--stats", "-"};
    words.insert(words.end(), options.begin(), options.end());
    const std::string text = render(words).out;
    const std::size_t at = text.find(json_key("cascades"));
    return at == std::string::npos ? -1.0
                                   : std::strtod(text.c_str() + at + json_key("cascades").size(), nullptr);
  };
  EXPECT_EQ(run("all%02d.png", {"--no-skip", "cascades"}), 0.0);
  EXPECT_GE(run("few%02d.png", {}), 1.5) << "of two";
  EXPECT_EQ(run("none%02d.png", {"--shadows", "0"}), 0.0);
  int shaded = 0;
  for (int frame = 0; frame < 24; ++frame) {
    char number[16];
    std::snprintf(number, sizeof number, "%02d.png", frame);
    const std::string few = read_text(file(std::string("few") + number));
    EXPECT_EQ(few, read_text(file(std::string("all") + number))) << frame;
    shaded += few != read_text(file(std::string("none") + number)) ? 1 : 0;
  }
  EXPECT_GT(shaded, 12);
}

TEST_F(Karst, DrapesComeFromPngFiles) {
  // A picture of karst's own is as good as any.
  ASSERT_EQ(render({"-o", file("drape.png")}).code, 0);
  ASSERT_EQ(render({"-o", file("draped.png"), "--drape", file("drape.png"), "--drape-repeat", "3"}).code, 0);
  std::string damaged = read_text(file("drape.png"));
  damaged.resize(damaged.size() / 2);
  folder_.write("half.png", damaged);
  folder_.write("text.png", std::string("not a picture"));
  const std::string out = file("none.png");
  expect_error(render({"-o", out, "--drape", file("half.png")}), 1, {"half.png: a damaged PNG picture"});
  expect_error(render({"-o", out, "--drape", file("text.png")}), 1, {"text.png: not a PNG picture"});
  expect_error(render({"-o", out, "--drape", file("no.png")}), 1, {"no.png: cannot read"});
  EXPECT_EQ(folder_.names(), (Names{"drape.png", "draped.png", "half.png", "text.png", "world.karst"}));
}

TEST_F(Karst, StatisticsStateTheErrorBound) {
  const auto bound = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"--stats", "-"};
    words.insert(words.end(), options.begin(), options.end());
    const std::string text = render(words).out;
    const std::size_t at = text.find(json_key("bound"));
    return at == std::string::npos ? -1.0
                                   : std::strtod(text.c_str() + at + json_key("bound").size(), nullptr);
  };
  EXPECT_EQ(bound({}), 4.0);
  EXPECT_EQ(bound({"--error-px", "2.5"}), 2.5);
  EXPECT_EQ(bound({"--lod", "full"}), 0.0);
  EXPECT_GT(bound({"--lod", "distance", "--lod-distance", "0"}), 1.0);
  EXPECT_GT(bound({"--level", "1"}), 1.0) << "level 1 alone is not enough for 1 pixel";
}

TEST_F(Karst, BadPathsNameFileAndLine) {
  const struct {
    std::string text;
    std::string part;
  } cases[] = {{"8 9 18 10 -20\n8 9 18 10\n", ": line 2: '8 9 18 10' is not 5 numbers"},
               {"8 9 18 10 -20 7\n", ": line 1: '8 9 18 10 -20 7' is not 5 numbers"},
               {"\n# x\n8 9 eighteen 10 -20", ": line 3: 'eighteen' is not a number"},
               {"8,9,18,10,-20", ": line 1"},
               {"# nothing\n\n", ": no camera in it"},
               {std::string("8 9 \0 10 -20", 12), ": line 1"},
               {"8 9 18 10 -95", ": frame 0: not within -90..90 degrees (pitch_deg)"}};
  for (const auto& c : cases) {
    const std::string path = folder_.write("path.txt", c.text);
    expect_error(render({"--path", path, "-o", file("a.png")}), 1, {path + c.part});
  }
  expect_error(render({"--path", file("none.txt"), "-o", file("a.png")}), 1,
               {"none.txt: cannot read: No such file"});
  EXPECT_EQ(folder_.names(), (Names{"path.txt", "world.karst"}));
}

TEST_F(Karst, PathsMayBeginWithAByteOrderMark) {
  const std::string path = folder_.write("path.txt",
                                         "\xEF\xBB\xBF"
                                         "8 9 7 0 -10\r\n8 9 7 5 -10\r\n");
  EXPECT_EQ(render({"--path", path, "-o", file("bom.png")}).code, 0);
}

TEST_F(Karst, WhatComesFromOutsideCannotSteerTerminals) {
  const std::string path = folder_.write("path.txt",
                                         "\xC2\x9B"
                                         "31m\xE2\x80\xAE 9 7 0 -10\n");
  const ProcessResult result = render({"--path", path, "-o", file("a.png")});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err.find('\xC2'), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find('\xE2'), std::string::npos) << result.err;
}

TEST_F(Karst, ImpossibleCameras) {
  for (const char* camera : {"1e300,0,0,0,0", "0,-1e7,0,0,0", "1,2,3,4,90.001", "1,2,3,1e7,0"}) {
    expect_error(render({"-o", file("a.png"), "--camera", camera}), 1, {"--camera: "});
  }
  EXPECT_EQ(folder_.names(), Names{"world.karst"});
}

TEST_F(Karst, WorldsThatAreNone) {
  std::filesystem::create_directory(file("folder"));
  folder_.write("empty.karst", std::string());
  folder_.write("text.karst", std::string(1000, 'x'));
  const struct {
    std::string name;
    std::string part;
  } cases[] = {{"missing.karst", ": cannot read: No such file or directory"},
               {"folder", ": cannot read: Is a directory"},
               {"empty.karst", ": the file is empty"},
               {"text.karst", ": "}};
  const Names before = folder_.names();
  for (const auto& c : cases) {
    expect_error(run({"render", file(c.name), "-o", file("a.png")}), 1, {file(c.name) + c.part});
    expect_error(run({"info", file(c.name)}), 1, {file(c.name) + c.part});
    expect_error(run({"budget", file(c.name)}), 1, {file(c.name) + c.part});
    expect_error(run({"bench", file(c.name)}), 1, {file(c.name) + c.part});
  }
  expect_error(run({"info", "/dev/zero"}), 1, {"not a regular file"});
  expect_error(run({"info", file("a\nb")}), 1, {"a?b"});
  EXPECT_EQ(folder_.names(), before);
}

TEST_F(Karst, DamagedWorlds) {
  const std::vector<std::byte> good = small_world();
  const auto expect_refused = [&](const std::vector<std::byte>& bytes, const std::string& part) {
    const std::string name = folder_.write("bad.karst", bytes);
    expect_error(run({"render", name, "-o", file("a.png")}), 1, {name + ": ", part});
  };
  for (const std::size_t length : {std::size_t{1}, std::size_t{100}, good.size() / 2, good.size() - 1}) {
    expect_refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}, "");
  }
  for (std::size_t at = 1; at < good.size(); at += good.size() / 9) {
    std::vector<std::byte> bytes = good;
    bytes[at] ^= std::byte{0x10};
    expect_refused(bytes, "");
  }
  std::vector<std::byte> bytes = good;
  store_at<std::uint32_t>(bytes, world_offsets::kVersion, 99);
  expect_refused(bytes, "version");
  // Hostile numbers behind checksums that fit.
  bytes = good;
  store_at<std::uint32_t>(bytes, world_offsets::kPatches, 0x7fffffff);
  fix_checksums(bytes);
  expect_refused(bytes, "patches");
  bytes = good;
  store_at<double>(bytes, world_offsets::kVoxelSize, -1.0);
  fix_checksums(bytes);
  expect_refused(bytes, "voxel_size_m");
  EXPECT_EQ(folder_.names(), (Names{"bad.karst", "world.karst"}));
}

TEST_F(Karst, OutputsThatCannotBeWritten) {
  std::filesystem::create_directory(file("folder"));
  const Names before = folder_.names();
  expect_error(render({"-o", file("none/a.png")}), 1,
               {"none/a.png: cannot write: No such file or directory"});
  expect_error(render({"-o", file("folder")}), 1, {"folder: cannot write: Is a directory"});
  expect_error(render({"-o", file("folder/")}), 1, {"cannot write"});
  expect_error(render({"-o", file("world.karst/a.png")}), 1, {"a.png: cannot write: Not a directory"});
  expect_error(render({"--stats", file("none/s.json")}), 1, {"none/s.json: cannot write"});
  expect_error(render({"-o", "/dev/full"}), 1, {"/dev/full: cannot write: No space left on device"});
  // Told before the work: the world is not even looked for.
  expect_error(run({"render", file("missing.karst"), "-o", file("none/a.png")}), 1,
               {"none/a.png: cannot write"});
  EXPECT_EQ(folder_.names(), before);
}

TEST_F(Karst, OutputFollowsLinksAndDevices) {
  folder_.write("target.png", std::string("old"));
  std::filesystem::create_symlink(file("target.png"), file("link.png"));
  EXPECT_EQ(render({"-o", file("link.png")}).code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(file("link.png")));
  EXPECT_EQ(png_size(file("target.png")).width, 64u);
  EXPECT_EQ(render({"-o", "/dev/null"}).code, 0);
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/null"));
}

TEST_F(Karst, MemoryIsRefusedBeforeItIsTaken) {
  expect_error(render({"-o", file("a.png"), "--max-memory", "1"}), 1,
               {world_ + ": needs ", "--max-memory 1.0 MiB"});
  EXPECT_EQ(folder_.names(), Names{"world.karst"});
}

TEST_F(Karst, WorldsTooLargeAreDrawnCoarserAndItIsSaid) {
  const std::string large = folder_.write("large.karst", small_world(6));
  const auto with = [&](const Names& more) {
    Names words{"render", large, "--size", "64x36", "--error-px", "0.05", "--stats", "-"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  };
  const ProcessResult roomy = with({"--vertex-memory", "100"});
  EXPECT_EQ(roomy.err, "");
  EXPECT_NE(roomy.out.find("\"flags\": []"), std::string::npos) << roomy.out;
  const ProcessResult tight = with({"--vertex-memory", "0.25"});
  EXPECT_EQ(tight.code, 0);
  EXPECT_NE(tight.out.find("\"gpu_vertex_pages\""), std::string::npos) << tight.out;
}

// Heights that find no room are read when they are needed, and the picture stays the same.
TEST_F(Karst, HeightsCanStayInTheFile) {
  const std::string large = folder_.write("large.karst", small_world(5, {40, 12, 40}));
  const Names words{"render", large, "--shadows", "0", "--size", "64x36", "--stats", "-", "-o"};
  const auto with = [&](const char* mebibytes, const char* picture) {
    Names all = words;
    all.insert(all.end(), {file(picture), "--max-memory", mebibytes});
    return run(all);
  };
  const ProcessResult roomy = with("512", "roomy.png");
  const ProcessResult tight = with("7", "tight.png");
  ASSERT_EQ(roomy.code, 0) << roomy.err;
  ASSERT_EQ(tight.code, 0) << tight.err;
  const auto cpu_budget = [](const ProcessResult& result) {
    const std::string key = json_key("cpu_budget");
    return std::stol(result.out.substr(result.out.find(key) + key.size()));
  };
  EXPECT_GT(cpu_budget(roomy), cpu_budget(tight) + (1 << 20));
  EXPECT_EQ(read_text(file("roomy.png")), read_text(file("tight.png")));
}

TEST_F(Karst, NoEglIsOneLine) {
  expect_error(render({"-o", file("a.png")}, {"__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json"}), 1,
               {"no OpenGL ES 3.0 context; tried surfaceless", "device"});
  EXPECT_EQ(folder_.names(), Names{"world.karst"});
}

TEST_F(Karst, DrawsWithTheLeastVersionOfGles) {
  EXPECT_EQ(render({"-o", file("a.png")}, {"MESA_GLES_VERSION_OVERRIDE=3.0"}).code, 0);
}

// The whole program, file to file: the world's place and size are no part of the picture.
TEST_F(Karst, PictureDoesNotDependOnPlaceAndVoxelSize) {
  ASSERT_EQ(render({"-o", file("first.png")}).code, 0);
  const std::string first = read_text(file("first.png"));
  for (const auto& [origin, size] : {std::pair(1e7, 1.0), std::pair(0.0, 1e-3), std::pair(-1e7, 1e4)}) {
    std::vector<std::byte> bytes = small_world();
    store_at<double>(bytes, world_offsets::kVoxelSize, size);
    for (std::size_t axis = 0; axis < 3; ++axis)
      store_at<double>(bytes, world_offsets::kOrigin + 8 * axis, origin);
    fix_checksums(bytes);
    const std::string moved = folder_.write("moved.karst", bytes);
    ASSERT_EQ(run({"render", moved, "--size", "64x36", "-o", file("moved.png")}).code, 0);
    EXPECT_EQ(read_text(file("moved.png")), first) << origin << ' ' << size;
  }
}

TEST_F(Karst, InfoAndBudget) {
  const ProcessResult info = run({"info", world_, "--json"});
  EXPECT_EQ(info.code, 0);
  EXPECT_NE(info.out.find("\"extent_voxels\": [\n    16,\n    12,\n    14\n  ]"), std::string::npos)
      << info.out;
  EXPECT_NE(run({"info", world_}).out.find("16 x 12 x 14 of "), std::string::npos);
  const ProcessResult budget = run({"budget", world_, "--json"});
  EXPECT_EQ(budget.code, 0);
  for (const char* key : {"gpu_vertex_pages", "heights", "vertices", "total"}) {
    EXPECT_NE(budget.out.find(json_key(key)), std::string::npos) << key;
  }
  EXPECT_NE(run({"budget"}).out.find("gpu_vertex_pages"), std::string::npos);
  // What budget says is what render uses.
  const std::string statistics = run({"render", world_, "--stats", "-"}).out;
  const auto total = [](const std::string& text, const std::string& key, std::size_t from) {
    const std::size_t at = text.find(json_key(key), from) + key.size() + 4;
    return text.substr(at, text.find_first_of(",\n", at) - at);
  };
  EXPECT_EQ(total(statistics, "cpu_used", 0), total(budget.out, "total", budget.out.find("cpu_bytes")));
  EXPECT_EQ(total(statistics, "gpu_budget", 0), total(budget.out, "total", budget.out.find("gpu_bytes")));
}

}  // namespace
}  // namespace karst::core
