// SPDX-License-Identifier: MIT
// Where a part of the platform tells what it does: one line for the user, without a newline.
#pragma once

#include <functional>
#include <string>

namespace karst {

using LogLine = std::function<void(const std::string& line)>;

// "drmModeAddFB2: No such device" for a negative or positive errno.
std::string errno_text(const std::string& what, int error);

}  // namespace karst
