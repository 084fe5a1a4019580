// SPDX-License-Identifier: MIT
#include "tests/device/run/session.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <deque>
#include <filesystem>
#include <utility>

#include "app/files/atomic_file.h"
#include "tests/device/machine/probe.h"
#include "tests/device/run/gtest_run.h"
#include "tests/golden/cases.h"
#include "tests/support/process.h"

namespace karst::device {
namespace {

constexpr int kFormat = 1;
constexpr double kOthersLonger = 3;  // than a test may be silent: what other parts may take, who say nothing
constexpr std::size_t kMostOutput = 60;  // lines kept of a program's output: the last ones

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

double rounded(double value, double steps) {
  return static_cast<double>(static_cast<std::int64_t>(value * steps + 0.5)) / steps;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; !from.empty() && (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

class Session {
 public:
  explicit Session(const SessionOptions& options) : options_(options) {
    environment_ = {"KARST_APP_PATH=" + path("bin/karst"), "KARST_WORLDS=" + path("worlds"),
                    "KARST_GOLDEN_IMAGES=" + path("pictures")};
    others_.silence_s = others_.total_s = kOthersLonger * options.limits.silence_s;
  }

  Error run(SessionEnd& end) {
    if (Error error = app::check_writable(options_.json); !error.ok()) return error;
    begin();
    if (Error error = write(); !error.ok()) return error;
    probe();
    std::size_t number = 0;
    const auto count = static_cast<std::size_t>(
        std::count_if(options_.parts.begin(), options_.parts.end(),
                      [](const Part& part) { return part.kind != PartKind::world; }));
    for (const Part& part : options_.parts) {
      if (part.kind == PartKind::world || interrupted()) continue;
      title_ = "[" + std::to_string(++number) + "/" + std::to_string(count) + "] " +
               kPartKinds[static_cast<std::size_t>(part.kind)] + " " + part.name;
      run_part(part);
      if (Error error = write(); !error.ok()) return error;
    }
    end.complete = !interrupted();
    end.good = end.complete && json_["failures"].empty();
    json_["complete"] = end.complete;
    json_["machine"]["load_after"] = probe_machine()["load"];
    return write();
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::string path(const std::string& name) const { return options_.folder + "/" + name; }
  std::string world(const std::string& name) const { return path("worlds/" + name + ".karst"); }

  // Files of the folder are written "@/pictures/canyon.png".
  std::string placed(const std::string& word) const {
    return word.starts_with("@/") ? path(word.substr(2)) : word;
  }

  void begin() {
    start_ = Clock::now();
    std::string commit = test::read_text(path("commit"));
    commit.erase(std::remove(commit.begin(), commit.end(), '\n'), commit.end());
    json_ = {{"format", kFormat},         {"karst", {{"version", KARST_VERSION}, {"commit", commit}}},
             {"date", now_utc()},         {"plan", options_.plan},
             {"complete", false},         {"seconds", 0},
             {"failures", Json::array()}, {"machine", probe_machine()},
             {"device", nullptr},         {"parts", Json::array()},
             {"tests", Json::object()},   {"pictures", Json::array()},
             {"frames", Json::array()},   {"programs", Json::array()}};
  }

  Error write() {
    json_["seconds"] = rounded(std::chrono::duration<double>(Clock::now() - start_).count(), 10);
    // Tests may print bytes that are no UTF-8.
    const std::string text = json_.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    return app::write_file_atomic(options_.json, std::as_bytes(std::span(text)));
  }

  // Without the paths of this machine and of the one that built the programs.
  std::string plain(std::string text) const {
    replace_all(text, options_.folder + "/", "");
    replace_all(text, KARST_SOURCE_DIR "/", "");
    return text;
  }

  void probe() {
    title_ = "device";
    std::string text;
    const ChildResult result = run_child({options_.self, "probe"}, environment_, others_,
                                         [&](std::string_view line) { text.append(line).append("\n"); });
    Json device = Json::parse(text, nullptr, false);
    if (result.ok() && device.is_object()) {
      json_["device"] = std::move(device);
      say(json_["device"]["gl"]["renderer"].get<std::string>() + ", " +
          json_["device"]["gl"]["version"].get<std::string>());
    } else {
      fail(problem_of(result, text.substr(0, text.find('\n'))));
    }
  }

  void run_part(const Part& part) {
    std::fprintf(stderr, "%s ...%s", title_.c_str(), terminal_ ? "" : "\n");
    const Clock::time_point begin = Clock::now();
    const std::size_t failures = json_["failures"].size();
    if (part.kind == PartKind::tests) run_tests(part);
    if (part.kind == PartKind::pictures) run_pictures(part);
    if (part.kind == PartKind::frames) run_frames(part);
    if (part.kind == PartKind::program) run_program(part);
    json_["parts"].push_back(
        {{"kind", kPartKinds[static_cast<std::size_t>(part.kind)]},
         {"name", part.name},
         {"words", part.words},
         {"ok", json_["failures"].size() == failures},
         {"seconds", rounded(std::chrono::duration<double>(Clock::now() - begin).count(), 10)}});
  }

  // What became of a child that did not do what it should; last: what it printed last.
  std::string problem_of(const ChildResult& result, const std::string& last) const {
    const std::string how = result.ok() ? "its result is not there" : how_it_ended(result);
    return last.empty() ? how : how + ": " + plain(last);
  }

  void say(const std::string& text) const {
    std::fprintf(stderr, "%s%s: %s\n", terminal_ ? "\r\033[K" : "", title_.c_str(), text.c_str());
  }
  void fail(const std::string& text) {
    const std::size_t bracket = title_.find("] ");
    const std::string what = bracket == std::string::npos ? title_ : title_.substr(bracket + 2);
    json_["failures"].push_back(what + ": " + text);
    say("FAILED: " + text);
  }
  void show(const std::string& text) const {
    if (terminal_) std::fprintf(stderr, "\r\033[K%s ... %.60s", title_.c_str(), text.c_str());
  }

  void run_tests(const Part& part) {
    std::vector<std::string> words = part.words;
    words[0] = path("bin/" + words[0]);
    const GtestResult result =
        run_gtest(words, environment_, options_.limits,
                  [&](const std::string& test, std::size_t done, std::size_t all) {
                    show(std::to_string(done) + " of " + std::to_string(all) + ", " + test);
                  });
    const auto noted = [&](const std::vector<NotedTest>& tests) {
      Json list = Json::array();
      for (const NotedTest& test : tests)
        list.push_back({{"name", test.name}, {"message", plain(test.message)}});
      return list;
    };
    json_["tests"][part.name] = {{"program", part.words[0]},
                                 {"passed", result.passed},
                                 {"failed", noted(result.failed)},
                                 {"skipped", noted(result.skipped)},
                                 {"not_run", result.not_run},
                                 {"problem", plain(result.problem)},
                                 {"process_peak_bytes", result.peak_bytes}};
    std::string summary = std::to_string(result.passed.size()) + " passed, " +
                          std::to_string(result.failed.size()) + " failed, " +
                          std::to_string(result.skipped.size()) + " skipped";
    if (!result.not_run.empty()) summary += ", " + std::to_string(result.not_run.size()) + " not run";
    if (!result.problem.empty()) summary += "; " + plain(result.problem);
    result.ok() ? say(summary) : fail(summary);
  }

  void run_pictures(const Part& part) {
    std::size_t drawn = 0, same = 0, different = 0;
    for (const test::GoldenWorld& golden : test::kGoldenWorlds) {
      for (const test::GoldenView& view : golden.views) {
        const bool all = part.words[0] == "all";
        const bool wanted =
            all || std::find(part.words.begin(), part.words.end(), view.picture) != part.words.end();
        if (!wanted || interrupted()) continue;
        // The elevation model of one is not everywhere where karst is built.
        if (all && !std::filesystem::exists(world(golden.name))) continue;
        show(view.picture);
        const Json picture = draw_and_compare(golden, view);
        const std::string result = picture["result"];
        ++drawn;
        if (result == "same") ++same;
        if (result == "different" || result == "not drawn") ++different;
        json_["pictures"].push_back(picture);
      }
    }
    const std::string summary = std::to_string(drawn) + " drawn, " + std::to_string(same) + " the same, " +
                                std::to_string(different) + " different or not drawn";
    const bool ok = different == 0 && drawn > 0 && (part.words[0] == "all" || drawn == part.words.size());
    ok ? say(summary) : fail(summary);
  }

  Json draw_and_compare(const test::GoldenWorld& golden, const test::GoldenView& view) {
    const std::string name = std::string(view.picture) + ".png";
    const std::string drawn = scratch_.path(name);
    std::vector<std::string> words = test::golden_words(world(golden.name), view, drawn);
    words.insert(words.begin(), path("bin/karst"));
    Json picture = {{"name", view.picture}};
    std::string last;
    const ChildResult result =
        run_child(words, environment_, others_, [&](std::string_view line) { last = line; });
    const test::RgbPicture actual = test::read_png(drawn);
    const test::RgbPicture stored = test::read_png(path("pictures/" + name));
    if (!result.ok() || actual.rgb.empty() || actual.rgb.size() != stored.rgb.size()) {
      picture["result"] = "not drawn";
      picture["message"] = stored.rgb.empty() ? "there is no stored picture" : problem_of(result, last);
      return picture;
    }
    const test::Difference difference = test::compare(actual, stored);
    picture["result"] = difference.largest == 0          ? "same"
                        : test::close_enough(difference) ? "close"
                                                         : "different";
    picture["mean"] = difference.mean;
    picture["max"] = difference.largest;
    picture["far_apart"] = difference.far_apart;
    if (difference.largest > 0 && !options_.keep.empty()) {
      std::error_code ignored;
      std::filesystem::create_directories(options_.keep, ignored);
      std::filesystem::copy_file(drawn, options_.keep + "/" + name,
                                 std::filesystem::copy_options::overwrite_existing, ignored);
    }
    return picture;
  }

  void run_frames(const Part& part) {
    const std::string file = scratch_.path("frames.json");
    std::filesystem::remove(file);
    std::vector<std::string> words = {path("bin/karst-bench"), world(part.words[0]), "--suite", "frames"};
    words.insert(words.end(), {"--json", file});
    for (std::size_t n = 1; n < part.words.size(); ++n) words.push_back(placed(part.words[n]));
    std::string last;
    const ChildResult result =
        run_child(words, environment_, others_, [&](std::string_view line) { last = line; });
    Json frames = Json::parse(test::read_text(file), nullptr, false);
    if (!result.ok() || !frames.is_object()) {
      fail(problem_of(result, last));
      return;
    }
    Json entry = {{"way", part.name},
                  {"world", part.words[0]},
                  {"options", std::vector<std::string>(part.words.begin() + 1, part.words.end())}};
    entry.update(frames);
    entry["world"] = part.words[0];
    std::string summary;
    for (const Json& flight : frames["flights"]) {
      char text[64];
      std::snprintf(text, sizeof text, "%s%s %.1f ms", summary.empty() ? "" : ", ",
                    flight["name"].get<std::string>().c_str(), flight["frame_ms"]["median"].get<double>());
      summary += text;
    }
    json_["frames"].push_back(std::move(entry));
    say(summary);
  }

  void run_program(const Part& part) {
    std::vector<std::string> words = part.words;
    words[0] = path("bin/" + words[0]);
    std::deque<std::string> output;
    const ChildResult result = run_child(words, environment_, others_, [&](std::string_view line) {
      output.emplace_back(plain(std::string(line)));
      if (output.size() > kMostOutput) output.pop_front();
    });
    json_["programs"].push_back({{"name", part.name},
                                 {"words", part.words},
                                 {"end", how_it_ended(result)},
                                 {"process_peak_bytes", result.peak_bytes},
                                 {"output", output}});
    result.ok() ? say("done") : fail(problem_of(result, output.empty() ? "" : output.back()));
  }

  const SessionOptions& options_;
  std::vector<std::string> environment_;
  ChildLimits others_;  // of all but tests
  test::Folder scratch_;
  Json json_;
  std::string title_;  // of the part that runs
  Clock::time_point start_;
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
};

}  // namespace

Error run_session(const SessionOptions& options, SessionEnd& end) {
  return Session(options).run(end);
}

}  // namespace karst::device
