// SPDX-License-Identifier: MIT
// Headless contexts: the real one, and every way of failing, with a table of fake EGL functions.
#include "platform/headless/headless_display.h"

#include <cstring>
#include <string>

#include <GLES3/gl3.h>
#include <gtest/gtest.h>

namespace karst::core {
namespace {

// What the fake EGL offers, and what was left open in it.
struct FakeEgl {
  std::string client_extensions;
  const char* client_version = nullptr;
  std::string display_extensions;
  EGLint minor = 5;
  bool initialize_ok = true;
  bool context_ok = true;
  bool current_ok = true;
  EGLint devices = 0;
  EGLint configs = 1;

  EGLenum platform = 0;  // last asked for
  int displays_open = 0;
  int contexts_open = 0;
  int surfaces_open = 0;
  EGLConfig context_config = nullptr;
  EGLint flag_name = EGL_NONE;  // third attribute of the context
};
FakeEgl fake;

int object;  // something whose address is not null
EGLDisplay fake_display() {
  return &object;
}

EGLDisplay EGLAPIENTRY get_platform_display(EGLenum platform, void* /*native*/,
                                            const EGLint* /*attributes*/) {
  fake.platform = platform;
  return fake_display();
}
EGLBoolean EGLAPIENTRY query_devices(EGLint max, EGLDeviceEXT* devices, EGLint* count) {
  *count = fake.devices;
  for (EGLint i = 0; i < fake.devices && i < max; ++i) devices[i] = &object;
  return EGL_TRUE;
}
EGLint EGLAPIENTRY get_error() {
  return EGL_NOT_INITIALIZED;
}

__eglMustCastToProperFunctionPointerType EGLAPIENTRY get_proc_address(const char* name) {
  using Function = __eglMustCastToProperFunctionPointerType;
  if (std::strcmp(name, "eglGetPlatformDisplayEXT") == 0 || std::strcmp(name, "eglGetPlatformDisplay") == 0) {
    return reinterpret_cast<Function>(get_platform_display);
  }
  if (std::strcmp(name, "eglQueryDevicesEXT") == 0) return reinterpret_cast<Function>(query_devices);
  return nullptr;
}

EglApi fake_api() {
  return {
      .get_proc_address = get_proc_address,
      .query_string = [](EGLDisplay display, EGLint name) -> const char* {
        if (display != EGL_NO_DISPLAY) return fake.display_extensions.c_str();
        return name == EGL_VERSION ? fake.client_version : fake.client_extensions.c_str();
      },
      .get_error = get_error,
      .initialize = [](EGLDisplay, EGLint* major, EGLint* minor) -> EGLBoolean {
        if (!fake.initialize_ok) return EGL_FALSE;
        *major = 1;
        *minor = fake.minor;
        ++fake.displays_open;
        return EGL_TRUE;
      },
      .terminate = [](EGLDisplay) -> EGLBoolean {
        --fake.displays_open;
        return EGL_TRUE;
      },
      .bind_api = [](EGLenum) -> EGLBoolean { return EGL_TRUE; },
      .choose_config = [](EGLDisplay, const EGLint*, EGLConfig* config, EGLint, EGLint* count) -> EGLBoolean {
        *count = fake.configs;
        *config = fake.configs > 0 ? &object : nullptr;
        return EGL_TRUE;
      },
      .create_context = [](EGLDisplay, EGLConfig config, EGLContext, const EGLint* attributes) -> EGLContext {
        fake.context_config = config;
        fake.flag_name = attributes[2];
        if (!fake.context_ok) return EGL_NO_CONTEXT;
        ++fake.contexts_open;
        return &object;
      },
      .destroy_context = [](EGLDisplay, EGLContext) -> EGLBoolean {
        --fake.contexts_open;
        return EGL_TRUE;
      },
      .create_pbuffer_surface = [](EGLDisplay, EGLConfig, const EGLint*) -> EGLSurface {
        ++fake.surfaces_open;
        return &object;
      },
      .destroy_surface = [](EGLDisplay, EGLSurface) -> EGLBoolean {
        --fake.surfaces_open;
        return EGL_TRUE;
      },
      .make_current = [](EGLDisplay, EGLSurface, EGLSurface, EGLContext context) -> EGLBoolean {
        return context == EGL_NO_CONTEXT || fake.current_ok ? EGL_TRUE : EGL_FALSE;
      },
  };
}

constexpr const char* kAllClient =
    "EGL_EXT_platform_base EGL_MESA_platform_surfaceless EGL_EXT_platform_device EGL_EXT_device_enumeration";
constexpr const char* kAllDisplay =
    "EGL_KHR_no_config_context EGL_KHR_surfaceless_context EGL_KHR_get_all_proc_addresses";

class HeadlessDisplay : public testing::Test {
 protected:
  void SetUp() override {
    fake = FakeEgl();
    fake.client_extensions = kAllClient;
    fake.display_extensions = kAllDisplay;
  }
  void TearDown() override {
    EXPECT_EQ(fake.displays_open, 0);
    EXPECT_EQ(fake.contexts_open, 0);
    EXPECT_EQ(fake.surfaces_open, 0);
  }
  Error error_;
};

TEST_F(HeadlessDisplay, RealContextIsGles3) {
  auto display = open_headless_display({.debug = true}, error_);
  ASSERT_NE(display, nullptr) << error_.text();
  EXPECT_EQ(error_.text(), "");
  EXPECT_EQ(display->make_current().text(), "");
  EXPECT_EQ(display->present().text(), "");
  const auto get_string = reinterpret_cast<decltype(&glGetString)>(display->gl_function("glGetString"));
  ASSERT_NE(get_string, nullptr);
  const std::string version = reinterpret_cast<const char*>(get_string(GL_VERSION));
  EXPECT_EQ(version.substr(0, 12), "OpenGL ES 3.") << version;
}

TEST_F(HeadlessDisplay, SurfacelessIsPreferred) {
  auto display = open_headless_display({}, error_, fake_api());
  ASSERT_NE(display, nullptr) << error_.text();
  EXPECT_EQ(display->name(), "surfaceless");
  EXPECT_EQ(fake.platform, EGLenum{EGL_PLATFORM_SURFACELESS_MESA});
  EXPECT_EQ(fake.context_config, EGL_NO_CONFIG_KHR);
  EXPECT_EQ(fake.surfaces_open, 0);
}

TEST_F(HeadlessDisplay, DeviceIsTheFallback) {
  fake.client_extensions = "EGL_EXT_platform_base EGL_EXT_platform_device EGL_EXT_device_base";
  fake.devices = 2;
  auto display = open_headless_display({}, error_, fake_api());
  ASSERT_NE(display, nullptr) << error_.text();
  EXPECT_EQ(display->name(), "EGL device 0");
  EXPECT_EQ(fake.platform, EGLenum{EGL_PLATFORM_DEVICE_EXT});
}

TEST_F(HeadlessDisplay, Egl15WithoutTheExtensionWillDo) {
  fake.client_extensions = "EGL_MESA_platform_surfaceless";
  fake.client_version = "1.5";
  EXPECT_NE(open_headless_display({}, error_, fake_api()), nullptr) << error_.text();
}

TEST_F(HeadlessDisplay, PbufferWhereADriverInsistsOnASurface) {
  fake.display_extensions = "";
  auto display = open_headless_display({}, error_, fake_api());
  ASSERT_NE(display, nullptr) << error_.text();
  EXPECT_EQ(fake.surfaces_open, 1);
  EXPECT_NE(fake.context_config, EGL_NO_CONFIG_KHR);
}

TEST_F(HeadlessDisplay, DebugContextOnlyWhereThereIsSuch) {
  { auto display = open_headless_display({.debug = true}, error_, fake_api()); }
  EXPECT_EQ(fake.flag_name, EGL_CONTEXT_OPENGL_DEBUG);
  fake.minor = 4;
  { auto display = open_headless_display({.debug = true}, error_, fake_api()); }
  EXPECT_EQ(fake.flag_name, EGL_NONE);
  fake.display_extensions = std::string(kAllDisplay) + " EGL_KHR_create_context";
  { auto display = open_headless_display({.debug = true}, error_, fake_api()); }
  EXPECT_EQ(fake.flag_name, EGL_CONTEXT_FLAGS_KHR);
  { auto display = open_headless_display({}, error_, fake_api()); }
  EXPECT_EQ(fake.flag_name, EGL_NONE);
}

TEST_F(HeadlessDisplay, ErrorNamesEverythingThatIsMissing) {
  fake.client_extensions = "";
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_EQ(error_.text(),
            "no OpenGL ES 3.0 context; tried surfaceless (EGL_MESA_platform_surfaceless): libEGL has neither "
            "EGL_EXT_platform_base nor EGL 1.5; device (EGL_EXT_platform_device): libEGL has neither "
            "EGL_EXT_platform_base nor EGL 1.5");
  fake.client_extensions = "EGL_EXT_platform_base EGL_EXT_platform_device";
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_EQ(
      error_.text(),
      "no OpenGL ES 3.0 context; tried surfaceless (EGL_MESA_platform_surfaceless): not offered by libEGL; "
      "device (EGL_EXT_platform_device): EGL_EXT_device_enumeration is not offered");
}

TEST_F(HeadlessDisplay, ErrorNamesEveryDeviceThatFails) {
  fake.initialize_ok = false;
  fake.devices = 2;
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_EQ(
      error_.text(),
      "no OpenGL ES 3.0 context; tried surfaceless (EGL_MESA_platform_surfaceless): eglInitialize: "
      "EGL_NOT_INITIALIZED; EGL device 0: eglInitialize: EGL_NOT_INITIALIZED; EGL device 1: eglInitialize: "
      "EGL_NOT_INITIALIZED");
  fake.devices = 0;
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_NE(error_.text().find("there is no device"), std::string::npos) << error_.text();
}

TEST_F(HeadlessDisplay, LaterStepsFailCleanly) {
  fake.context_ok = false;
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_NE(error_.text().find("eglCreateContext for OpenGL ES 3"), std::string::npos) << error_.text();
  fake.context_ok = true;
  fake.current_ok = false;
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_NE(error_.text().find("eglMakeCurrent"), std::string::npos) << error_.text();
  fake.current_ok = true;
  fake.display_extensions = "";
  fake.configs = 0;
  EXPECT_EQ(open_headless_display({}, error_, fake_api()), nullptr);
  EXPECT_NE(error_.text().find("no configuration for OpenGL ES 3"), std::string::npos) << error_.text();
}

}  // namespace
}  // namespace karst::core
