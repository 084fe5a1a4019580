// SPDX-License-Identifier: MIT
// What work took, and that no GL is called meanwhile.
#pragma once

#include <chrono>
#include <cstdint>

#include "karst/inspect.h"

namespace karst::core {

// Nanoseconds of a clock that only goes forwards.
inline std::int64_t clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}
inline double ms_since(std::int64_t start_ns) {
  return static_cast<double>(clock_ns() - start_ns) * 1e-6;
}

// Tells the inspection that no GL is called while it lives.
class OwnWork {
 public:
  explicit OwnWork(const Inspection& inspection) : inspection_(inspection) { tell(true); }
  OwnWork(const OwnWork&) = delete;
  OwnWork& operator=(const OwnWork&) = delete;
  ~OwnWork() { tell(false); }

 private:
  void tell(bool begins) const {
    if (inspection_.own_work != nullptr) inspection_.own_work(inspection_.user, begins);
  }
  const Inspection& inspection_;
};

}  // namespace karst::core
