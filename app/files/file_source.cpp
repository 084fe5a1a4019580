// SPDX-License-Identifier: MIT
#include "app/files/file_source.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <span>

#include "app/files/regular_file.h"

namespace karst::app {
namespace {

std::atomic<bool> stopped = false;
std::atomic<int> readers = 0;

struct Reader {
  Reader() { ++readers; }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { --readers; }
};

bool read_all(int file, std::uint64_t offset, std::span<std::byte> out) {
  const Reader counted;
  while (!out.empty()) {
    if (stopped) return false;
    const ssize_t got = pread(file, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    out = out.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

FileSource::~FileSource() {
  if (file_ >= 0) ::close(file_);
}

Error FileSource::open(const std::string& path) {
  int file = -1;
  if (Error error = open_regular_file(path, file, bytes_); !error.ok()) return error;
  if (file_ >= 0) ::close(file_);
  file_ = file;
  return {};
}

Source FileSource::source() {
  return {bytes_,
          [](void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
            return read_all(static_cast<const FileSource*>(user)->file_, offset, {out, count});
          },
          this};
}

void FileSource::stop_reading() {
  stopped = true;
}

bool FileSource::is_stopped() {
  return stopped;
}

bool FileSource::is_reading() {
  return readers > 0;
}

}  // namespace karst::app
