// SPDX-License-Identifier: MIT
#include "app/options/skips.h"

namespace karst::app {

std::string switch_off_skips(std::string_view list, SceneView& view) {
  while (true) {
    const std::size_t comma = list.find(',');
    const std::string_view name = list.substr(0, comma);
    bool known = false;
    for (const Skip& skip : kSkips) {
      if (name != skip.name && name != "all") continue;
      skip.in(view) = false;
      known = true;
    }
    if (!known) {
      std::string error = "'";
      error.append(name).append("' is none of");
      for (const Skip& skip : kSkips) error.append(" ").append(skip.name);
      return error.append(" all");
    }
    if (comma == std::string_view::npos) return {};
    list.remove_prefix(comma + 1);
  }
}

}  // namespace karst::app
