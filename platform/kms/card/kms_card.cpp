// SPDX-License-Identifier: MIT
#include "platform/kms/card/kms_card.h"

#include <xf86drm.h>

#include <algorithm>
#include <cerrno>
#include <memory>

#include "platform/base/log.h"

namespace karst {
namespace {

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

}  // namespace

Error KmsCard::open(Seat& seat, const std::string& path) {
  close();
  seat_ = &seat;
  path_ = path;
  if (const int error = seat.open_device(path, device_); error != 0) return errno_text("cannot open", error);
  const auto fail = [&](const std::string& why) -> Error {
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

Error KmsCard::read_connectors(std::vector<KmsConnector>& out) const {
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

}  // namespace karst
