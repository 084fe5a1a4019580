// SPDX-License-Identifier: MIT
// The tables of options: how they are read, and that programs, help, man pages and completion have all of
// them.
#include <array>
#include <cstdlib>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/command_line/command_line.h"
#include "app/command_line/help.h"
#include "app/command_line/manual.h"
#include "app/options/scene_options.h"
#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::app {
namespace {

using Words = std::vector<std::string>;

struct Drawing {
  double x = 0;
  std::string file;
  int mode = 0;
  int width = 0;
  bool quiet = false;
  bool loud = true;
};
Error store_width(void* options, const OptionValue& value) {
  static_cast<Drawing*>(options)->width = value.width;
  return {};
}
constexpr OptionRow kRows[] = {
    {.name = "x",
     .kind = ValueKind::number,
     .min = -1,
     .max = 1,
     .help = "how far",
     .store = put<&Drawing::x>},
    {.name = "file", .letter = 'f', .kind = ValueKind::file, .value = "FILE", .store = put<&Drawing::file>},
    {.name = "mode", .kind = ValueKind::word, .words = "a bb ccc", .store = put<&Drawing::mode>},
    {.name = "size", .kind = ValueKind::size, .max = 100, .store = store_width},
    {.name = "quiet", .letter = 'q', .store = put<&Drawing::quiet>},
    {.name = "not-loud", .store = put_false<&Drawing::loud>}};
constexpr OptionGroup kGroups[] = {{"drawing", kRows}};
constexpr OptionPart kParts[] = {kGroups};
constexpr CommandSpec kDraw = {"draw", "draws",   "FILE\n--quiet", "Draws. .Dots - and dashes.",
                               kParts, "draw x\n"};

std::string read(const std::vector<const char*>& words, Drawing& drawing, CommandLine& line) {
  if (Error error = line.parse(words, kDraw); !error.ok()) return error.text();
  void* const targets[] = {&drawing};
  return line.store(targets).text();
}

TEST(CommandLine, ValuesMayBeNegativeAndOptionsEnd) {
  Drawing drawing;
  CommandLine line;
  ASSERT_EQ(read({"-f", "-1,-2", "--quiet", "--x=-.5", "--mode", "ccc", "--size", "7x9", "--not-loud", "-7",
                  "--", "--x"},
                 drawing, line),
            "");
  EXPECT_EQ(drawing.file, "-1,-2");
  EXPECT_TRUE(drawing.quiet);
  EXPECT_FALSE(drawing.loud);
  EXPECT_EQ(drawing.x, -.5);
  EXPECT_EQ(drawing.mode, 2);
  EXPECT_EQ(drawing.width, 7);
  ASSERT_EQ(line.positional().size(), 2u);
  EXPECT_EQ(line.positional()[0], "-7");
  EXPECT_EQ(line.positional()[1], "--x");
  EXPECT_TRUE(line.has("quiet"));
  EXPECT_FALSE(line.wants_help());
}

TEST(CommandLine, WrongWordsAreTold) {
  const auto error = [](const std::vector<const char*>& words) {
    Drawing drawing;
    CommandLine line;
    return read(words, drawing, line);
  };
  EXPECT_EQ(error({"--y"}), "unknown option '--y'");
  EXPECT_EQ(error({"-x", "1"}), "unknown option '-x'");
  EXPECT_EQ(error({"--x"}), "option '--x' needs a value");
  EXPECT_EQ(error({"--x", "--quiet"}), "option '--x' needs a value, not '--quiet'");
  EXPECT_EQ(error({"-q", "--quiet"}), "option '--quiet' is given twice");
  EXPECT_EQ(error({"--quiet=1"}), "option '--quiet' takes no value");
  EXPECT_EQ(error({"--x", "2"}), "--x: 2 is not in -1 to 1");
  EXPECT_EQ(error({"--file="}), "--file: the file name is empty");
  EXPECT_EQ(error({"--mode", "b"}), "--mode: 'b' is not one of a bb ccc");
  EXPECT_EQ(error({"--size", "101x1"}), "--size: 101 is not in 1 to 100");
}

TEST(CommandLine, HelpAndManualAreMadeFromTheTable) {
  const std::string help = help_text(kDraw);
  EXPECT_EQ(help.rfind("usage: draw FILE\n       draw --quiet\n", 0), 0u) << help;
  EXPECT_NE(help.find("  -f, --file FILE"), std::string::npos) << help;
  EXPECT_NE(help.find("how far, -1 to 1\n"), std::string::npos) << help;
  EXPECT_NE(help.find("\n  draw x\n"), std::string::npos) << help;
  const CommandSpec* const commands[] = {&kDraw};
  const std::string page = man_page({"draw", "draws", "", commands}, kDraw);
  EXPECT_NE(page.find("Draws. .Dots \\- and dashes."), std::string::npos) << page;
  EXPECT_NE(page.find("\\fB\\-f\\fR, \\fB\\-\\-file\\fR \\fIFILE\\fR"), std::string::npos) << page;
}

// An option of a scene, a value of it, and what is then stored.
struct SceneCase {
  const char* name;
  const char* value;
  bool (*is_stored)(const SceneArguments& scene);
  const char* suite;  // of karst-bench that takes it
};
using Scene = const SceneArguments&;
constexpr SceneCase kCases[] = {
    {"board", "tiny", [](Scene s) { return s.level == 2 && s.width == 320 && s.shadows == 0; }, "pareto"},
    {"size", "64x36", [](Scene s) { return s.width == 64 && s.height == 36; }, "pareto"},
    {"sun", "10,20", [](Scene s) { return s.sun_azimuth_deg == 10 && s.sun_elevation_deg == 20; }, "pareto"},
    {"fov", "50", [](Scene s) { return s.fov_y_deg == 50; }, "pareto"},
    {"haze", "99", [](Scene s) { return s.haze_voxels == 99; }, "pareto"},
    {"show", "levels", [](Scene s) { return s.show == ShowChoice::levels; }, "pareto"},
    {"antialias", "msaa4", [](Scene s) { return s.antialias == Antialias::msaa4; }, "pareto"},
    {"detail", "high", [](Scene s) { return s.detail == DetailChoice::high; }, "pareto"},
    {"anisotropy", "8", [](Scene s) { return s.anisotropy == 8; }, "pareto"},
    {"shading", "forward", [](Scene s) { return s.shading == ShadingChoice::forward; }, "pareto"},
    {"precision", "high", [](Scene s) { return s.precision == PrecisionChoice::high; }, "pareto"},
    {"no-skip", "backface,cave", [](Scene s) { return s.drawn_anyway == (1u << 1 | 1u << 9); }, "pareto"},
    {"lod", "full", [](Scene s) { return s.lod == LodChoice::full; }, "shadows"},
    {"error-px", "2", [](Scene s) { return s.error_px == 2; }, "shadows"},
    {"lod-distance", "32", [](Scene s) { return s.lod_distance_voxels == 32; }, "shadows"},
    {"level", "1", [](Scene s) { return s.level == 1; }, "pareto"},
    {"generate-ms", "3", [](Scene s) { return s.generate_ms == 3; }, "pareto"},
    {"vertex-memory", "2.5", [](Scene s) { return s.vertex_bytes == 2621440; }, "pareto"},
    {"max-memory", "64", [](Scene s) { return s.max_memory == 64u << 20; }, "pareto"},
    {"shadows", "1", [](Scene s) { return s.shadows == 1; }, "pareto"},
    {"shadow-size", "528", [](Scene s) { return s.shadow_size == 528; }, "pareto"},
    {"shadow-reach", "99", [](Scene s) { return s.shadow_reach_voxels == 99; }, "pareto"},
    {"drape", "a.png", [](Scene s) { return s.drape == "a.png"; }, "pareto"},
    {"drape-repeat", "2", [](Scene s) { return s.drape_repeat == 2; }, "pareto"},
};

TEST(SceneOptions, EachIsStored) {
  std::set<std::string> in_table;
  for (const OptionGroup& group : kSceneGroups) {
    for (const OptionRow& row : group.rows) in_table.insert(row.name);
  }
  static constexpr OptionPart kSceneParts[] = {kSceneGroups};
  constexpr CommandSpec kSpec = {"scene", "", "", "", kSceneParts, ""};
  for (const SceneCase& c : kCases) {
    SceneArguments scene;
    EXPECT_FALSE(c.is_stored(scene)) << c.name;
    const std::string option = std::string("--") + c.name;
    const std::array<const char*, 2> words = {option.c_str(), c.value};
    CommandLine line;
    void* const targets[] = {&scene};
    ASSERT_EQ(line.parse(words, kSpec).text(), "");
    EXPECT_EQ(line.store(targets).text(), "");
    EXPECT_TRUE(c.is_stored(scene)) << c.name;
    in_table.erase(c.name);
  }
  EXPECT_TRUE(in_table.empty()) << *in_table.begin() << " is not tested";
}

// Programs on a world of flat ground.
class Options : public testing::Test {
 protected:
  void SetUp() override {
    test::TestWorld world({16, 12, 14}, [](glm::ivec3 v) { return v.y < 5; });
    world_ = folder_.write("world.karst", world.file());
    ASSERT_EQ(karst({"render", world_, "--size", "16x16", "-o", file("a.png")}).code, 0);
  }
  static test::ProcessResult karst(const Words& words) { return test::run_process(KARST_APP_PATH, words); }
  std::string file(const std::string& name) const { return folder_.path(name); }

