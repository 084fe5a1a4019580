// SPDX-License-Identifier: MIT
// One connector with the CRTC and the plane that feed it: modes are set, frames are flipped, and what the
// CRTC showed before is put back. Property ids are looked up once, in open(); a driver that lacks a needed
// one is refused there.
//
// Calls that reach the driver return 0 or a negative errno, because what an error means is for the caller to
// decide: EACCES and EPERM when another program is the master, EBUSY when a flip is under way, EINVAL, ERANGE
// and ENOSPC when the hardware cannot do it, ENODEV when it is gone.
#pragma once

#include <drm_fourcc.h>
#include <xf86drmMode.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "platform/kms/kms_card.h"
#include "platform/seat/console_state.h"

namespace karst {

// What a plane shows: a framebuffer as large as the mode, or as large as the mode turned when the plane turns
// it.
struct KmsPicture {
  std::uint32_t framebuffer = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int plane_turns = 0;  // quarter turns counter-clockwise that the plane makes
};

class KmsPipe {
 public:
  KmsPipe() = default;
  KmsPipe(const KmsPipe&) = delete;
  KmsPipe& operator=(const KmsPipe&) = delete;
  ~KmsPipe() { close(); }

  // Chooses a CRTC (the one in use by the connector, if any) and its primary plane, and notes in console what
  // the CRTC shows, once a console. Empty on success, else one line. format: of DRM_FORMAT_*; without atomic,
  // or where the driver cannot do it, only the legacy calls are used and is_atomic() is false.
  [[nodiscard]] std::string open(const KmsCard& card, const KmsConnector& connector, bool atomic,
                                 std::uint32_t format, ConsoleState& console);
  void close();
  bool is_open() const { return crtc_ != 0; }
  bool is_atomic() const { return plane_ != 0; }
  std::uint32_t connector() const { return connector_; }
  // Layouts that the plane takes for the format; empty where it does not say.
  const std::vector<std::uint64_t>& modifiers() const { return modifiers_; }
  bool can_turn(int quarter_turns) const;

  // Whether the driver would take it; atomic only.
  int test(const drmModeModeInfo& mode, const KmsPicture& picture);
  // Sets the mode with this picture; done on return.
  int set_mode(const drmModeModeInfo& mode, const KmsPicture& picture, bool atomic);
  // Shows another picture at the next refresh; the card's descriptor becomes readable then, and
  // drmHandleEvent() calls the handler with user.
  int flip(const KmsPicture& picture, bool atomic, void* user);

 private:
  struct PlaneIds {
    std::uint32_t fb_id, crtc_id, src_x, src_y, src_w, src_h, crtc_x, crtc_y, crtc_w, crtc_h, rotation;
  };

  std::string choose_crtc(const KmsCard& card, const KmsConnector& connector);
  std::string open_plane(std::uint32_t format);
  void save(const std::string& card_path, ConsoleState& console) const;
  int commit_mode(const drmModeModeInfo& mode, const KmsPicture& picture, std::uint32_t flags);

  int fd_ = -1;
  std::uint32_t connector_ = 0;
  std::uint32_t crtc_ = 0;
  unsigned crtc_index_ = 0;
  std::uint32_t plane_ = 0;  // 0: legacy calls only
  std::uint32_t connector_crtc_id_ = 0;
  std::uint32_t connector_link_status_ = 0;  // 0: the driver has none
  std::uint32_t crtc_mode_id_ = 0;
  std::uint32_t crtc_active_ = 0;
  PlaneIds plane_ids_{};
  std::uint64_t rotations_ = 0;  // DRM_MODE_ROTATE_* that the plane can do
  struct OtherPlane {
    std::uint32_t plane, fb_id, crtc_id;
  };
  std::vector<OtherPlane> other_planes_;  // that may lie above ours
  std::vector<std::uint64_t> modifiers_;
};

}  // namespace karst
