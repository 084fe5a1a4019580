// SPDX-License-Identifier: MIT
// Sources: the kernel's Documentation/gpu/drm-kms.rst and drm-uapi.rst, drm_mode.h.
#include "platform/kms/pipe/atomic_pipe.h"

#include <drm_fourcc.h>
#include <xf86drm.h>

#include <cerrno>
#include <string>
#include <vector>

#include "platform/base/log.h"
#include "platform/kms/pipe/kms_properties.h"

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
  Error missing() const { return missing_; }

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

class AtomicPipe final : public KmsPipe {
 public:
  explicit AtomicPipe(const KmsRoute& route) : route_(route) {}

  Error open(std::uint32_t format) {
    KmsProperties properties;
    if (Error error = properties.read(route_.fd, route_.connector, DRM_MODE_OBJECT_CONNECTOR); !error.ok()) {
      return error;
    }
    Needed of_connector(properties, "the connector");
    connector_ids_ = {of_connector("CRTC_ID"), properties.id("link-status")};
    if (Error error = of_connector.missing(); !error.ok()) return error;
    if (Error error = properties.read(route_.fd, route_.crtc, DRM_MODE_OBJECT_CRTC); !error.ok()) {
      return error;
    }
    Needed of_crtc(properties, "the CRTC");
    crtc_ids_ = {of_crtc("MODE_ID"), of_crtc("ACTIVE")};
    if (Error error = of_crtc.missing(); !error.ok()) return error;
    return find_plane(format);
  }

  std::span<const std::uint64_t> modifiers() const override { return modifiers_; }
  bool can_turn(int quarter_turns) const override {
    return plane_ids_.rotation != 0 && (rotations_ & rotate_bit(quarter_turns)) != 0;
  }
  bool can_test() const override { return true; }
  int test(const drmModeModeInfo& mode, const KmsPicture& picture) override {
    return commit_mode(mode, picture, DRM_MODE_ATOMIC_TEST_ONLY);
  }
  int set_mode(const drmModeModeInfo& mode, const KmsPicture& picture) override {
    return commit_mode(mode, picture, 0);
  }
  const char* set_mode_text() const override { return "setting the mode"; }
  int flip(const KmsPicture& picture, void* user) override {
    AtomicRequest request;
    request.set(plane_, plane_ids_.fb_id, picture.framebuffer);
    return request.commit(route_.fd, DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, user);
  }

 private:
  // Ids of properties.
  struct ConnectorIds {
    std::uint32_t crtc_id = 0;
    std::uint32_t link_status = 0;  // 0: the driver has none
  };
  struct CrtcIds {
    std::uint32_t mode_id = 0;
    std::uint32_t active = 0;
  };
  struct PlaneIds {
    std::uint32_t fb_id, crtc_id, src_x, src_y, src_w, src_h, crtc_x, crtc_y, crtc_w, crtc_h;
    std::uint32_t rotation;  // 0: the driver has none
  };
  struct OtherPlane {
    std::uint32_t plane, fb_id, crtc_id;
  };

  Error find_plane(std::uint32_t format);
  Error look_at_plane(std::uint32_t id, std::uint32_t format);
  int commit_mode(const drmModeModeInfo& mode, const KmsPicture& picture, std::uint32_t flags);

  KmsRoute route_;
  std::uint32_t plane_ = 0;
  ConnectorIds connector_ids_;
  CrtcIds crtc_ids_;
  PlaneIds plane_ids_{};
  std::uint64_t rotations_ = 0;           // DRM_MODE_ROTATE_* that the plane can do
  std::vector<OtherPlane> other_planes_;  // that may lie above ours
  std::vector<std::uint64_t> modifiers_;
};

Error AtomicPipe::find_plane(std::uint32_t format) {
  drmModePlaneResPtr planes = drmModeGetPlaneResources(route_.fd);
  if (planes == nullptr) return errno_text("drmModeGetPlaneResources", errno);
  Error error;
  for (std::uint32_t i = 0; i < planes->count_planes && error.ok(); ++i) {
    error = look_at_plane(planes->planes[i], format);
  }
  drmModeFreePlaneResources(planes);
  if (error.ok() && plane_ == 0) error = "no primary plane with the wanted colour format";
  return error;
}

