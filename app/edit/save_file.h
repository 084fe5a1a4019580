// SPDX-License-Identifier: MIT
// An edited world into a file: a temporary one beside it, complete and on the disk before it takes the name.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "karst/edit.h"
#include "platform/base/error.h"

namespace karst::app {

// ready: called with the world's id (journal_file.h) when all is written, before the file takes its name; an
// error keeps it from that. May be empty. bytes: of the file. expected: about as many, for a progress bar; 0:
// none is shown.
using SaveReady = std::function<Error(std::uint64_t id)>;
Error save_file(Editor& editor, const std::string& path, const SaveReady& ready, std::uint64_t& bytes,
                std::uint64_t expected = 0);

}  // namespace karst::app
