// SPDX-License-Identifier: MIT
// KARST_API marks what a shared libkarst shows; everything else is hidden.
#pragma once

#if defined(__GNUC__)
#define KARST_API __attribute__((visibility("default")))
#else
#define KARST_API
#endif
