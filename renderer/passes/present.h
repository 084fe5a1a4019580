// SPDX-License-Identifier: MIT
// The last step to a screen: pictures for screens that stand on their side.
#pragma once

#include "renderer/shader_interface.h"

namespace karst::core {

// Turns what is drawn with the block counter-clockwise, in steps of 90 degrees. Turning by whole steps only
// swaps and negates numbers, so that the same points of the lattice are drawn, to the bit.
void turn_frame_block(shader::FrameBlock& block, int quarter_turns);

}  // namespace karst::core
