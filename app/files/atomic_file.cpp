// SPDX-License-Identifier: MIT
#include "app/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>

namespace karst::app {
namespace {

Error failure(const std::string& path, const char* action, int error) {
  return path + ": cannot " + action + ": " + std::strerror(error);
}

// Where bytes for `path` really go.
struct Target {
  std::string path;     // symbolic links resolved, so that a rename replaces the file and not the link
  std::string folder;   // that holds path
  bool direct = false;  // a device or pipe: a rename would replace it by a file
};

Error find_target(const std::string& path, Target& target) {
  if (path.empty()) return "output file name is empty";
  target.path = path;
  char resolved[PATH_MAX];
  if (realpath(path.c_str(), resolved) != nullptr) target.path = resolved;
  struct stat info {};
  if (stat(target.path.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) return failure(path, "write", EISDIR);
    target.direct = !S_ISREG(info.st_mode);
  } else if (errno != ENOENT) {
    return failure(path, "write", errno);
  }
  if (target.path.back() == '/') return failure(path, "write", EISDIR);
  const std::size_t slash = target.path.rfind('/');
  target.folder = slash == std::string::npos ? "." : slash == 0 ? "/" : target.path.substr(0, slash);
  return {};
}

// A new file beside the target. Created with the mode that the target would have got (mkstemp would make it
// 0600).
int create_temporary(const Target& target, std::string& name) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    name = target.path + ".tmp-" + std::to_string(getpid()) + "-" + std::to_string(attempt);
    const int file = open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file >= 0 || errno != EEXIST) return file;
  }
  return -1;
}

int write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return 0;
}

Error write_direct(const std::string& path, const Target& target, std::span<const std::byte> bytes) {
  const int file = open(target.path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (file < 0) return failure(path, "write", errno);
  const int error = write_all(file, bytes);
  close(file);
  return error == 0 ? Error() : failure(path, "write", error);
}

// Makes the rename itself durable. Some file systems refuse fsync on a folder; the file is complete all the
// same.
void sync_folder(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

Error check_writable(const std::string& path) {
  Target target;
  if (Error error = find_target(path, target); !error.ok()) return error;
  if (target.direct) return access(target.path.c_str(), W_OK) == 0 ? Error() : failure(path, "write", errno);
  std::string name;
  const int file = create_temporary(target, name);
  if (file < 0) return failure(path, "write", errno);
  close(file);
  unlink(name.c_str());
  return {};
}

Error write_file_atomic(const std::string& path, std::span<const std::byte> bytes) {
  Target target;
  if (Error error = find_target(path, target); !error.ok()) return error;
  if (target.direct) return write_direct(path, target, bytes);
  std::string name;
  const int file = create_temporary(target, name);
  if (file < 0) return failure(path, "write", errno);
  int error = write_all(file, bytes);
  if (error == 0 && fsync(file) != 0) error = errno;
  if (close(file) != 0 && error == 0) error = errno;
  if (error == 0 && rename(name.c_str(), target.path.c_str()) != 0) error = errno;
  if (error != 0) {
    unlink(name.c_str());
    return failure(path, "write", error);
  }
  sync_folder(target.folder);
  return {};
}

}  // namespace karst::app
