// SPDX-License-Identifier: MIT
#include "app/files/atomic_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "app/files/output_place.h"
#include "app/files/regular_file.h"

namespace karst::app {
namespace {

constexpr std::string_view kPrefix = ".karst-", kSuffix = ".tmp";
constexpr int kAttempts = 100;

Error failure(const std::string& path, const char* action, int error) {
  return path + ": cannot " + action + ": " + std::strerror(error);
}

// --- what signals remove

// One at a time: programs write one file after the other. The handler reads it while `set` is not 0.
struct Doomed {
  volatile sig_atomic_t set = 0;
  int folder = -1;
  char name[64] = {};
};
Doomed doomed;

extern "C" void remove_and_end(int number) {
  if (doomed.set != 0) unlinkat(doomed.folder, doomed.name, 0);
  doomed.set = 0;
  signal(number, SIG_DFL);
  raise(number);  // delivered when the handler returns
}

// While it lives, signals that would end the program remove the temporary file first. Signals that the
// program ignores, handles or blocks stay so.
class SignalGuard {
 public:
  SignalGuard() {
    struct sigaction action {};
    action.sa_handler = remove_and_end;
    sigemptyset(&action.sa_mask);
    for (std::size_t n = 0; n < kSignals.size(); ++n) {
      struct sigaction before {};
      ours_[n] = sigaction(kSignals[n], nullptr, &before) == 0 && before.sa_handler == SIG_DFL &&
                 sigaction(kSignals[n], &action, nullptr) == 0;
    }
  }
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;
  ~SignalGuard() {
    for (std::size_t n = 0; n < kSignals.size(); ++n) {
      if (ours_[n]) signal(kSignals[n], SIG_DFL);
    }
  }

 private:
  static constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};
  std::array<bool, kSignals.size()> ours_{};
};

// Signals are held back while it lives.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_{};
};

// --- temporary files

// A new file in the target's folder with its name known to the signals' handler; gone when this object goes,
// unless it became the target.
class Temporary {
 public:
  explicit Temporary(int folder) : folder_(folder) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    remove();
    if (file_ >= 0) close(file_);
  }

  // Made with the mode that the target would have got (mkstemp would make it 0600). 0, or an errno.
  int create() {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const SignalsHeld held;
      std::snprintf(doomed.name, sizeof doomed.name, "%s%d-%d%s", kPrefix.data(), static_cast<int>(getpid()),
                    attempt, kSuffix.data());
      file_ = openat(folder_, doomed.name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
      if (file_ < 0 && errno == EEXIST) continue;
      if (file_ < 0) return errno;
      doomed.folder = folder_;
      doomed.set = 1;
      // Somebody who sweeps may have come between: then the file is theirs to remove. A file system without
      // locks is never swept.
      struct stat info {};
      const bool lost = flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
      if (!lost && fstat(file_, &info) == 0 && info.st_nlink > 0) return 0;
      doomed.set = 0;
      close(file_);
      file_ = -1;
    }
    return EEXIST;
  }

  // Rights and owner of the file that will be replaced; the owner where this process may give files away.
  int keep_rights(const struct stat& target) const {
    if (target.st_uid != geteuid() || target.st_gid != getegid()) {
      [[maybe_unused]] const int given = fchown(file_, target.st_uid, target.st_gid);
    }
    return fchmod(file_, target.st_mode & 0777u) == 0 ? 0 : errno;
  }

  // Before the file is closed, which ends its lock.
  int rename_to(const char* name) {
    const SignalsHeld held;
    if (renameat(folder_, doomed.name, folder_, name) != 0) return errno;
    doomed.set = 0;
    return 0;
  }

  int write_at(std::uint64_t offset, std::span<const std::byte> bytes) const {
    while (!bytes.empty()) {
      const ssize_t count = pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return count < 0 ? errno : EIO;
      offset += static_cast<std::uint64_t>(count);
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return 0;
  }

  int sync() const { return fsync(file_) == 0 ? 0 : errno; }

 private:
  void remove() const {
    const SignalsHeld held;
    if (doomed.set != 0) unlinkat(folder_, doomed.name, 0);
    doomed.set = 0;
  }

  int folder_;
  int file_ = -1;
};

