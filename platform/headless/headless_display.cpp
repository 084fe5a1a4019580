// SPDX-License-Identifier: MIT
// Sources: EGL 1.5; EGL_EXT_platform_base, EGL_MESA_platform_surfaceless, EGL_EXT_platform_device,
// EGL_EXT_device_enumeration, EGL_KHR_no_config_context, EGL_KHR_surfaceless_context, EGL_KHR_create_context.
#include "platform/headless/headless_display.h"

#include <dlfcn.h>

#include <array>
#include <string_view>
#include <utility>

namespace karst {
namespace {

constexpr EGLint kMaxDevices = 16;  // machines with more exist; the first that works is taken

Error egl_failure(const EglApi& egl, const char* function) {
  return std::string(function) + ": " + egl_error_name(egl.get_error());
}

class HeadlessDisplay final : public Display {
 public:
  HeadlessDisplay(const EglApi& egl, std::string name) : egl_(egl), name_(std::move(name)) {}

  ~HeadlessDisplay() override {
    if (display_ == EGL_NO_DISPLAY) return;
    egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (surface_ != EGL_NO_SURFACE) egl_.destroy_surface(display_, surface_);
    if (context_ != EGL_NO_CONTEXT) egl_.destroy_context(display_, context_);
    egl_.terminate(display_);
    if (gles_library_ != nullptr) dlclose(gles_library_);
  }

  // display: from eglGetPlatformDisplay, not initialised yet. Whatever step fails, the destructor cleans up.
  Error open(EGLDisplay display, const HeadlessOptions& options) {
    EGLint major = 0;
    EGLint minor = 0;
    if (egl_.initialize(display, &major, &minor) == EGL_FALSE) return egl_failure(egl_, "eglInitialize");
    display_ = display;
    const bool egl_1_5 = major > 1 || minor >= 5;
    const char* extensions = egl_.query_string(display_, EGL_EXTENSIONS);
    if (egl_.bind_api(EGL_OPENGL_ES_API) == EGL_FALSE) return egl_failure(egl_, "eglBindAPI");

    const bool surfaceless = has_extension(extensions, "EGL_KHR_surfaceless_context");
    const bool no_config = has_extension(extensions, "EGL_KHR_no_config_context") ||
                           has_extension(extensions, "EGL_MESA_configless_context");
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!surfaceless || !no_config) {
      if (Error error = choose_config(!surfaceless, config); !error.ok()) return error;
    }
    const bool debug = options.debug && (egl_1_5 || has_extension(extensions, "EGL_KHR_create_context"));
    if (Error error = create_context(config, debug, egl_1_5); !error.ok()) return error;
    if (!surfaceless) {
      if (Error error = create_pbuffer(config); !error.ok()) return error;
    }
    // Before EGL 1.5, eglGetProcAddress need not know core functions: these are exports of libGLESv2 then.
    if (!egl_1_5 && !has_extension(extensions, "EGL_KHR_get_all_proc_addresses")) {
      gles_library_ = dlopen("libGLESv2.so.2", RTLD_LAZY | RTLD_LOCAL);
    }
    return make_current();
  }

  Error make_current() override {
    if (egl_.make_current(display_, surface_, surface_, context_) == EGL_FALSE) {
      return egl_failure(egl_, "eglMakeCurrent");
    }
    return {};
  }

  Size size() const override { return {}; }
  Error present() override { return {}; }
  const std::string& name() const override { return name_; }

  GlFunction gl_function(const char* name) const override {
    if (gles_library_ != nullptr) {
      if (void* symbol = dlsym(gles_library_, name); symbol != nullptr) {
        return reinterpret_cast<GlFunction>(symbol);
      }
    }
    return egl_.get_proc_address(name);
  }

 private:
  Error choose_config(bool needs_pbuffer, EGLConfig& config) {
    const EGLint attributes[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE,
                                 needs_pbuffer ? EGL_PBUFFER_BIT : 0, EGL_NONE};
    EGLint count = 0;
    if (egl_.choose_config(display_, attributes, &config, 1, &count) == EGL_FALSE) {
      return egl_failure(egl_, "eglChooseConfig");
    }
    if (count == 0) return "eglChooseConfig: no configuration for OpenGL ES 3";
    return {};
  }

  Error create_context(EGLConfig config, bool debug, bool egl_1_5) {
    std::array<EGLint, 5> attributes = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE, EGL_NONE, EGL_NONE};
    if (debug) {
      attributes[2] = egl_1_5 ? EGL_CONTEXT_OPENGL_DEBUG : EGL_CONTEXT_FLAGS_KHR;
      // NOLINTNEXTLINE(bugprone-branch-clone): two names whose numbers are the same
      attributes[3] = egl_1_5 ? EGL_TRUE : EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR;
    }
    context_ = egl_.create_context(display_, config, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT) return egl_failure(egl_, "eglCreateContext for OpenGL ES 3");
    return {};
  }

