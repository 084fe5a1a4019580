// SPDX-License-Identifier: MIT
// Lets a program end while a disk keeps it waiting. All is done in one thread, which waits for the world's
// file where it has to; so a second one sees SIGTERM and SIGINT come. From then on nothing more is read
// (FileSource::stop_reading), and where a read still hangs after a while, the program is ended.
#pragma once

#include <pthread.h>

#include <atomic>

namespace karst::app {

class EndWatch {
 public:
  // signals: a signalfd that SIGTERM and SIGINT wait in; it is not read here. may_exit: whoever is behind
  // gives the console back. Where there is no thread to be had, a disk is waited for.
  EndWatch(int signals, bool may_exit);
  EndWatch(const EndWatch&) = delete;
  EndWatch& operator=(const EndWatch&) = delete;
  ~EndWatch();

  // The program was told to end: by what the other thread has taken from `signals`.
  void told();

 private:
  void watch();
  bool comes_in_time();

  int signals_;
  bool may_exit_;
  int wake_ = -1;  // an eventfd
  bool has_thread_ = false;
  pthread_t thread_{};
  std::atomic<bool> told_ = false;
  std::atomic<bool> over_ = false;
};

}  // namespace karst::app
