// SPDX-License-Identifier: MIT
// A loop over chunks on several threads. What a chunk computes may not depend on the thread that runs it, so
// results are the same for any number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace karst::bake {

// Calls body(first, last, worker) for disjoint ranges that cover [0, count), each of at most `chunk`; worker
// is in 0..threads-1, and worker 0 is the calling thread. Where the system makes no more threads, fewer do
// the work. What body throws (no memory) ends the loop and is thrown here.
template <class Body>
void parallel_chunks(std::size_t count, std::size_t chunk, int threads, const Body& body) {
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;  // of the worker that set failed
  const auto work = [&](int worker) {
    try {
      while (!failed) {
        const std::size_t first = next.fetch_add(chunk);
        if (first >= count) return;
        body(first, std::min(first + chunk, count), worker);
      }
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  try {
    for (int worker = 1; worker < threads; ++worker) others.emplace_back(work, worker);
  } catch (const std::exception&) {  // std::system_error, std::bad_alloc: with those that there are
  }
  work(0);
  for (std::thread& t : others) t.join();
  if (failure != nullptr) std::rethrow_exception(failure);
}

}  // namespace karst::bake
