// SPDX-License-Identifier: MIT
#include "platform/kms/kms_choice.h"

#include <algorithm>

#include "platform/kms/card/kms_outputs.h"

namespace karst {

void KmsChoice::find(KmsCard& card, KmsConnector& connector) {
  std::vector<std::string> reasons;
  const bool any = find_output(seat_, options_.card, options_.connector, card, connector, reasons);
  for (const std::string& reason : reasons) {
    if (any || reasons != last_reasons_) log_.tell(reason);
  }
  last_reasons_ = reasons;
  if (!any && options_.mode_fallback && !options_.connector.empty() &&
      find_output(seat_, options_.card, {}, card, connector, reasons)) {
    log_.tell(options_.connector + " has no monitor; taking " + connector.name);
  }
}

bool KmsChoice::usable(const KmsConnector& connector) const {
  return connector.connected && !connector.modes.empty() &&
         (options_.connector.empty() || options_.mode_fallback || connector.name == options_.connector);
}

std::size_t KmsChoice::pick(const std::vector<KmsConnector>& connectors, std::uint32_t id) const {
  auto found = std::find_if(connectors.begin(), connectors.end(),
                            [&](const KmsConnector& c) { return c.id == id && usable(c); });
  if (found == connectors.end()) {
    found =
        std::find_if(connectors.begin(), connectors.end(), [&](const KmsConnector& c) { return usable(c); });
  }
  return static_cast<std::size_t>(found - connectors.begin());
}

bool KmsChoice::is_on_another_card(const KmsCard& card) {
  std::vector<std::string> paths;
  if (!options_.card.empty() || !card_paths(paths).ok() || paths.size() < 2) return false;
  KmsCard other;
  KmsConnector there;
  std::vector<std::string> reasons;
  const std::string wanted = options_.mode_fallback ? std::string() : options_.connector;
  return find_output(seat_, {}, wanted, other, there, reasons) && other.path() != card.path();
}

Error KmsChoice::choose(const KmsConnector& connector, std::size_t& mode) {
  mode = choose_mode(connector.modes, options_.mode);
  if (mode != kNoMode) return {};
  std::string names;
  for (const drmModeModeInfo& m : connector.modes) {
    if (names.size() < 200) names.append(" ").append(mode_text(m));
  }
  if (options_.mode_fallback) {
    log_.say(connector.name + ": the wanted mode is not there; taking the preferred one");
    mode = choose_mode(connector.modes, {});
    if (mode != kNoMode) return {};
  }
  return connector.name + ": --mode: no such mode; there are" + names;
}

}  // namespace karst