  // Drawing goes to framebuffer objects; the surface is only there because the driver insists on one.
  Error create_pbuffer(EGLConfig config) {
    const EGLint attributes[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface_ = egl_.create_pbuffer_surface(display_, config, attributes);
    if (surface_ == EGL_NO_SURFACE) return egl_failure(egl_, "eglCreatePbufferSurface");
    return {};
  }

  EglApi egl_;
  std::string name_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
  void* gles_library_ = nullptr;
};

// One way to reach a display, and, while trying, the reasons why ways failed.
class Search {
 public:
  Search(const HeadlessOptions& options, const EglApi& egl) : options_(options), egl_(egl) {
    extensions_ = egl_.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    // The extension's function and that of EGL 1.5 differ only in the type of attributes, of which none are
    // passed.
    const char* version = egl_.query_string(EGL_NO_DISPLAY, EGL_VERSION);
    if (has_extension(extensions_, "EGL_EXT_platform_base")) {
      load_get_platform_display("eglGetPlatformDisplayEXT");
    } else if (version != nullptr && std::string_view(version).starts_with("1.5")) {
      load_get_platform_display("eglGetPlatformDisplay");
    }
  }

  std::unique_ptr<Display> surfaceless() {
    const std::string name = "surfaceless (EGL_MESA_platform_surfaceless)";
    if (!offered("EGL_MESA_platform_surfaceless", name)) return nullptr;
    return try_platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, name, "surfaceless");
  }

  std::unique_ptr<Display> device() {
    const std::string name = "device (EGL_EXT_platform_device)";
    if (!offered("EGL_EXT_platform_device", name)) return nullptr;
    if (!has_extension(extensions_, "EGL_EXT_device_enumeration") &&
        !has_extension(extensions_, "EGL_EXT_device_base")) {
      note(name, "EGL_EXT_device_enumeration is not offered");
      return nullptr;
    }
    const auto query_devices =
        reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl_.get_proc_address("eglQueryDevicesEXT"));
    std::array<EGLDeviceEXT, kMaxDevices> devices{};
    EGLint count = 0;
    if (query_devices == nullptr || query_devices(kMaxDevices, devices.data(), &count) == EGL_FALSE) {
      note(name, query_devices == nullptr ? Error("no eglQueryDevicesEXT")
                                          : egl_failure(egl_, "eglQueryDevicesEXT"));
      return nullptr;
    }
    if (count == 0) note(name, "there is no device");
    for (EGLint i = 0; i < count && i < kMaxDevices; ++i) {
      const std::string device_name = "EGL device " + std::to_string(i);
      auto display = try_platform(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], device_name,
                                  device_name);
      if (display != nullptr) return display;
    }
    return nullptr;
  }

  const std::string& reasons() const { return reasons_; }

 private:
  void load_get_platform_display(const char* name) {
    get_platform_display_ = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(egl_.get_proc_address(name));
  }

  bool offered(const char* extension, const std::string& name) {
    if (get_platform_display_ == nullptr) {
      note(name, "libEGL has neither EGL_EXT_platform_base nor EGL 1.5");
    } else if (!has_extension(extensions_, extension)) {
      note(name, "not offered by libEGL");
    } else {
      return true;
    }
    return false;
  }

  std::unique_ptr<Display> try_platform(EGLenum platform, void* native, const std::string& tried_name,
                                        const std::string& display_name) {
    const EGLDisplay egl_display = get_platform_display_(platform, native, nullptr);
    if (egl_display == EGL_NO_DISPLAY) {
      note(tried_name, egl_failure(egl_, "eglGetPlatformDisplayEXT"));
      return nullptr;
    }
    auto display = std::make_unique<HeadlessDisplay>(egl_, display_name);
    if (const Error error = display->open(egl_display, options_); !error.ok()) {
      note(tried_name, error);
      return nullptr;
    }
    return display;
  }

  void note(const std::string& name, const Error& reason) {
    if (!reasons_.empty()) reasons_ += "; ";
    reasons_ += name + ": " + reason.text();
  }

  HeadlessOptions options_;
  EglApi egl_;
  const char* extensions_ = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display_ = nullptr;
  std::string reasons_;
};

}  // namespace

std::unique_ptr<Display> open_headless_display(const HeadlessOptions& options, Error& error,
                                               const EglApi& egl) {
  Search search(options, egl);
  std::unique_ptr<Display> display = search.surfaceless();
  if (display == nullptr) display = search.device();
  error = display != nullptr ? Error() : "no OpenGL ES 3.0 context; tried " + search.reasons();
  return display;
}

}  // namespace karst
