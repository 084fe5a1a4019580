// SPDX-License-Identifier: MIT
// All cards of the machine: finding the one that has a monitor, and listing what there is.
#pragma once

#include <xf86drmMode.h>

#include <string>
#include <vector>

#include "platform/base/error.h"
#include "platform/kms/card/kms_card.h"
#include "platform/seat/seat.h"

namespace karst {

// Nodes of all cards, sorted. An error where there are none.
Error card_paths(std::vector<std::string>& paths);

// Opens the first card with a connected connector of the wanted name and with a mode. card: a node or a link
// to one (/dev/dri/by-path/...), empty: any. connector: its name, empty: the first connected. On failure
// returns false, and reasons has one line a card that was looked at. card is closed then.
bool find_output(Seat& seat, const std::string& wanted_card, const std::string& wanted_connector,
                 KmsCard& card, KmsConnector& connector, std::vector<std::string>& reasons);

// What --list-outputs shows.
struct KmsOutputInfo {
  std::string card;
  std::string driver;
  std::string connector;
  bool connected = false;
  int width_mm = 0;
  int height_mm = 0;
  std::vector<drmModeModeInfo> modes;
};
// All connectors of all cards (or of one). reasons: a line for each card that was refused.
std::vector<KmsOutputInfo> list_outputs(Seat& seat, const std::string& card,
                                        std::vector<std::string>& reasons);

}  // namespace karst
