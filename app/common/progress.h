// SPDX-License-Identifier: MIT
// A progress bar on stderr: drawn only on a terminal, and only for work that lasts longer than half a second.
#pragma once

#include <cstdint>
#include <string>

namespace karst::app {

class Progress {
 public:
  // label: what is done, in a word or two. total: steps of the whole work.
  Progress(std::string label, std::uint64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // done: steps finished so far. Redraws at most ten times a second, so it is cheap to call often.
  void update(std::uint64_t done);
  // Removes the bar from the terminal. The destructor does the same.
  void finish();

 private:
  std::string label_;
  std::uint64_t total_;
  std::int64_t start_ns_;
  std::int64_t next_draw_ns_;
  bool terminal_;
  bool drawn_ = false;
};

}  // namespace karst::app
