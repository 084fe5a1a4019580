// SPDX-License-Identifier: MIT
// karst view as a process on a card made of nothing (fake/fake_kms.cpp).
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace karst::test {

struct ScanOut {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // rows from the top
};

class FakeScreen {
 public:
  FakeScreen();
  ~FakeScreen();
  FakeScreen(const FakeScreen&) = delete;
  FakeScreen& operator=(const FakeScreen&) = delete;

  // Words of KARST_FAKE_STATE; takes effect with the next call of the program.
  void set(const std::string& words);
  // The kernel's word that something has changed.
  void tell() const;
  // Starts karst view WORLD with these words. fail: KARST_FAKE_FAIL. input: its standard input, below 0:
  // none.
  void start(std::vector<std::string> words, const std::string& fail = "", bool supervise = false,
             int input = -1);
  // Until the messages hold the text so often; false where that takes longer.
  bool wait_for(const std::string& text, int times = 1, double seconds = 10);
  // Waits for the end; -1 where it does not come in time (the program is killed then).
  int wait(double seconds = 10);
  // Whether it ends in this time; wait() is still to be called.
  bool ends_within(double seconds) const;
  // Until it takes signals instead of being ended by them.
  bool listens() const;
  // Ends it by a signal, and waits.
  int stop(int signal_number = 15);
  void send(int signal_number) const;
  pid_t pid() const { return pid_; }

  std::string messages() const;
  ScanOut scan_out() const;
  // The statistics, written anew at SIGHUP.
  std::string statistics();
  long calls() const;
  const Folder& folder() const { return folder_; }
  const std::string& world() const { return world_; }
  // What karst render draws of the world at this size.
  ScanOut rendered(int width, int height, const std::vector<std::string>& more = {}) const;

 private:
  Folder folder_;
  std::string world_;
  pid_t pid_ = -1;
  int uevent_ = -1;
};

// Seconds of a clock that is never set back.
double seconds_now();
// Largest difference of a colour channel; 256 where the sizes differ.
int largest_difference(const ScanOut& a, const ScanOut& b);
// The picture turned counter-clockwise.
ScanOut turned_left(const ScanOut& picture, int quarter_turns);

// "frames" of a statistics text and so on: the number behind the first "name":.
double number_of(const std::string& json, const std::string& name);

}  // namespace karst::test
