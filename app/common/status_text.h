// SPDX-License-Identifier: MIT
// A Status of the core as a line for the user.
#pragma once

#include <string>

#include "karst/status.h"

namespace karst::app {

// "canyon.karst: the checksum is wrong (header, at byte 28)". subject: the file or option at fault.
std::string status_text(const std::string& subject, const Status& status);

}  // namespace karst::app
