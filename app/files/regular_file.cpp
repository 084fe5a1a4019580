// SPDX-License-Identifier: MIT
#include "app/files/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace karst::app {

std::string read_failure(const std::string& path, int error) {
  return path + ": cannot read: " + std::strerror(error);
}

Error open_regular_file(const std::string& path, int& file, std::uint64_t& bytes) {
  // Without O_NONBLOCK, opening a pipe would wait for a writer.
  const int opened = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (opened < 0) return read_failure(path, errno);
  Error error;
  struct stat info {};
  if (fstat(opened, &info) != 0) {
    error = read_failure(path, errno);
  } else if (S_ISDIR(info.st_mode)) {
    error = read_failure(path, EISDIR);
  } else if (!S_ISREG(info.st_mode)) {
    error = path + ": cannot read: not a regular file";
  } else if (info.st_size == 0) {
    error = path + ": the file is empty";
  }
  if (!error.ok()) {
    ::close(opened);
    return error;
  }
  file = opened;
  bytes = static_cast<std::uint64_t>(info.st_size);
  return {};
}

void sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  ::close(descriptor);
}

int write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return 0;
}

}  // namespace karst::app
