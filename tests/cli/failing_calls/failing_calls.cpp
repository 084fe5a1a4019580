// SPDX-License-Identifier: MIT
// Fails one call of a program, which runs unchanged with this preloaded (LD_PRELOAD). Calls are those of the
// program's own code; what its libraries and drivers call goes through. pthread_create counts from anywhere.
//
// Environment:
//   KARST_FAIL_CALL   open, read, write, fsync, rename, malloc or thread
//   KARST_FAIL_AT     which of them fails, once, from 1; 0: none
//   KARST_FAIL_COUNT  file that the number of such calls is written to at the end
#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <stdarg.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);

namespace {

std::atomic<bool> ready = false;
std::atomic<std::uint64_t> calls = 0;
// Where code lies.
struct Code {
  std::uintptr_t low = UINTPTR_MAX, high = 0;
  bool has(const void* place) const {
    const auto at = reinterpret_cast<std::uintptr_t>(place);
    return at >= low && at < high;
  }
};
Code program, library, own;  // library: of C++
char chosen[16] = {};
std::uint64_t fail_at = 0;

// The first object is the program.
int take_code(dl_phdr_info* info, std::size_t, void* first) {
  Code code;
  for (int n = 0; n < info->dlpi_phnum; ++n) {
    const ElfW(Phdr)& part = info->dlpi_phdr[n];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    code = {info->dlpi_addr + part.p_vaddr, info->dlpi_addr + part.p_vaddr + part.p_memsz};
  }
  if (*static_cast<bool*>(first)) program = code;
  *static_cast<bool*>(first) = false;
  if (std::strstr(info->dlpi_name, "libstdc++") != nullptr) library = code;
  if (code.has(reinterpret_cast<const void*>(&take_code))) own = code;
  return 0;
}

__attribute__((constructor)) void begin() {
  const char* const call = getenv("KARST_FAIL_CALL");
  const char* const at = getenv("KARST_FAIL_AT");
  if (call == nullptr || at == nullptr) return;
  std::snprintf(chosen, sizeof chosen, "%s", call);
  fail_at = std::strtoull(at, nullptr, 10);
  bool first = true;
  dl_iterate_phdr(take_code, &first);
  void* frames[1];
  backtrace(frames, 1);  // loads what it needs now
  ready = true;
}

__attribute__((destructor)) void end() {
  const char* const name = getenv("KARST_FAIL_COUNT");
  if (!ready || name == nullptr) return;
  char text[32];
  const int length = std::snprintf(text, sizeof text, "%llu", static_cast<unsigned long long>(calls.load()));
  const long file = syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  syscall(SYS_write, file, text, static_cast<std::size_t>(length));
  syscall(SYS_close, file);
}

bool counts(const char* call) {
  return std::strcmp(chosen, call) == 0 && ++calls == fail_at;
}

// Whether this call of the code at `from` fails.
bool fails(const char* call, const void* from) {
  return ready && program.has(from) && counts(call);
}

// The program may have an operator new of its own, which drivers then call, and strings are made in the C++
// library: behind these the program's code must lie.
bool allocation_fails(const void* from) {
  if (!ready || std::strcmp(chosen, "malloc") != 0) return false;
  if (!program.has(from) && !library.has(from)) return false;
  void* frames[12];
  const int count = backtrace(frames, 12);
  int n = 0;
  while (n < count && own.has(frames[n])) ++n;
  if (n < count && program.has(frames[n])) ++n;
  while (n < count && library.has(frames[n])) ++n;
  return n < count && program.has(frames[n]) && counts("malloc");
}

template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

void* allocate(std::size_t bytes, const void* from) {
  return allocation_fails(from) ? nullptr : __libc_malloc(bytes);
}

void* allocate_or_throw(std::size_t bytes, const void* from) {
  void* const memory = allocate(bytes == 0 ? 1 : bytes, from);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

int open_at(int folder, const char* path, int flags, va_list rest, const void* from) {
  const unsigned mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, unsigned) : 0;
  if (fails("open", from)) {
    errno = EMFILE;
    return -1;
  }
  return static_cast<int>(syscall(SYS_openat, folder, path, flags, mode));
}

}  // namespace

#define FROM __builtin_extract_return_addr(__builtin_return_address(0))

extern "C" {

void* malloc(std::size_t bytes) {
  void* const memory = allocate(bytes, FROM);
  if (memory == nullptr) errno = ENOMEM;
  return memory;
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  if (allocation_fails(FROM)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_memalign(alignment, bytes);
}

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int file = open_at(AT_FDCWD, path, flags, rest, FROM);
  va_end(rest);
  return file;
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat(int folder, const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int file = open_at(folder, path, flags, rest, FROM);
  va_end(rest);
  return file;
}

ssize_t read(int file, void* out, std::size_t bytes) {
  if (fails("read", FROM)) {
    errno = EIO;
    return -1;
  }
  return syscall(SYS_read, file, out, bytes);
}

ssize_t pread(int file, void* out, std::size_t bytes, off_t offset) {
  if (fails("read", FROM)) {
    errno = EIO;
    return -1;
  }
  return syscall(SYS_pread64, file, out, bytes, offset);
}

ssize_t write(int file, const void* bytes, std::size_t count) {
  if (fails("write", FROM)) {
    errno = ENOSPC;
    return -1;
  }
  return syscall(SYS_write, file, bytes, count);
}

ssize_t pwrite(int file, const void* bytes, std::size_t count, off_t offset) {
  if (fails("write", FROM)) {
    errno = ENOSPC;
    return -1;
  }
  return syscall(SYS_pwrite64, file, bytes, count, offset);
}

int fsync(int file) {
  if (fails("fsync", FROM)) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(syscall(SYS_fsync, file));
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  if (fails("rename", FROM)) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(syscall(SYS_renameat2, from_folder, from, to_folder, to, 0));
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                   void* context) noexcept {
  if (ready && counts("thread")) return EAGAIN;
  static const auto create = real<decltype(&pthread_create)>("pthread_create");
  return create(thread, attributes, run, context);
}

}  // extern "C"

void* operator new(std::size_t bytes) {
  return allocate_or_throw(bytes, FROM);
}
void* operator new[](std::size_t bytes) {
  return allocate_or_throw(bytes, FROM);
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate(bytes == 0 ? 1 : bytes, FROM);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate(bytes == 0 ? 1 : bytes, FROM);
}
void operator delete(void* memory) noexcept {
  free(memory);
}
void operator delete[](void* memory) noexcept {
  free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  free(memory);
}
