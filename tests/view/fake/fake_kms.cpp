// SPDX-License-Identifier: MIT
// A display card made of nothing, preloaded before the real libdrm, libgbm and libEGL (LD_PRELOAD): karst
// view runs on it unchanged, with a real GL driver that draws into a pbuffer. Tests tell it what happens to
// the monitor, which call fails, and read what is on the screen.
//
// Environment:
//   KARST_FAKE_STATE  file with words that are read anew whenever something is asked:
//                       connected, modes=640x480,320x240, master (somebody else is not), atomic, modifiers,
//                       rotate (the plane can turn), flips (flips are told), card (there is one), format565
//                       refuse=modifiers,atomic,640x480 (commits that fail with EINVAL),
//                       reset (the GL context is lost)
//   KARST_FAKE_UEVENT   FIFO; a byte in it is the kernel's word that something changed
//   KARST_FAKE_SCANOUT  file that holds what is on the screen: "width height\n" and RGBA rows from the top
//   KARST_FAKE_FAIL     "N" or "N:ERRNO": the Nth call of libdrm or libgbm that can fail does so, once
//   KARST_FAKE_CALLS    file that the number of calls is written to at the end, and the name of the failed
//   one
#include "tests/view/fake/fake_kms.h"

#include <dlfcn.h>
#include <drm_fourcc.h>
#include <errno.h>
#include <fcntl.h>
#include <libudev.h>
#include <stdarg.h>
#include <sys/socket.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace karst::fake {

const char* setting(const char* name) {
  const char* value = getenv(name);
  return value != nullptr ? value : "";
}

State state() {
  State result;
  std::ifstream file(setting("KARST_FAKE_STATE"));
  for (std::string word; file >> word;) {
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    std::stringstream values(equals == std::string::npos ? "" : word.substr(equals + 1));
    for (std::string value; std::getline(values, value, ',');) {
      int width = 0, height = 0;
      if (name == "refuse") result.refuse.push_back(value);
      if (name == "modes" && std::sscanf(value.c_str(), "%dx%d", &width, &height) == 2) {
        result.modes.emplace_back(width, height);
      }
    }
    result.connected |= name == "connected";
    result.master |= name == "master";
    result.atomic |= name == "atomic";
    result.modifiers |= name == "modifiers";
    result.rotate |= name == "rotate";
    result.flips |= name == "flips";
    result.card |= name == "card";
    result.reset |= name == "reset";
    result.format565 |= name == "format565";
  }
  return result;
}

namespace {
struct Calls {
  long count = 0;
  std::string failed;
  ~Calls() {
    if (*setting("KARST_FAKE_CALLS") == '\0') return;
    std::ofstream(setting("KARST_FAKE_CALLS")) << count << ' ' << failed << '\n';
  }
};
Calls calls;
}  // namespace

bool fails(const char* name) {
  ++calls.count;
  long wanted = 0;
  int error = EINVAL;
  if (std::sscanf(setting("KARST_FAKE_FAIL"), "%ld:%d", &wanted, &error) < 1 || calls.count != wanted)
    return false;
  calls.failed = name;
  std::fprintf(stderr, "fake: %s fails with %s\n", name, strerror(error));
  errno = error;
  return true;
}

std::uint32_t make_id() {
  static std::uint32_t last = 1000;
  return ++last;
}

void* real_address(const char* name) {
  return dlsym(RTLD_NEXT, name);
}

}  // namespace karst::fake

