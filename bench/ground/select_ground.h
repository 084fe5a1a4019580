// SPDX-License-Identifier: MIT
// What choosing the nodes of a ground costs, on one thread and without GL: a flight whose frames are complete
// before they are timed.
#pragma once

#include <span>
#include <string_view>

#include "bench/frames/bench_view.h"

namespace karst::bench {

// Flies it rounds times and prints what was chosen, with a hash of it, and the time. Precondition: the view's
// world is loaded and has a ground.
Error run_select_ground(BenchView& view, const StageView& look, std::string_view name,
                        std::span<const core::Camera> cameras, int rounds);

}  // namespace karst::bench
