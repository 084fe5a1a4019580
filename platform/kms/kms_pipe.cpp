// SPDX-License-Identifier: MIT
// Sources: the kernel's Documentation/gpu/drm-kms.rst and drm-uapi.rst, drm_mode.h.
#include "platform/kms/kms_pipe.h"

#include <xf86drm.h>

#include <cerrno>
#include <cstdio>

#include "platform/kms/kms_properties.h"

namespace karst {
namespace {

// An atomic request that remembers the first thing that went wrong with it.
class AtomicRequest {
 public:
  AtomicRequest() : request_(drmModeAtomicAlloc()), error_(request_ != nullptr ? 0 : -ENOMEM) {}
  AtomicRequest(const AtomicRequest&) = delete;
  AtomicRequest& operator=(const AtomicRequest&) = delete;
  ~AtomicRequest() {
    if (request_ != nullptr) drmModeAtomicFree(request_);
  }

  void set(std::uint32_t object, std::uint32_t property, std::uint64_t value) {
    if (error_ != 0) return;
    const int added = drmModeAtomicAddProperty(request_, object, property, value);
    if (added < 0) error_ = added;
  }

  int commit(int fd, std::uint32_t flags, void* user) {
    return error_ != 0 ? error_ : drmModeAtomicCommit(fd, request_, flags, user);
  }

 private:
  drmModeAtomicReqPtr request_;
  int error_;
};

// A mode as the kernel wants to be handed it.
class ModeBlob {
 public:
  ModeBlob(int fd, const drmModeModeInfo& mode) : fd_(fd) {
    error_ = drmModeCreatePropertyBlob(fd, &mode, sizeof mode, &id_);
  }
  ModeBlob(const ModeBlob&) = delete;
  ModeBlob& operator=(const ModeBlob&) = delete;
  ~ModeBlob() {
    if (error_ == 0) drmModeDestroyPropertyBlob(fd_, id_);
  }
  int error() const { return error_; }
  std::uint32_t id() const { return id_; }

 private:
  int fd_;
  std::uint32_t id_ = 0;
  int error_ = 0;
};

// Ids of properties that must be there; the first that is not makes missing() name it.
class Needed {
 public:
  Needed(const KmsProperties& properties, const char* object) : properties_(properties), object_(object) {}
  std::uint32_t operator()(const char* name) {
    const std::uint32_t id = properties_.id(name);
    if (id == 0 && missing_.empty()) missing_ = std::string(object_) + " has no property " + name;
    return id;
  }
  const std::string& missing() const { return missing_; }