  // The option of a case as a program is given it.
  Words words_of(const SceneCase& c) const {
    const std::string name = c.name;
    Words words = {"--" + name, name == "drape" ? file("a.png") : c.value};
    if (name == "drape-repeat") words.insert(words.end(), {"--drape", file("a.png")});
    if (name != "size" && name != "board") words.insert(words.end(), {"--size", "32x18"});
    return words;
  }

  test::Folder folder_;
  std::string world_;
};

TEST_F(Options, RenderViewAndBenchTakeAllOfAScene) {
  for (const SceneCase& c : kCases) {
    const auto run = [&](const char* program, Words words) {
      const Words option = words_of(c);
      words.insert(words.end(), option.begin(), option.end());
      const test::ProcessResult result = test::run_process(program, words);
      EXPECT_EQ(result.code, 0) << c.name << ": " << result.err;
      EXPECT_EQ(result.err, "") << c.name;
    };
    run(KARST_APP_PATH, {"render", world_, "--stats", "-"});
    run(KARST_APP_PATH, {"view", world_, "--headless", "--frames", "1"});
    Words bench = {world_, "--suite", c.suite, "--frames", "2"};
    if (std::string(c.suite) == "pareto") {
      bench.insert(bench.end(), {"--no-errors", "--targets", "4", "--distances", "none"});
    }
    run(KARST_BENCH_PATH, bench);
  }
}

TEST_F(Options, SuitesRefuseWhatTheyHaveNoUseFor) {
  const auto error = [&](const Words& words) {
    Words all = {world_};
    all.insert(all.end(), words.begin(), words.end());
    const test::ProcessResult result = test::run_process(KARST_BENCH_PATH, all);
    EXPECT_EQ(result.code, 2);
    return result.err;
  };
  EXPECT_EQ(error({"--size", "64x36"}), "karst-bench: --size: the suite core has no use for it\n");
  EXPECT_EQ(error({"--suite", "pareto", "--lod", "full"}),
            "karst-bench: --lod: the suite pareto has no use for it\n");
  EXPECT_EQ(error({"--suite", "shadows", "--shadows", "0"}),
            "karst-bench: nothing to measure: there are no shadow maps\n");
}

// A program, what prints its pages, and its commands.
struct Manual {
  const char* program;
  Words ask;
  std::string name;
  std::vector<Words> commands;
};

std::vector<Manual> manuals() {
  std::vector<Manual> all = {{KARST_MANUAL_PATH, {}, "karst", {{"view"}, {"render"}, {"info"}, {"budget"}}},
                             {KARST_BENCH_PATH, {"--print-manual"}, "karst-bench", {{}}}};
#ifdef KARST_BAKE_PATH
  all.push_back({KARST_BAKE_PATH, {"--print-manual"}, "karst-bake", {{}}});
#endif
  return all;
}

// Options in a text of --help, each at the begin of its line.
std::set<std::string> options_in(const std::string& help) {
  std::set<std::string> names;
  for (std::size_t line = 0; line < help.size(); line = help.find('\n', line) + 1) {
    if (help.compare(line, 2, "  ") != 0 || help.compare(line + 6, 2, "--") != 0) continue;
    names.insert(help.substr(line + 6, help.find_first_of(" \n", line + 6) - line - 6));
  }
  return names;
}

TEST_F(Options, ManualsAndCompletionNameEveryOption) {
  for (const Manual& manual : manuals()) {
    Words ask = manual.ask;
    ask.emplace_back("completion");
    const std::string completion = test::run_process(manual.program, ask).out;
    EXPECT_NE(completion.find("complete -F _"), std::string::npos);
    folder_.write("completion", completion);
    EXPECT_EQ(test::run_process("/bin/bash", {"-n", file("completion")}).err, "") << manual.name;
    for (const Words& command : manual.commands) {
      ask = manual.ask;
      ask.insert(ask.end(), {"man", command.empty() ? manual.name : manual.name + "-" + command[0]});
      const std::string page = test::run_process(manual.program, ask).out;
      EXPECT_NE(page.find(".SH OPTIONS\n"), std::string::npos);
      Words help = command;
      help.emplace_back("--help");
      const char* program = manual.name == "karst" ? KARST_APP_PATH : manual.program;
      const std::set<std::string> names = options_in(test::run_process(program, help).out);
      EXPECT_GE(names.size(), 2u);
      for (const std::string& name : names) {
        std::string roff;
        for (const char c : name) roff += c == '-' ? "\\-" : std::string(1, c);
        EXPECT_NE(page.find("\\fB" + roff + "\\fR"), std::string::npos) << manual.name << " " << name;
        // What bash offers behind the command.
        std::string script = ". " + file("completion") + "; COMP_WORDS=(" + manual.name + " ";
        script += (command.empty() ? "" : command[0]) + " " + name + "); COMP_CWORD=";
        script += (command.empty() ? "1" : "2");
        script +=
            "; compopt() { :; }; _" + (manual.name == "karst" ? "karst" : "karst_" + manual.name.substr(6));
        const test::ProcessResult offered =
            test::run_process("/bin/bash", {"-c", script + "; printf '%s\\n' \"${COMPREPLY[@]}\""});
        EXPECT_NE(("\n" + offered.out).find("\n" + name + "\n"), std::string::npos)
            << manual.name << " " << name;
      }
    }
  }
}

TEST_F(Options, WordsOfOptionsAreExplained) {
  for (const OptionGroup& group : kSceneGroups) {
    for (const OptionRow& row : group.rows) {
      EXPECT_NE(std::string(row.help) + (row.unit != nullptr ? row.unit : ""), "") << row.name;
      std::string words = row.words != nullptr ? row.words : "";
      for (std::size_t end; !words.empty(); words.erase(0, end == std::string::npos ? end : end + 1)) {
        end = words.find(' ');
        EXPECT_NE(std::string(row.help).find(words.substr(0, end)), std::string::npos) << row.name;
      }
    }
  }
}

TEST_F(Options, ProgramsTellTheirVersion) {
  EXPECT_EQ(test::run_process(KARST_BENCH_PATH, {"--version"}).out, "karst-bench " KARST_VERSION "\n");
#ifdef KARST_BAKE_PATH
  EXPECT_EQ(test::run_process(KARST_BAKE_PATH, {"--version"}).out, "karst-bake " KARST_VERSION "\n");
#endif
}

TEST_F(Options, DashesEndTheOptions) {
  folder_.write("--size.karst", test::read_text(world_));
  const test::ProcessResult result = test::run_process(
      "/bin/sh", {"-c", "cd " + folder_.path("") + " && " + KARST_APP_PATH + " info -- --size.karst"});
  EXPECT_EQ(result.code, 0) << result.err;
}

// --- cameras and the ground

// Metres that a camera is below the ground, as it is said; -1: it is not.
double depth_said(const std::string& err) {
  const std::string before = "the camera is inside rock, ";
  const std::size_t at = err.find(before);
  return at == std::string::npos ? -1 : std::strtod(err.c_str() + at + before.size(), nullptr);
}

TEST_F(Options, HeightsCountFromTheGround) {
  const auto render = [&](const std::string& camera, const char* picture) {
    return karst({"render", world_, "--size", "64x36", "-o", file(picture), "--camera", camera});
  };
  const test::ProcessResult low = render("8,2,7,20,-10", "low.png");
  EXPECT_EQ(low.code, 0);
  const double ground = 2 + depth_said(low.err);
  ASSERT_GT(ground, 4) << low.err;
  EXPECT_EQ(render("8,~3,7,20,-10", "up.png").err, "");
  EXPECT_EQ(render("8," + std::to_string(ground + 3) + ",7,20,-10", "same.png").err, "");
  EXPECT_EQ(test::read_text(file("up.png")), test::read_text(file("same.png")));
  EXPECT_NEAR(depth_said(render("8,~-1,7,20,-10", "below.png").err), 1, 1e-3);
  const test::ProcessResult away = render("800,~2,7,20,-10", "none.png");
  EXPECT_EQ(away.code, 1);
  EXPECT_EQ(away.err, "karst render: --camera: there is no ground at 800,7 to stand on\n");
  EXPECT_EQ(render("8,~,7,20,-10", "none.png").err, "karst render: --camera: '~' is not a number\n");
  EXPECT_EQ(render("~8,2,7,20,-10", "none.png").code, 2);
}

TEST_F(Options, RockIsToldOnce) {
  const std::string path = folder_.write("path.txt", "8 ~2 7 0 0\n8 2 7 0 0\n8 1 7 0 0\n");
  const test::ProcessResult render =
      karst({"render", world_, "--size", "32x18", "--path", path, "--stats", "-"});
  EXPECT_EQ(render.code, 0);
  EXPECT_EQ(render.err.rfind("karst render: " + path + ": frame 1: the camera is inside rock, ", 0), 0u)
      << render.err;
  EXPECT_EQ(render.err.find("frame 2"), std::string::npos) << render.err;
  const auto view = [&](const std::string& camera) {
    return karst({"view", world_, "--headless", "--size", "32x18", "--frames", "3", "--camera", camera}).err;
  };
  EXPECT_GT(depth_said(view("8,2,7,0,0")), 1);
  EXPECT_EQ(view("8,~2,7,0,0"), "");
  EXPECT_EQ(view("800,~2,7,0,0"), "karst view: --camera: there is no ground at 800,7 to stand on\n");
}

TEST_F(Options, PosesStandOnTheGround) {
  const auto frames = [&](const std::string& pose) {
    const test::ProcessResult result = test::run_process(
        "/bin/sh", {"-c", "echo '" + pose + "' | " + KARST_APP_PATH + " view " + world_ +
                              " --headless --size 32x18 --frames 30 --poses - --stats " + file("s.json")});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_NE(test::read_text(file("s.json")).find("\"taken\": 1"), std::string::npos);
    return result.err;
  };
  EXPECT_EQ(frames("8 ~2 7 0 0"), "");
  EXPECT_EQ(frames("800 ~2 7 0 0"), "karst view: --poses: there is no ground at 800,7 to stand on\n");
}

}  // namespace
}  // namespace karst::app
