// SPDX-License-Identifier: MIT
// What a program that runs for months tells: a burst of lines, then a few a second, and how many were left
// out. All its messages go through one of these, so that no flood of anything fills a journal. What others
// send gets a small part of the burst, so that it never hides what the program has to say itself.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace karst::app {

class Messages {
 public:
  static constexpr int kBurst = 400;                         // lines that may come at once
  static constexpr int kBurstOfOthers = 20;                  // of them, about what others send
  static constexpr std::int64_t kInterval_ns = 200'000'000;  // between two after that: five a second
  enum class About { own, others };

  using Print = std::function<void(const std::string& line)>;
  explicit Messages(Print print) : print_(std::move(print)) {}

  // Whether a line may be printed now; it is then taken for printed. Else it counts as left out. Callers that
  // would have to put their line together ask first and print() it then.
  bool may_say(std::int64_t now_ns, About about = About::own);
  void print(const std::string& line) const { print_(line); }
  void say(const std::string& line, std::int64_t now_ns) {
    if (may_say(now_ns)) print(line);
  }

 private:
  Print print_;
  int left_ = kBurst;
  std::int64_t filled_at_ns_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace karst::app