 private:
  const KmsProperties& properties_;
  const char* object_;
  std::string missing_;
};

std::vector<std::uint64_t> read_modifiers(int fd, std::uint32_t blob_id, std::uint32_t format) {
  std::vector<std::uint64_t> result;
  drmModePropertyBlobPtr blob = blob_id != 0 ? drmModeGetPropertyBlob(fd, blob_id) : nullptr;
  if (blob == nullptr) return result;
  drmModeFormatModifierIterator iterator{};
  while (drmModeFormatModifierBlobIterNext(blob, &iterator)) {
    if (iterator.fmt == format && iterator.mod != DRM_FORMAT_MOD_INVALID) result.push_back(iterator.mod);
  }
  drmModeFreePropertyBlob(blob);
  return result;
}

std::uint64_t rotate_bit(int quarter_turns) {
  return std::uint64_t{DRM_MODE_ROTATE_0} << (quarter_turns & 3);
}

}  // namespace

std::string KmsPipe::open(const KmsCard& card, const KmsConnector& connector, bool atomic,
                          std::uint32_t format, ConsoleState& console) {
  close();
  fd_ = card.fd();
  connector_ = connector.id;
  std::string error = choose_crtc(card, connector);
  if (error.empty() && atomic && card.atomic()) {
    KmsProperties properties;
    error = properties.read(fd_, connector_, DRM_MODE_OBJECT_CONNECTOR);
    Needed of_connector(properties, "the connector");
    connector_crtc_id_ = of_connector("CRTC_ID");
    connector_link_status_ = properties.id("link-status");
    if (error.empty()) error = of_connector.missing();
    if (error.empty()) error = properties.read(fd_, crtc_, DRM_MODE_OBJECT_CRTC);
    Needed of_crtc(properties, "the CRTC");
    crtc_mode_id_ = of_crtc("MODE_ID");
    crtc_active_ = of_crtc("ACTIVE");
    if (error.empty()) error = of_crtc.missing();
    if (error.empty()) error = open_plane(format);
  }
  if (!error.empty()) {
    close();
  } else if (!console.crtc_taken.load()) {
    save(card.path(), console);
  }
  return error;
}

void KmsPipe::close() {
  crtc_ = connector_ = plane_ = 0;
  rotations_ = 0;
  modifiers_.clear();
  other_planes_.clear();
}

std::string KmsPipe::choose_crtc(const KmsCard& card, const KmsConnector& connector) {
  // The CRTC that feeds the connector already makes a change of picture without a change of mode possible.
  std::uint32_t current = 0;
  if (drmModeConnectorPtr now = drmModeGetConnectorCurrent(fd_, connector.id); now != nullptr) {
    if (drmModeEncoderPtr encoder = drmModeGetEncoder(fd_, now->encoder_id); encoder != nullptr) {
      current = encoder->crtc_id;
      drmModeFreeEncoder(encoder);
    }
    drmModeFreeConnector(now);
  }
  for (unsigned i = 0; i < card.crtcs().size(); ++i) {
    if ((connector.crtcs >> i & 1) == 0) continue;
    if (crtc_ == 0 || card.crtcs()[i] == current) {
      crtc_ = card.crtcs()[i];
      crtc_index_ = i;
    }
  }
  return crtc_ != 0 ? std::string() : "no CRTC can feed " + connector.name;
}

std::string KmsPipe::open_plane(std::uint32_t format) {
  drmModePlaneResPtr planes = drmModeGetPlaneResources(fd_);
  if (planes == nullptr) return errno_text("drmModeGetPlaneResources", errno);
  std::string error;
  for (std::uint32_t i = 0; i < planes->count_planes && error.empty(); ++i) {
    drmModePlanePtr plane = drmModeGetPlane(fd_, planes->planes[i]);
    if (plane == nullptr) {
      error = errno_text("drmModeGetPlane", errno);
      break;
    }
    const bool usable = (plane->possible_crtcs >> crtc_index_ & 1) != 0;
    bool has_format = false;
    for (std::uint32_t f = 0; f < plane->count_formats; ++f) has_format |= plane->formats[f] == format;
    drmModeFreePlane(plane);
    if (!usable) continue;
    KmsProperties properties;
    error = properties.read(fd_, planes->planes[i], DRM_MODE_OBJECT_PLANE);
    if (!error.empty()) break;
    if (properties.value("type") != DRM_PLANE_TYPE_PRIMARY || plane_ != 0 || !has_format) {
      // Only what is on our CRTC now can be in the way.
      if (properties.value("CRTC_ID") == crtc_ && properties.id("FB_ID") != 0) {
        other_planes_.push_back({planes->planes[i], properties.id("FB_ID"), properties.id("CRTC_ID")});
      }
      continue;
    }
    plane_ = planes->planes[i];
    Needed id(properties, "the primary plane");
    plane_ids_ = {id("FB_ID"),
                  id("CRTC_ID"),
                  id("SRC_X"),
                  id("SRC_Y"),
                  id("SRC_W"),
                  id("SRC_H"),
                  id("CRTC_X"),
                  id("CRTC_Y"),
                  id("CRTC_W"),
                  id("CRTC_H"),
                  properties.id("rotation")};
    rotations_ = properties.bits("rotation");
    modifiers_ = read_modifiers(fd_, static_cast<std::uint32_t>(properties.value("IN_FORMATS")), format);
    error = id.missing();
  }
  drmModeFreePlaneResources(planes);
  if (error.empty() && plane_ == 0) error = "no primary plane with the wanted colour format";
  return error;
}

void KmsPipe::save(const std::string& card_path, ConsoleState& console) const {
  drmModeCrtcPtr crtc = drmModeGetCrtc(fd_, crtc_);
  if (crtc == nullptr) return;
  std::snprintf(console.card, sizeof console.card, "%s", card_path.c_str());
  console.crtc = crtc_;
  console.connector = connector_;
  console.framebuffer = crtc->mode_valid != 0 ? crtc->buffer_id : 0;
  console.x = crtc->x;
  console.y = crtc->y;
  console.mode = crtc->mode;
  console.crtc_taken.store(true);
  drmModeFreeCrtc(crtc);
}

bool KmsPipe::can_turn(int quarter_turns) const {
  return plane_ != 0 && plane_ids_.rotation != 0 && (rotations_ & rotate_bit(quarter_turns)) != 0;
}

int KmsPipe::commit_mode(const drmModeModeInfo& mode, const KmsPicture& picture, std::uint32_t flags) {
  const ModeBlob blob(fd_, mode);
  if (blob.error() != 0) return blob.error();
  AtomicRequest request;
  request.set(connector_, connector_crtc_id_, crtc_);
  // A monitor whose link went bad while the mode was on needs it set anew: saying that it is good asks for
  // that.
  if (connector_link_status_ != 0) {
    request.set(connector_, connector_link_status_, DRM_MODE_LINK_STATUS_GOOD);
  }
  request.set(crtc_, crtc_mode_id_, blob.id());
  request.set(crtc_, crtc_active_, 1);
  for (const OtherPlane& other : other_planes_) {
    request.set(other.plane, other.fb_id, 0);
    request.set(other.plane, other.crtc_id, 0);
  }
  const PlaneIds& id = plane_ids_;
  request.set(plane_, id.fb_id, picture.framebuffer);
  request.set(plane_, id.crtc_id, crtc_);
  request.set(plane_, id.src_x, 0);
  request.set(plane_, id.src_y, 0);
  request.set(plane_, id.src_w, std::uint64_t{picture.width} << 16);  // 16.16 fixed point
  request.set(plane_, id.src_h, std::uint64_t{picture.height} << 16);
  request.set(plane_, id.crtc_x, 0);
  request.set(plane_, id.crtc_y, 0);
  request.set(plane_, id.crtc_w, mode.hdisplay);
  request.set(plane_, id.crtc_h, mode.vdisplay);
  if (id.rotation != 0) request.set(plane_, id.rotation, rotate_bit(picture.plane_turns));
  return request.commit(fd_, flags | DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr);
}

int KmsPipe::test(const drmModeModeInfo& mode, const KmsPicture& picture) {
  return commit_mode(mode, picture, DRM_MODE_ATOMIC_TEST_ONLY);
}

int KmsPipe::set_mode(const drmModeModeInfo& mode, const KmsPicture& picture, bool atomic) {
  if (atomic) return commit_mode(mode, picture, 0);
  drmModeModeInfo copy = mode;  // libdrm's parameter is not const
  return drmModeSetCrtc(fd_, crtc_, picture.framebuffer, 0, 0, &connector_, 1, &copy);
}

int KmsPipe::flip(const KmsPicture& picture, bool atomic, void* user) {
  if (!atomic) return drmModePageFlip(fd_, crtc_, picture.framebuffer, DRM_MODE_PAGE_FLIP_EVENT, user);
  AtomicRequest request;
  request.set(plane_, plane_ids_.fb_id, picture.framebuffer);
  return request.commit(fd_, DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, user);
}

}  // namespace karst
