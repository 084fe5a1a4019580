// SPDX-License-Identifier: MIT
// A board's profile as options: what --board NAME or --board FILE.board sets before the other options do.
#pragma once

#include <string>
#include <string_view>

#include "app/options/scene_options.h"
#include "boards/board_profile.h"
#include "platform/base/error.h"

namespace karst::app {

// text: a built-in board's name, or a file whose name ends in .board.
Error read_board(std::string_view text, BoardProfile& profile);

// Size, level of detail, pool, shadows, colour, buffers and memory of a scene.
void set_board(const BoardProfile& profile, SceneArguments& scene);

}  // namespace karst::app
