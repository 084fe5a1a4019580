// SPDX-License-Identifier: MIT
// What a machine says of itself and of its OpenGL ES.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "platform/base/error.h"

namespace karst::device {

using Json = nlohmann::ordered_json;

// Of the first headless context that EGL gives: names and versions of EGL and GL, limits, precision of
// shaders' numbers, extensions. Loads the driver, so it may crash: run it in a process of its own.
Error probe_device(Json& device);

// System, processor, cores, memory, load. Never a name of host or user.
Json probe_machine();

}  // namespace karst::device
