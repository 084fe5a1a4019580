// SPDX-License-Identifier: MIT
// Preconditions as code: KARST_ASSERT(condition) stops the program where a caller broke one. On in debug
// builds and wherever KARST_CHECKS is defined; elsewhere the condition is compiled and never evaluated, so it
// must not have effects. What can go wrong without a caller's mistake is a Status (karst/status.h), never an
// assert.
#pragma once

#if !defined(NDEBUG)
#include <cassert>
#define KARST_ASSERT(condition) assert(condition)
#elif defined(KARST_CHECKS)
#include <cstdlib>
#define KARST_ASSERT(condition) ((condition) ? static_cast<void>(0) : std::abort())
#else
#define KARST_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#endif