namespace {

using namespace karst::fake;

template <class T>
T* zeroed(std::size_t count = 1) {
  return static_cast<T*>(calloc(count, sizeof(T)));
}

constexpr std::uint32_t kCrtc = 31, kConnector = 41, kEncoder = 51, kPlane = 61, kCursor = 62;
constexpr std::uint32_t kModifierBlob = 900;
constexpr const char* kCard = "/dev/dri/card0";

bool refused(const State& now, const std::string& what) {
  return std::find(now.refuse.begin(), now.refuse.end(), what) != now.refuse.end();
}

// --- the card

int device_fd[2] = {-1, -1};  // ours, and the one that flip events are written to
std::map<std::uint32_t, gbm_bo*> framebuffers;
void* flip_user = nullptr;

struct Committed {
  std::uint32_t framebuffer = 0;
  std::uint64_t rotation = DRM_MODE_ROTATE_0;
  drmModeModeInfo mode{};
} committed;
std::map<std::uint32_t, drmModeModeInfo> mode_blobs;

void scan_out() {
  const std::string path = setting("KARST_FAKE_SCANOUT");
  const auto found = framebuffers.find(committed.framebuffer);
  if (path.empty() || found == framebuffers.end()) return;
  const gbm_bo& bo = *found->second;
  std::ofstream file(path + ".new", std::ios::binary);
  file << bo.width << ' ' << bo.height << '\n';
  file.write(reinterpret_cast<const char*>(bo.rgba.data()), static_cast<std::streamsize>(bo.rgba.size()));
  file.close();
  std::rename((path + ".new").c_str(), path.c_str());
}

void send_flip(void* user) {
  flip_user = user;
  const char event = 'f';
  if (state().flips && write(device_fd[1], &event, 1) != 1) abort();
}

drmModeModeInfo make_mode(int width, int height, bool preferred) {
  drmModeModeInfo mode{};
  mode.hdisplay = static_cast<std::uint16_t>(width);
  mode.vdisplay = static_cast<std::uint16_t>(height);
  mode.htotal = static_cast<std::uint16_t>(width + 100);
  mode.vtotal = static_cast<std::uint16_t>(height + 20);
  mode.clock = static_cast<std::uint32_t>(mode.htotal) * mode.vtotal * 60 / 1000;
  mode.vrefresh = 60;
  mode.type = preferred ? DRM_MODE_TYPE_PREFERRED : DRM_MODE_TYPE_DRIVER;
  return mode;
}

drmModeConnector* connector() {
  const State now = state();
  auto* result = zeroed<drmModeConnector>();
  result->connector_id = kConnector;
  result->encoder_id = kEncoder;
  result->connector_type = DRM_MODE_CONNECTOR_HDMIA;
  result->connector_type_id = 1;
  result->connection = now.connected ? DRM_MODE_CONNECTED : DRM_MODE_DISCONNECTED;
  result->count_encoders = 1;
  result->encoders = zeroed<std::uint32_t>();
  result->encoders[0] = kEncoder;
  if (!now.connected) return result;
  result->count_modes = static_cast<int>(now.modes.size());
  result->modes = zeroed<drmModeModeInfo>(now.modes.size());
  for (std::size_t i = 0; i < now.modes.size(); ++i) {
    result->modes[i] = make_mode(now.modes[i].first, now.modes[i].second, i == 0);
  }
  return result;
}

// --- properties: id = what they are to what

struct Property {
  const char* name;
  std::uint32_t object;
};
constexpr Property kProperties[] = {
    {"CRTC_ID", kConnector}, {"link-status", kConnector}, {"MODE_ID", kCrtc},  {"ACTIVE", kCrtc},
    {"type", kPlane},        {"FB_ID", kPlane},           {"CRTC_ID", kPlane}, {"SRC_X", kPlane},
    {"SRC_Y", kPlane},       {"SRC_W", kPlane},           {"SRC_H", kPlane},   {"CRTC_X", kPlane},
    {"CRTC_Y", kPlane},      {"CRTC_W", kPlane},          {"CRTC_H", kPlane},  {"rotation", kPlane},
    {"IN_FORMATS", kPlane},  {"type", kCursor},           {"FB_ID", kCursor},  {"CRTC_ID", kCursor}};

std::uint64_t property_value(const Property& property, const State& now) {
  const std::string name = property.name;
  if (name == "type") return property.object == kPlane ? DRM_PLANE_TYPE_PRIMARY : DRM_PLANE_TYPE_CURSOR;
  if (name == "CRTC_ID" && property.object == kCursor) return kCrtc;  // left behind by somebody
  if (name == "IN_FORMATS") return now.modifiers ? kModifierBlob : 0;
  return 0;
}

struct Request {
  std::vector<std::pair<std::string, std::uint64_t>> values;  // "object name"
};

int check_commit(const Request& request, const State& now, Committed& next) {
  for (const auto& [name, value] : request.values) {
    if (name == "61 FB_ID") next.framebuffer = static_cast<std::uint32_t>(value);
    if (name == "61 rotation") next.rotation = value;
    if (name == "31 MODE_ID") {
      if (mode_blobs.count(static_cast<std::uint32_t>(value)) == 0) return -EINVAL;
      next.mode = mode_blobs[static_cast<std::uint32_t>(value)];
    }
  }
  if (framebuffers.count(next.framebuffer) == 0 || next.mode.hdisplay == 0) return -EINVAL;
  if (refused(now, "atomic")) return -EINVAL;
  if (next.rotation != DRM_MODE_ROTATE_0 && !now.rotate) return -EINVAL;
  const std::string mode = std::to_string(next.mode.hdisplay) + "x" + std::to_string(next.mode.vdisplay);
  if (refused(now, mode)) return -ERANGE;
  const bool turned = (next.rotation & (DRM_MODE_ROTATE_90 | DRM_MODE_ROTATE_270)) != 0;
  const gbm_bo& bo = *framebuffers[next.framebuffer];
  const bool fits = turned ? bo.width == next.mode.vdisplay && bo.height == next.mode.hdisplay
                           : bo.width == next.mode.hdisplay && bo.height == next.mode.vdisplay;
  return fits ? 0 : -ENOSPC;
}

int open_fake(const char* path) {
  if (!state().card) {
    errno = ENOENT;
    return -1;
  }
  if (strcmp(path, kCard) != 0 ||
      socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, device_fd) != 0) {
    errno = ENOENT;
    return -1;
  }
  return device_fd[0];
}

