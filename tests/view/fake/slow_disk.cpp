// SPDX-License-Identifier: MIT
// A slow disk: reads at a place in a file take KARST_FAKE_READ_MS milliseconds, whatever signal comes.
#include <errno.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>

extern "C" {

ssize_t pread64(int file, void* out, std::size_t bytes, off64_t offset) {
  if (const char* const text = std::getenv("KARST_FAKE_READ_MS"); text != nullptr) {
    const long ms = std::strtol(text, nullptr, 10);
    timespec left{ms / 1000, ms % 1000 * 1'000'000};
    while (nanosleep(&left, &left) != 0 && errno == EINTR) continue;
  }
  return syscall(SYS_pread64, file, out, bytes, offset);
}

ssize_t pread(int file, void* out, std::size_t bytes, off_t offset) {
  return pread64(file, out, bytes, offset);
}

}  // extern "C"
