// SPDX-License-Identifier: MIT
// The version of these headers: semantic versioning (https://semver.org). While MAJOR is 0, a new MINOR may
// change anything; a new PATCH never asks for a change of a program.
#pragma once

#define KARST_VERSION_MAJOR 0
#define KARST_VERSION_MINOR 2
#define KARST_VERSION_PATCH 0
