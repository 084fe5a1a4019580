// SPDX-License-Identifier: MIT
// Counts this program's own calls of the heap (operator new and delete, replaced in heap_count.cpp), so that
// tests can state that something makes none. The GL driver allocates with malloc and is not counted.
#pragma once

#include <cstdint>

namespace karst::test {

std::uint64_t heap_calls();

}  // namespace karst::test