// Removes temporary files of this user whose writers are gone: their locks are to be had.
void sweep(const std::string& folder) {
  DIR* const entries = opendir(folder.c_str());
  if (entries == nullptr) return;
  const int at = dirfd(entries);
  while (const dirent* entry = readdir(entries)) {
    const std::string_view name = entry->d_name;
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) continue;
    // To lock over NFS a file must be open for writing.
    const int file = openat(at, entry->d_name, O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY);
    if (file < 0) continue;
    struct stat info {};
    const bool ours = fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_uid == geteuid();
    if (ours && flock(file, LOCK_EX | LOCK_NB) == 0) unlinkat(at, entry->d_name, 0);
    close(file);
  }
  closedir(entries);
}

Error write_direct(const std::string& path, std::span<const std::byte> bytes) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (file < 0) return failure(path, "write", errno);
  int error = write_all(file, bytes);
  if (close(file) != 0 && error == 0) error = errno;
  return error == 0 ? Error() : failure(path, "write", error);
}

struct Folder {
  explicit Folder(const std::string& path)
      : descriptor(open(path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {}
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    if (descriptor >= 0) close(descriptor);
  }
  int descriptor;
};

}  // namespace

Error check_writable(const std::string& path) {
  OutputPlace place;
  if (Error error = find_output(path, place); !error.ok()) return error;
  if (place.direct) return access(path.c_str(), W_OK) == 0 ? Error() : failure(path, "write", errno);
  sweep(place.folder);
  const Folder folder(place.folder);
  if (folder.descriptor < 0) return failure(path, "write", errno);
  if (place.name.size() > NAME_MAX) return failure(path, "write", ENAMETOOLONG);
  const SignalGuard guard;
  Temporary file(folder.descriptor);
  const int error = file.create();
  return error == 0 ? Error() : failure(path, "write", error);
}

struct AtomicFile::Open {
  Open(std::string path_of_file, OutputPlace place_of_file)
      : path(std::move(path_of_file)), place(std::move(place_of_file)), folder(place.folder) {}

  std::string path;
  OutputPlace place;
  Folder folder;
  SignalGuard guard;
  Temporary file{folder.descriptor};
};

AtomicFile::AtomicFile() = default;
AtomicFile::~AtomicFile() = default;

Error AtomicFile::open(const std::string& path) {
  open_.reset();
  OutputPlace place;
  if (Error error = find_output(path, place); !error.ok()) return error;
  if (place.direct) return path + ": a device or a pipe; this is written to files alone";
  auto opened = std::make_unique<Open>(path, std::move(place));
  const int folder = opened->folder.descriptor;
  if (folder < 0) return failure(path, "write", errno);
  int error = opened->file.create();
  struct stat before {};
  if (error == 0 && fstatat(folder, opened->place.name.c_str(), &before, AT_SYMLINK_NOFOLLOW) == 0)
    error = opened->file.keep_rights(before);
  if (error != 0) return failure(path, "write", error);
  open_ = std::move(opened);
  return {};
}

Error AtomicFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  const int error = open_->file.write_at(offset, bytes);
  return error == 0 ? Error() : failure(open_->path, "write", error);
}

Error AtomicFile::commit() {
  int error = open_->file.sync();
  if (error == 0) error = open_->file.rename_to(open_->place.name.c_str());
  if (error != 0) return failure(open_->path, "write", error);
  sync_folder_of(open_->place.folder + "/");
  open_.reset();
  return {};
}

Error write_file_atomic(const std::string& path, std::span<const std::byte> bytes) {
  OutputPlace place;
  if (Error error = find_output(path, place); !error.ok()) return error;
  if (place.direct) return write_direct(path, bytes);
  AtomicFile file;
  if (Error error = file.open(path); !error.ok()) return error;
  if (Error error = file.write(0, bytes); !error.ok()) return error;
  return file.commit();
}

}  // namespace karst::app
