// SPDX-License-Identifier: MIT
#include "app/screen/screen.h"

#include <cstdio>
#include <string>
#include <vector>

#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "platform/headless/headless_display.h"
#include "platform/kms/card/kms_outputs.h"
#include "platform/window/window_display.h"

namespace karst::app {

Error open_screen(const ScreenArguments& options, Display::Size window, const char* title,
                  ConsoleState& console, const LogLine& say, std::unique_ptr<Seat>& seat,
                  std::unique_ptr<Display>& display) {
  Error error;
  switch (options.output) {
    case ScreenArguments::Output::headless:
      display = open_headless_display({}, error);
      break;
    case ScreenArguments::Output::window:
      display = open_window_display(window, title, error);
      break;
    case ScreenArguments::Output::kms:
      seat = open_seat(options.seat, &console, say, error);
      if (seat != nullptr) display = open_kms_display(options.kms, *seat, console, say, error);
      break;
  }
  return error;
}

void ContextWatch::attach(const Display& display) {
  status_ = reinterpret_cast<unsigned (*)()>(display.gl_function("glGetGraphicsResetStatusKHR"));
  if (status_ == nullptr)
    status_ = reinterpret_cast<unsigned (*)()>(display.gl_function("glGetGraphicsResetStatusEXT"));
}

int supervise_screen(const ScreenArguments& options, const LogLine& say, ConsoleState*& console) {
  if (options.output != ScreenArguments::Output::kms || !options.supervise) return -1;
  if (ConsoleState* shared = share_console_state(); shared != nullptr) console = shared;
  return supervise(*console, say);
}

int print_outputs(const ScreenArguments& options, const LogLine& say) {
  // Listing takes no terminal: whoever holds the screen keeps it.
  std::unique_ptr<Seat> seat = open_device_access();
  std::vector<std::string> reasons;
  const std::vector<KmsOutputInfo> outputs = list_outputs(*seat, options.kms.card, reasons);
  for (const std::string& reason : reasons) say(reason);
  JsonWriter json;
  json.begin_array();
  for (const KmsOutputInfo& output : outputs) {
    json.begin_object()
        .field("card", std::string_view(output.card))
        .field("driver", std::string_view(output.driver));
    json.field("connector", std::string_view(output.connector)).field("connected", output.connected);
    json.field("width_mm", output.width_mm).field("height_mm", output.height_mm).key("modes").begin_array();
    if (!options.json) {
      std::printf("%s %s %s %s\n", output.card.c_str(), output.driver.c_str(), output.connector.c_str(),
                  output.connected ? "connected" : "disconnected");
    }
    for (const drmModeModeInfo& mode : output.modes) {
      const bool preferred = (mode.type & DRM_MODE_TYPE_PREFERRED) != 0;
      json.begin_object().field("width", int{mode.hdisplay}).field("height", int{mode.vdisplay});
      json.field("refresh_hz", refresh_hz(mode)).field("preferred", preferred).end_object();
      if (!options.json) std::printf("  %s%s\n", mode_text(mode).c_str(), preferred ? " preferred" : "");
    }
    json.end_array().end_object();
  }
  json.end_array();
  if (options.json) std::fputs(json.text().c_str(), stdout);
  return outputs.empty() ? kExitFailure : kExitOk;
}

}  // namespace karst::app
