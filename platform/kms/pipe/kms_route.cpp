// SPDX-License-Identifier: MIT
#include "platform/kms/pipe/kms_route.h"

#include <xf86drmMode.h>

#include <cstdio>

namespace karst {

Error choose_route(const KmsCard& card, const KmsConnector& connector, KmsRoute& route) {
  route = {card.fd(), connector.id, 0, 0};
  // The CRTC that feeds the connector already makes a change of picture without a change of mode possible.
  std::uint32_t current = 0;
  if (drmModeConnectorPtr now = drmModeGetConnectorCurrent(route.fd, connector.id); now != nullptr) {
    if (drmModeEncoderPtr encoder = drmModeGetEncoder(route.fd, now->encoder_id); encoder != nullptr) {
      current = encoder->crtc_id;
      drmModeFreeEncoder(encoder);
    }
    drmModeFreeConnector(now);
  }
  for (unsigned i = 0; i < card.crtcs().size(); ++i) {
    if ((connector.crtcs >> i & 1) == 0) continue;
    if (route.crtc == 0 || card.crtcs()[i] == current) {
      route.crtc = card.crtcs()[i];
      route.crtc_index = i;
    }
  }
  if (route.crtc == 0) return "no CRTC can feed " + connector.name;
  return {};
}

void save_crtc(const KmsRoute& route, const KmsCard& card, ConsoleState& console) {
  if (console.crtc_taken.load()) return;
  drmModeCrtcPtr crtc = drmModeGetCrtc(route.fd, route.crtc);
  if (crtc == nullptr) return;
  std::snprintf(console.card, sizeof console.card, "%s", card.path().c_str());
  console.crtc = route.crtc;
  console.connector = route.connector;
  console.framebuffer = crtc->mode_valid != 0 ? crtc->buffer_id : 0;
  console.x = crtc->x;
  console.y = crtc->y;
  console.mode = crtc->mode;
  console.crtc_taken.store(true);
  drmModeFreeCrtc(crtc);
}

}  // namespace karst
