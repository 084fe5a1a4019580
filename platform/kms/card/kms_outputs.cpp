// SPDX-License-Identifier: MIT
#include "platform/kms/card/kms_outputs.h"

#include <xf86drm.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "platform/base/log.h"

namespace karst {
namespace {

constexpr int kMostCards = 16;

std::string real_path(const std::string& path) {
  char* resolved = realpath(path.c_str(), nullptr);
  if (resolved == nullptr) return path;
  std::string result = resolved;
  std::free(resolved);
  return result;
}

// Why no connector will do.
std::string describe(const std::vector<KmsConnector>& connectors, const std::string& wanted) {
  if (connectors.empty()) return "no connectors";
  std::string names;
  for (const KmsConnector& connector : connectors) {
    if (!names.empty()) names += ", ";
    names += connector.name + (!connector.connected      ? " disconnected"
                               : connector.modes.empty() ? " connected, without modes"
                                                         : " connected");
  }
  return (wanted.empty() ? "no monitor" : "no monitor at " + wanted) + " (" + names + ")";
}

// The wanted card, or all.
std::vector<std::string> paths_of(const std::string& wanted, std::vector<std::string>& reasons) {
  std::vector<std::string> paths;
  if (!wanted.empty()) {
    paths.push_back(wanted);
  } else if (const Error error = card_paths(paths); !error.ok()) {
    reasons.push_back(error.text());
  }
  return paths;
}

}  // namespace

Error card_paths(std::vector<std::string>& paths) {
  paths.clear();
  drmDevicePtr devices[kMostCards] = {};
  const int count = drmGetDevices2(0, devices, kMostCards);
  if (count < 0) return errno_text("no display card: drmGetDevices2", count);
  if (count == 0) return "no display card (/dev/dri/card*)";
  for (int i = 0; i < std::min(count, kMostCards); ++i) {
    if ((devices[i]->available_nodes & (1 << DRM_NODE_PRIMARY)) != 0) {
      paths.emplace_back(devices[i]->nodes[DRM_NODE_PRIMARY]);
    }
  }
  drmFreeDevices(devices, std::min(count, kMostCards));
  std::sort(paths.begin(), paths.end());
  return {};
}

bool find_output(Seat& seat, const std::string& wanted_card, const std::string& wanted_connector,
                 KmsCard& card, KmsConnector& connector, std::vector<std::string>& reasons) {
  reasons.clear();
  for (const std::string& path : paths_of(wanted_card.empty() ? "" : real_path(wanted_card), reasons)) {
    Error reason = card.open(seat, path);
    std::vector<KmsConnector> connectors;
    if (reason.ok()) reason = card.read_connectors(connectors);
    if (reason.ok()) {
      const auto fits = [&](const KmsConnector& c) {
        return c.connected && !c.modes.empty() && (wanted_connector.empty() || c.name == wanted_connector);
      };
      const auto found = std::find_if(connectors.begin(), connectors.end(), fits);
      if (found != connectors.end()) {
        connector = *found;
        return true;
      }
      reason = describe(connectors, wanted_connector);
    }
    reasons.push_back(path + ": " + reason.text());
    card.close();
  }
  return false;
}

std::vector<KmsOutputInfo> list_outputs(Seat& seat, const std::string& card,
                                        std::vector<std::string>& reasons) {
  std::vector<KmsOutputInfo> result;
  reasons.clear();
  for (const std::string& path : paths_of(card, reasons)) {
    KmsCard opened;
    std::vector<KmsConnector> connectors;
    Error reason = opened.open(seat, path);
    if (reason.ok()) reason = opened.read_connectors(connectors);
    if (!reason.ok()) reasons.push_back(path + ": " + reason.text());
    for (KmsConnector& connector : connectors) {
      result.push_back({path, opened.driver(), std::move(connector.name), connector.connected,
                        connector.width_mm, connector.height_mm, std::move(connector.modes)});
    }
  }
  return result;
}

}  // namespace karst
