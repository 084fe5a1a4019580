// SPDX-License-Identifier: MIT
#include "tests/device/run/gtest_run.h"

#include <algorithm>
#include <set>
#include <string_view>

namespace karst::device {
namespace {

constexpr std::size_t kMostMessage = 2000;  // characters kept of a test's output: the last ones
constexpr int kMostRestarts = 25;           // a driver that fails more often is not worth more time

// Names of --gtest_list_tests: "Suite." lines, and below each "  Test  # parameter" lines.
class Listing {
 public:
  void take(std::string_view line) {
    const std::string_view word = line.substr(0, line.find("  #"));
    if (word.starts_with("  ") && !suite_.empty()) {
      const std::string name = suite_ + std::string(word.substr(2));
      if (name.find("DISABLED_") == std::string::npos) names.push_back(name);
    } else {
      suite_ = word.ends_with('.') && word.find(' ') == std::string_view::npos ? word : "";
    }
  }
  std::vector<std::string> names;

 private:
  std::string suite_;
};

// Follows the lines of a run. A test's own output may stand before GoogleTest's marks on their lines.
class Follower {
 public:
  Follower(GtestResult& result, std::size_t all, const OnTest& on_test)
      : result_(result), all_(all), on_test_(on_test) {}

  void take(std::string_view line) {
    if (line.starts_with("[ RUN      ] ")) {
      running_ = line.substr(13);
      output_.clear();
      if (on_test_) on_test_(running_, done.size(), all_);
    } else if (running_.empty()) {
      return;
    } else if (ends(line, "[       OK ] ")) {
      result_.passed.push_back(running_);
      finish();
    } else if (ends(line, "[  FAILED  ] ")) {
      result_.failed.push_back({running_, output_});
      finish();
    } else if (ends(line, "[  SKIPPED ] ")) {
      result_.skipped.push_back({running_, output_});
      finish();
    } else {
      output_.append(line).append("\n");
      if (output_.size() > kMostMessage) output_.erase(0, output_.size() - kMostMessage);
    }
  }
  // The program ended: the test that ran just then has failed. Whether there was one.
  bool end(const std::string& how) {
    if (running_.empty()) return false;
    result_.failed.push_back({running_, how + "\n" + output_});
    finish();
    return true;
  }
  std::set<std::string> done;

 private:
  bool ends(std::string_view line, std::string_view mark) {
    const std::size_t at = line.find(std::string(mark) + running_);
    if (at == std::string_view::npos) return false;
    output_.append(line.substr(0, at));
    return true;
  }
  void finish() {
    done.insert(running_);
    running_.clear();
  }

  GtestResult& result_;
  std::size_t all_;
  const OnTest& on_test_;
  std::string running_;  // empty: none
  std::string output_;
};

std::string only(const std::vector<std::string>& names) {
  std::string filter = "--gtest_filter=";
  for (const std::string& name : names) filter += name + ":";
  return filter;
}

}  // namespace

GtestResult run_gtest(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                      const ChildLimits& limits, const OnTest& on_test) {
  GtestResult result;
  Listing listing;
  std::vector<std::string> list_words = words;
  list_words.push_back("--gtest_list_tests");
  std::string last_line;
  const ChildResult listed = run_child(list_words, environment, limits, [&](std::string_view line) {
    listing.take(line);
    last_line = line;
  });
  if (!listed.ok() || listing.names.empty()) {
    result.problem = listed.ok() ? "it has no such tests" : how_it_ended(listed) + ": " + last_line;
    return result;
  }
  Follower follower(result, listing.names.size(), on_test);
  std::vector<std::string> rest = listing.names;
  for (int round = 0; !rest.empty() && result.problem.empty(); ++round) {
    std::vector<std::string> run_words = words;
    run_words.push_back(only(rest));
    run_words.push_back("--gtest_color=no");
    const ChildResult ended =
        run_child(run_words, environment, limits, [&](std::string_view line) { follower.take(line); });
    result.seconds += ended.seconds;
    result.peak_bytes = std::max(result.peak_bytes, ended.peak_bytes);
    const std::string how = how_it_ended(ended);
    const bool in_a_test = follower.end(how);
    const std::size_t before = rest.size();
    std::erase_if(rest, [&](const std::string& name) { return follower.done.contains(name); });
    if (ended.end == ChildResult::End::interrupted) {
      result.problem = how;
    } else if (rest.empty()) {
      if (!in_a_test && !ended.ok() && result.failed.empty()) result.problem = how + " after its last test";
    } else if (rest.size() == before || round == kMostRestarts) {
      result.problem = (how.empty() ? "it ended" : how) + " before its tests were run";
    }
  }
  result.not_run = rest;
  return result;
}

}  // namespace karst::device