bool is_card(const char* path) {
  return strncmp(path, "/dev/dri/", 9) == 0;
}

}  // namespace

extern "C" {

// --- the system

int open(const char* path, int flags, ...) {
  if (is_card(path)) return open_fake(path);
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return real<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}

udev_monitor* udev_monitor_new_from_netlink(udev*, const char*) {
  static int dummy;
  return reinterpret_cast<udev_monitor*>(&dummy);
}
int udev_monitor_filter_add_match_subsystem_devtype(udev_monitor*, const char*, const char*) {
  return 0;
}
int udev_monitor_enable_receiving(udev_monitor*) {
  return 0;
}
udev_monitor* udev_monitor_unref(udev_monitor*) {
  return nullptr;
}
int udev_monitor_get_fd(udev_monitor*) {
  static const int fd = real<int (*)(const char*, int, ...)>("open")(setting("KARST_FAKE_UEVENT"),
                                                                     O_RDWR | O_NONBLOCK | O_CLOEXEC);
  return fd;
}
udev_device* udev_monitor_receive_device(udev_monitor* monitor) {
  static int dummy;
  char byte = 0;
  return read(udev_monitor_get_fd(monitor), &byte, 1) == 1 ? reinterpret_cast<udev_device*>(&dummy) : nullptr;
}
udev_device* udev_device_unref(udev_device*) {
  return nullptr;
}

// --- libdrm

int drmGetDevices2(std::uint32_t, drmDevicePtr devices[], int) {
  FAIL_INT();
  if (!state().card) return 0;
  auto* device = zeroed<drmDevice>();
  device->nodes = zeroed<char*>(DRM_NODE_MAX);
  device->nodes[DRM_NODE_PRIMARY] = strdup(kCard);
  device->available_nodes = 1 << DRM_NODE_PRIMARY;
  devices[0] = device;
  return 1;
}
void drmFreeDevices(drmDevicePtr devices[], int count) {
  for (int i = 0; i < count; ++i) {
    free(devices[i]->nodes[DRM_NODE_PRIMARY]);
    free(devices[i]->nodes);
    free(devices[i]);
  }
}
drmVersionPtr drmGetVersion(int) {
  FAIL_NULL();
  auto* version = zeroed<drmVersion>();
  version->name = strdup("fake");
  version->name_len = 4;
  return version;
}
void drmFreeVersion(drmVersionPtr version) {
  free(version->name);
  free(version);
}
int drmSetClientCap(int, std::uint64_t capability, std::uint64_t) {
  FAIL_INT();
  return capability == DRM_CLIENT_CAP_ATOMIC && !state().atomic ? -EOPNOTSUPP : 0;
}
int drmGetCap(int, std::uint64_t capability, std::uint64_t* value) {
  FAIL_INT();
  *value = capability == DRM_CAP_ADDFB2_MODIFIERS && state().modifiers ? 1 : 0;
  return 0;
}
int drmIsMaster(int) {
  return state().master ? 1 : 0;
}
int drmSetMaster(int) {
  FAIL_INT();
  if (!state().card) return -ENODEV;
  return state().master ? 0 : -EBUSY;
}
int drmDropMaster(int) {
  FAIL_INT();
  return 0;
}
drmModeResPtr drmModeGetResources(int) {
  FAIL_NULL();
  errno = ENODEV;
  if (!state().card) return nullptr;
  auto* result = zeroed<drmModeRes>();
  result->count_crtcs = result->count_connectors = result->count_encoders = 1;
  result->crtcs = zeroed<std::uint32_t>();
  result->crtcs[0] = kCrtc;
  result->connectors = zeroed<std::uint32_t>();
  result->connectors[0] = kConnector;
  return result;
}
void drmModeFreeResources(drmModeResPtr p) {
  free(p->crtcs);
  free(p->connectors);
  free(p);
}
drmModeConnectorPtr drmModeGetConnector(int, std::uint32_t) {
  FAIL_NULL();
  return connector();
}
drmModeConnectorPtr drmModeGetConnectorCurrent(int, std::uint32_t) {
  FAIL_NULL();
  return connector();
}
void drmModeFreeConnector(drmModeConnectorPtr p) {
  free(p->encoders);
  free(p->modes);
  free(p);
}
const char* drmModeGetConnectorTypeName(std::uint32_t) {
  return "HDMI-A";
}
drmModeEncoderPtr drmModeGetEncoder(int, std::uint32_t) {
  FAIL_NULL();
  auto* encoder = zeroed<drmModeEncoder>();
  encoder->encoder_id = kEncoder;
  encoder->crtc_id = kCrtc;
  encoder->possible_crtcs = 1;
  return encoder;
}
void drmModeFreeEncoder(drmModeEncoderPtr p) {
  free(p);
}
drmModeCrtcPtr drmModeGetCrtc(int, std::uint32_t) {
  FAIL_NULL();
  auto* crtc = zeroed<drmModeCrtc>();
  crtc->crtc_id = kCrtc;
  crtc->mode_valid = 1;
  crtc->buffer_id = 7;  // the console's
  crtc->mode = make_mode(640, 480, true);
  return crtc;
}
void drmModeFreeCrtc(drmModeCrtcPtr p) {
  free(p);
}
drmModePlaneResPtr drmModeGetPlaneResources(int) {
  FAIL_NULL();
  auto* planes = zeroed<drmModePlaneRes>();
  planes->count_planes = 2;
  planes->planes = zeroed<std::uint32_t>(2);
  planes->planes[0] = kPlane;
  planes->planes[1] = kCursor;
  return planes;
}
void drmModeFreePlaneResources(drmModePlaneResPtr p) {
  free(p->planes);
  free(p);
}
drmModePlanePtr drmModeGetPlane(int, std::uint32_t id) {
  FAIL_NULL();
  auto* plane = zeroed<drmModePlane>();
  plane->plane_id = id;
  plane->possible_crtcs = 1;
  plane->count_formats = 2;
  plane->formats = zeroed<std::uint32_t>(2);
  plane->formats[0] = DRM_FORMAT_XRGB8888;
  plane->formats[1] = DRM_FORMAT_RGB565;
  return plane;
}
void drmModeFreePlane(drmModePlanePtr p) {
  free(p->formats);
  free(p);
}
drmModeObjectPropertiesPtr drmModeObjectGetProperties(int, std::uint32_t object, std::uint32_t) {
  FAIL_NULL();
  const State now = state();
  auto* list = zeroed<drmModeObjectProperties>();
  list->props = zeroed<std::uint32_t>(std::size(kProperties));
  list->prop_values = zeroed<std::uint64_t>(std::size(kProperties));
  for (std::uint32_t i = 0; i < std::size(kProperties); ++i) {
    if (kProperties[i].object != object) continue;
    list->props[list->count_props] = i + 1;
    list->prop_values[list->count_props++] = property_value(kProperties[i], now);
  }
  return list;
}
void drmModeFreeObjectProperties(drmModeObjectPropertiesPtr p) {
  free(p->props);
  free(p->prop_values);
  free(p);
}
drmModePropertyPtr drmModeGetProperty(int, std::uint32_t id) {
  FAIL_NULL();
  auto* property = zeroed<drmModePropertyRes>();
  property->prop_id = id;
  std::snprintf(property->name, sizeof property->name, "%s", kProperties[id - 1].name);
  if (strcmp(property->name, "rotation") == 0) {
    property->count_enums = state().rotate ? 4 : 1;
    property->enums = zeroed<drm_mode_property_enum>(4);
    for (int i = 0; i < property->count_enums; ++i) property->enums[i].value = static_cast<std::uint64_t>(i);
  }
  return property;
}
void drmModeFreeProperty(drmModePropertyPtr p) {
  free(p->enums);
  free(p);
}
drmModePropertyBlobPtr drmModeGetPropertyBlob(int, std::uint32_t) {
  FAIL_NULL();
  struct {
    drm_format_modifier_blob head;
    std::uint32_t formats[2];
    drm_format_modifier modifiers[1];
  } data{};
  data.head.version = 1;
  data.head.count_formats = 1;
  data.head.formats_offset = offsetof(decltype(data), formats);
  data.head.count_modifiers = 1;
  data.head.modifiers_offset = offsetof(decltype(data), modifiers);
  data.formats[0] = DRM_FORMAT_XRGB8888;
  data.modifiers[0].formats = 1;
  data.modifiers[0].modifier = kModifier;
  auto* blob = zeroed<drmModePropertyBlobRes>();
  blob->id = kModifierBlob;
  blob->length = sizeof data;
  blob->data = malloc(sizeof data);
  memcpy(blob->data, &data, sizeof data);
  return blob;
}
void drmModeFreePropertyBlob(drmModePropertyBlobPtr p) {
  free(p->data);
  free(p);
}
int drmModeCreatePropertyBlob(int, const void* data, std::size_t size, std::uint32_t* id) {
  FAIL_INT();
  *id = make_id();
  if (size == sizeof(drmModeModeInfo)) memcpy(&mode_blobs[*id], data, size);
  return 0;
}
int drmModeDestroyPropertyBlob(int, std::uint32_t id) {
  FAIL_INT();
  mode_blobs.erase(id);
  return 0;
}

drmModeAtomicReqPtr drmModeAtomicAlloc() {
  FAIL_NULL();
  return reinterpret_cast<drmModeAtomicReqPtr>(new Request);
}
void drmModeAtomicFree(drmModeAtomicReqPtr p) {
  delete reinterpret_cast<Request*>(p);
}
int drmModeAtomicAddProperty(drmModeAtomicReqPtr request, std::uint32_t object, std::uint32_t property,
                             std::uint64_t value) {
  FAIL_INT();
  if (property == 0 || property > std::size(kProperties)) return -EINVAL;
  if (kProperties[property - 1].object != object) return -ENOENT;
  auto& values = reinterpret_cast<Request*>(request)->values;
  values.emplace_back(std::to_string(object) + " " + kProperties[property - 1].name, value);
  return static_cast<int>(values.size());
}
int drmModeAtomicCommit(int, drmModeAtomicReqPtr request, std::uint32_t flags, void* user) {
  FAIL_INT();
  const State now = state();
  if (!now.master) return -EACCES;
  if (!now.card) return -ENODEV;
  Committed next = committed;
  const int error = check_commit(*reinterpret_cast<Request*>(request), now, next);
  if (error != 0 || (flags & DRM_MODE_ATOMIC_TEST_ONLY) != 0) return error;
  committed = next;
  scan_out();
  if ((flags & DRM_MODE_PAGE_FLIP_EVENT) != 0) send_flip(user);
  return 0;
}
int drmModeSetCrtc(int, std::uint32_t, std::uint32_t framebuffer, std::uint32_t, std::uint32_t,
                   std::uint32_t*, int, drmModeModeInfoPtr mode) {
  FAIL_INT();
  const State now = state();
  if (!now.master) return -EACCES;
  if (framebuffer == 7) {
    std::fprintf(stderr, "fake: the console is back\n");
    return 0;
  }
  if (refused(now, std::to_string(mode->hdisplay) + "x" + std::to_string(mode->vdisplay))) return -EINVAL;
  committed = {framebuffer, DRM_MODE_ROTATE_0, *mode};
  scan_out();
  return 0;
}
int drmModePageFlip(int, std::uint32_t, std::uint32_t framebuffer, std::uint32_t, void* user) {
  FAIL_INT();
  if (!state().master) return -EACCES;
  committed.framebuffer = framebuffer;
  scan_out();
  send_flip(user);
  return 0;
}
int drmHandleEvent(int fd, drmEventContextPtr handlers) {
  if (fails(__func__)) return -1;
  char event = 0;
  if (read(fd, &event, 1) == 1) handlers->page_flip_handler(fd, 0, 0, 0, flip_user);
  return 0;
}

static int add_framebuffer(const std::uint32_t handles[4], std::uint32_t* id) {
  gbm_bo* bo = buffer_of(handles[0]);
  if (bo == nullptr) return -ENOENT;
  *id = make_id();
  framebuffers[*id] = bo;
  return 0;
}
int drmModeAddFB2(int, std::uint32_t, std::uint32_t, std::uint32_t, const std::uint32_t handles[4],
                  const std::uint32_t[4], const std::uint32_t[4], std::uint32_t* id, std::uint32_t) {
  FAIL_INT();
  return add_framebuffer(handles, id);
}
int drmModeAddFB2WithModifiers(int, std::uint32_t, std::uint32_t, std::uint32_t,
                               const std::uint32_t handles[4], const std::uint32_t[4], const std::uint32_t[4],
                               const std::uint64_t[4], std::uint32_t* id, std::uint32_t) {
  FAIL_INT();
  return refused(state(), "modifiers") ? -EINVAL : add_framebuffer(handles, id);
}
int drmModeRmFB(int, std::uint32_t id) {
  FAIL_INT();
  framebuffers.erase(id);
  return 0;
}

}  // extern "C"
