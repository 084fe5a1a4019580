// SPDX-License-Identifier: MIT
// What the parts of the fake card share.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <errno.h>

struct gbm_device {
  int fd;
};
struct gbm_bo {
  std::uint32_t width, height, handle;
  bool taken;
  std::vector<std::uint8_t> rgba;
};
struct gbm_surface {
  std::uint32_t width, height;
  bool modifiers;
  gbm_bo buffers[4];
  gbm_bo* front;
};

namespace karst::fake {

constexpr std::uint64_t kModifier = 0x0100000000000001;  // Intel's X tiling: any that is not linear

// An environment variable, "" where it is not set.
const char* setting(const char* name);

// What the test says (KARST_FAKE_STATE).
struct State {
  bool connected = false, master = false, atomic = false, modifiers = false, rotate = false, flips = false;
  bool card = false, reset = false, format565 = false;
  std::vector<std::string> refuse;
  std::vector<std::pair<int, int>> modes;
};
State state();

// Whether this call is the one that fails (KARST_FAKE_FAIL); errno is set then.
bool fails(const char* name);
#define FAIL_INT() \
  if (karst::fake::fails(__func__)) return -errno
#define FAIL_NULL() \
  if (karst::fake::fails(__func__)) return nullptr

// Numbers for objects, never given twice.
std::uint32_t make_id();
// A buffer by its handle, null where there is none.
gbm_bo* buffer_of(std::uint32_t handle);

// The function that this library stands before.
void* real_address(const char* name);
template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(real_address(name));
}

}  // namespace karst::fake
