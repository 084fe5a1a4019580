// SPDX-License-Identifier: MIT
#include "platform/kms/kms_card.h"

#include <xf86drm.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <utility>

namespace karst {
namespace {

constexpr int kMostCards = 16;

template <auto free_function>
struct DrmFree {
  template <class T>
  void operator()(T* p) const {
    free_function(p);
  }
};
template <class T, auto free_function>
using DrmPtr = std::unique_ptr<T, DrmFree<free_function>>;
using Resources = DrmPtr<drmModeRes, drmModeFreeResources>;
using Connector = DrmPtr<drmModeConnector, drmModeFreeConnector>;
using Encoder = DrmPtr<drmModeEncoder, drmModeFreeEncoder>;

bool has_cap(int fd, std::uint64_t cap) {
  std::uint64_t value = 0;
  return drmGetCap(fd, cap, &value) == 0 && value != 0;
}

std::string connector_name(const drmModeConnector& connector) {
  const char* type = drmModeGetConnectorTypeName(connector.connector_type);
  return std::string(type != nullptr ? type : "Unknown") + "-" + std::to_string(connector.connector_type_id);
}

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

}  // namespace

std::string KmsCard::open(Seat& seat, const std::string& path) {
  close();
  seat_ = &seat;
  path_ = path;
  if (const int error = seat.open_device(path, device_); error != 0) return errno_text("cannot open", error);
  const auto fail = [&](const std::string& why) {
    close();
    return why;
  };
  drmVersionPtr version = drmGetVersion(device_.fd);
  if (version == nullptr) return fail("not a DRM device");
  driver_.assign(version->name, static_cast<std::size_t>(std::max(version->name_len, 0)));
  drmFreeVersion(version);
  const Resources resources(drmModeGetResources(device_.fd));
  if (resources == nullptr) {
    return fail(errno_text("no display outputs: drmModeGetResources", errno));
  }
  if (resources->count_crtcs == 0 || resources->count_connectors == 0) return fail("no display outputs");
  crtcs_.assign(resources->crtcs, resources->crtcs + std::min(resources->count_crtcs, 32));
  // Universal planes come first: without them the atomic calls see no primary plane.
  int failed = drmSetClientCap(device_.fd, DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1);
  if (failed == 0) failed = drmSetClientCap(device_.fd, DRM_CLIENT_CAP_ATOMIC, 1);
  atomic_ = failed == 0;
  lacks_ = atomic_ ? std::string() : errno_text("no atomic calls", failed);
  modifiers_ = has_cap(device_.fd, DRM_CAP_ADDFB2_MODIFIERS);
  if (!modifiers_) lacks_ += lacks_.empty() ? "no buffer modifiers" : ", no buffer modifiers";
  return {};
}

void KmsCard::close() {
  if (device_.fd >= 0) seat_->close_device(device_);
  device_ = {};
  crtcs_.clear();
}

std::string KmsCard::read_connectors(std::vector<KmsConnector>& out) const {
  out.clear();
  const Resources resources(drmModeGetResources(device_.fd));
  if (resources == nullptr) return errno_text("drmModeGetResources", errno);
  for (int i = 0; i < resources->count_connectors; ++i) {
    const Connector connector(drmModeGetConnector(device_.fd, resources->connectors[i]));
    if (connector == nullptr) {
      if (errno == ENOENT) continue;  // unplugged from a hub since the list was made
      return errno_text("drmModeGetConnector", errno);
    }
    KmsConnector& entry = out.emplace_back();
    entry.id = connector->connector_id;
    entry.name = connector_name(*connector);
    entry.connected = connector->connection == DRM_MODE_CONNECTED;
    entry.width_mm = static_cast<int>(connector->mmWidth);
    entry.height_mm = static_cast<int>(connector->mmHeight);
    entry.modes.assign(connector->modes, connector->modes + std::max(connector->count_modes, 0));
    for (int e = 0; e < connector->count_encoders; ++e) {
      const Encoder encoder(drmModeGetEncoder(device_.fd, connector->encoders[e]));
      if (encoder != nullptr) entry.crtcs |= encoder->possible_crtcs;
    }
  }
  return {};
}

std::vector<std::string> card_paths(std::string& error) {
  std::vector<std::string> paths;
  drmDevicePtr devices[kMostCards] = {};
  const int count = drmGetDevices2(0, devices, kMostCards);
  error = count < 0    ? errno_text("no display card: drmGetDevices2", count)
          : count == 0 ? std::string("no display card (/dev/dri/card*)")
                       : std::string();
  for (int i = 0; i < std::min(count, kMostCards); ++i) {
    if ((devices[i]->available_nodes & (1 << DRM_NODE_PRIMARY)) != 0) {
      paths.emplace_back(devices[i]->nodes[DRM_NODE_PRIMARY]);
    }
  }
  if (count > 0) drmFreeDevices(devices, std::min(count, kMostCards));
  std::sort(paths.begin(), paths.end());
  return paths;
}

bool find_output(Seat& seat, const std::string& wanted_card, const std::string& wanted_connector,
                 KmsCard& card, KmsConnector& connector, std::vector<std::string>& reasons) {
  reasons.clear();
  std::string error;
  const std::vector<std::string> paths =
      wanted_card.empty() ? card_paths(error) : std::vector<std::string>{real_path(wanted_card)};
  if (!error.empty()) reasons.push_back(error);
  for (const std::string& path : paths) {
    std::string reason = card.open(seat, path);
    std::vector<KmsConnector> connectors;
    if (reason.empty()) reason = card.read_connectors(connectors);
    if (reason.empty()) {
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
    reasons.push_back(path + ": " + reason);
    card.close();
  }
  return false;
}

std::vector<KmsOutputInfo> list_outputs(Seat& seat, const std::string& card,
                                        std::vector<std::string>& reasons) {
  std::vector<KmsOutputInfo> result;
  reasons.clear();
  std::string error;
  const std::vector<std::string> paths = card.empty() ? card_paths(error) : std::vector<std::string>{card};
  if (!error.empty()) reasons.push_back(error);
  for (const std::string& path : paths) {
    KmsCard opened;
    std::vector<KmsConnector> connectors;
    std::string reason = opened.open(seat, path);
    if (reason.empty()) reason = opened.read_connectors(connectors);
    if (!reason.empty()) reasons.push_back(path + ": " + reason);
    for (KmsConnector& connector : connectors) {
      result.push_back({path, opened.driver(), std::move(connector.name), connector.connected,
                        connector.width_mm, connector.height_mm, std::move(connector.modes)});
    }
  }
  return result;
}

}  // namespace karst
