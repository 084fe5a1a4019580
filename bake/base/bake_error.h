// SPDX-License-Identifier: MIT
// The one exception of karst-bake: a single line that names the file and the field that is wrong. The host
// tool uses exceptions, for its libraries do; the core it calls does not.
#pragma once

#include <stdexcept>

namespace karst::bake {

// what(): one line without a full stop, "FILE: field: what is wrong", ready to print. Exit code 1.
struct BakeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace karst::bake
