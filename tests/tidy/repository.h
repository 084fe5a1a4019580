// SPDX-License-Identifier: MIT
// The files of the repository, for the rules that are run over all of them.
#pragma once

#include <string>
#include <vector>

#include "tests/tidy/rules.h"

namespace karst::tidy {

// Everything in the working tree but what git keeps or ignores, by path.
std::vector<Source> repository();

// A line a finding.
std::string listing(const Findings& findings);

}  // namespace karst::tidy