// Takes the plane if it is the one, and else notes it where it may lie above ours.
Error AtomicPipe::look_at_plane(std::uint32_t id, std::uint32_t format) {
  drmModePlanePtr plane = drmModeGetPlane(route_.fd, id);
  if (plane == nullptr) return errno_text("drmModeGetPlane", errno);
  const bool usable = (plane->possible_crtcs >> route_.crtc_index & 1) != 0;
  bool has_format = false;
  for (std::uint32_t f = 0; f < plane->count_formats; ++f) has_format |= plane->formats[f] == format;
  drmModeFreePlane(plane);
  if (!usable) return {};
  KmsProperties properties;
  if (Error error = properties.read(route_.fd, id, DRM_MODE_OBJECT_PLANE); !error.ok()) return error;
  if (properties.value("type") != DRM_PLANE_TYPE_PRIMARY || plane_ != 0 || !has_format) {
    // Only what is on our CRTC now can be in the way.
    if (properties.value("CRTC_ID") == route_.crtc && properties.id("FB_ID") != 0) {
      other_planes_.push_back({id, properties.id("FB_ID"), properties.id("CRTC_ID")});
    }
    return {};
  }
  plane_ = id;
  Needed needed(properties, "the primary plane");
  plane_ids_ = {needed("FB_ID"),  needed("CRTC_ID"), needed("SRC_X"),          needed("SRC_Y"),
                needed("SRC_W"),  needed("SRC_H"),   needed("CRTC_X"),         needed("CRTC_Y"),
                needed("CRTC_W"), needed("CRTC_H"),  properties.id("rotation")};
  rotations_ = properties.bits("rotation");
  modifiers_ = read_modifiers(route_.fd, static_cast<std::uint32_t>(properties.value("IN_FORMATS")), format);
  return needed.missing();
}

int AtomicPipe::commit_mode(const drmModeModeInfo& mode, const KmsPicture& picture, std::uint32_t flags) {
  const ModeBlob blob(route_.fd, mode);
  if (blob.error() != 0) return blob.error();
  AtomicRequest request;
  request.set(route_.connector, connector_ids_.crtc_id, route_.crtc);
  // A monitor whose link went bad while the mode was on needs it set anew: saying that it is good asks for
  // that.
  if (connector_ids_.link_status != 0) {
    request.set(route_.connector, connector_ids_.link_status, DRM_MODE_LINK_STATUS_GOOD);
  }
  request.set(route_.crtc, crtc_ids_.mode_id, blob.id());
  request.set(route_.crtc, crtc_ids_.active, 1);
  for (const OtherPlane& other : other_planes_) {
    request.set(other.plane, other.fb_id, 0);
    request.set(other.plane, other.crtc_id, 0);
  }
  const PlaneIds& id = plane_ids_;
  request.set(plane_, id.fb_id, picture.framebuffer);
  request.set(plane_, id.crtc_id, route_.crtc);
  request.set(plane_, id.src_x, 0);
  request.set(plane_, id.src_y, 0);
  request.set(plane_, id.src_w, std::uint64_t{picture.width} << 16);  // 16.16 fixed point
  request.set(plane_, id.src_h, std::uint64_t{picture.height} << 16);
  request.set(plane_, id.crtc_x, 0);
  request.set(plane_, id.crtc_y, 0);
  request.set(plane_, id.crtc_w, mode.hdisplay);
  request.set(plane_, id.crtc_h, mode.vdisplay);
  if (id.rotation != 0) request.set(plane_, id.rotation, rotate_bit(picture.plane_turns));
  return request.commit(route_.fd, flags | DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr);
}

}  // namespace

Error open_atomic_pipe(const KmsRoute& route, std::uint32_t format, std::unique_ptr<KmsPipe>& pipe) {
  pipe.reset();
  auto opened = std::make_unique<AtomicPipe>(route);
  if (Error error = opened->open(format); !error.ok()) return error;
  pipe = std::move(opened);
  return {};
}

}  // namespace karst
