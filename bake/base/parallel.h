// SPDX-License-Identifier: MIT
// A loop over chunks on several threads. What a chunk computes may not depend on the thread that runs it, so
// results are the same for any number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace karst::bake {

// Calls body(first, last, worker) for disjoint ranges that cover [0, count), each of at most `chunk`; worker
// is in 0..threads-1, and worker 0 is the calling thread. body does not throw.
template <class Body>
void parallel_chunks(std::size_t count, std::size_t chunk, int threads, const Body& body) {
  std::atomic<std::size_t> next = 0;
  const auto work = [&](int worker) {
    for (;;) {
      const std::size_t first = next.fetch_add(chunk);
      if (first >= count) return;
      body(first, std::min(first + chunk, count), worker);
    }
  };
  std::vector<std::thread> others;
  for (int worker = 1; worker < threads; ++worker) others.emplace_back(work, worker);
  work(0);
  for (std::thread& t : others) t.join();
}

}  // namespace karst::bake
