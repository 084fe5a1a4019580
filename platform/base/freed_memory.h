// SPDX-License-Identifier: MIT
// What a program that draws in software says to the C library before anything else.
#pragma once

#ifdef __GLIBC__
#include <malloc.h>

#include <cstdlib>
#endif

namespace karst {

// A software driver takes a frame's working memory from the heap and frees it when the frame is drawn. By
// default glibc gives the end of the heap back to the kernel each time, and the next frame faults it in page
// by page. Memory that was once needed is kept instead; the most that is ever used does not change.
// What the environment says to the C library stays.
inline void keep_freed_memory() {
#ifdef __GLIBC__
  if (std::getenv("MALLOC_TRIM_THRESHOLD_") != nullptr) return;
  mallopt(M_TRIM_THRESHOLD, 256 << 20);  // bytes
  mallopt(M_MMAP_THRESHOLD, 4 << 20);    // far above what a frame takes at once, below what is taken to stay
#endif
}

}  // namespace karst
