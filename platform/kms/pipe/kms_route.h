// SPDX-License-Identifier: MIT
// The CRTC that feeds a connector, and what it showed before.
#pragma once

#include <cstdint>

#include "platform/base/error.h"
#include "platform/kms/card/kms_card.h"
#include "platform/seat/console_state.h"

namespace karst {

struct KmsRoute {
  int fd = -1;  // of the card
  std::uint32_t connector = 0;
  std::uint32_t crtc = 0;
  unsigned crtc_index = 0;  // among the card's
};

// Takes the CRTC in use by the connector, if any, else the first that can feed it.
Error choose_route(const KmsCard& card, const KmsConnector& connector, KmsRoute& route);

// Notes in console what the CRTC shows, unless something is noted already. Where it cannot be read, nothing
// is.
void save_crtc(const KmsRoute& route, const KmsCard& card, ConsoleState& console);

}  // namespace karst
