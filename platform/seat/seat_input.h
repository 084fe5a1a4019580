// SPDX-License-Identifier: MIT
// Keyboards, mice and touch screens of a seat, through libinput.
#pragma once

#include <memory>
#include <string>

#include "platform/base/error.h"
#include "platform/base/log.h"
#include "platform/input.h"
#include "platform/seat/seat.h"

namespace karst {

// All devices of the seat, those plugged in later included. Null where there is no input, and error says why.
std::unique_ptr<Input> open_input(Seat& seat, const LogLine& log, Error& error);

}  // namespace karst
