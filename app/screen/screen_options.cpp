// SPDX-License-Identifier: MIT
#include "app/screen/screen_options.h"

namespace karst::app {
namespace {

using Kind = ValueKind;

constexpr double kLongest_s = 1e9;  // more than a machine's life

Error store_mode(void* options, const OptionValue& value) {
  return parse_mode(value.text, value.what, static_cast<ScreenArguments*>(options)->kms.mode);
}

Error store_kms(void* options, const OptionValue& value) {
  KmsOptions& kms = static_cast<ScreenArguments*>(options)->kms;
  kms.atomic = value.text != "legacy";
  kms.legacy = value.text != "atomic";
  return {};
}

Error store_window(void* options, const OptionValue&) {
  static_cast<ScreenArguments*>(options)->output = ScreenArguments::Output::window;
  return {};
}

Error store_headless(void* options, const OptionValue&) {
  auto& view = *static_cast<ScreenArguments*>(options);
  if (view.output == ScreenArguments::Output::window) return "--window and --headless exclude each other";
  view.output = ScreenArguments::Output::headless;
  return {};
}

constexpr OptionRow kDisplayRows[] = {
    {.name = "card",
     .kind = Kind::file,
     .value = "PATH",
     .initial = "the first card with a monitor",
     .help = "/dev/dri/card1 or /dev/dri/by-path/...",
     .store = put<&ScreenArguments::kms, &KmsOptions::card>},
    {.name = "connector",
     .kind = Kind::text,
     .value = "NAME",
     .initial = "the first with a monitor",
     .help = "HDMI-A-1, ...",
     .store = put<&ScreenArguments::kms, &KmsOptions::connector>},
    {.name = "mode",
     .kind = Kind::other,
     .value = "MODE",
     .initial = "preferred",
     .help = "preferred, highest or WxH[@HZ]",
     .store = store_mode},
    {.name = "mode-fallback",
     .help = "takes another connector or mode where the wanted one is not there",
     .store = put<&ScreenArguments::kms, &KmsOptions::mode_fallback>},
    {.name = "rotate",
     .kind = Kind::word,
     .value = "DEG",
     .initial = "0",
     .words = "0 90 180 270",
     .help = "turns the picture counter-clockwise by 0, 90, 180 or 270 degrees",
     .store = put<&ScreenArguments::kms, &KmsOptions::quarter_turns>},
    {.name = "format",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "the board's, or xrgb8888",
     .words = "xrgb8888 rgb565",
     .help = "xrgb8888, or rgb565: 16 bits a pixel",
     .store = put<&ScreenArguments::kms, &KmsOptions::format>},
    {.name = "buffers",
     .kind = Kind::integer,
     .value = "N",
     .initial = "the board's, or 2",
     .min = 2,
     .max = 3,
     .help = "3 is smoother where frames are now and then late",
     .store = put<&ScreenArguments::kms, &KmsOptions::buffers>},
    {.name = "kms",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "auto",
     .words = "auto atomic legacy",
     .help = "auto, atomic, or legacy calls only",
     .store = store_kms},
    {.name = "no-modifiers",
     .help = "plain buffer layouts only",
     .store = put_false<&ScreenArguments::kms, &KmsOptions::modifiers>},
    {.name = "seat",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "auto",
     .words = "auto libseat direct",
     .help = "auto, libseat (seatd or logind), direct",
     .store = put<&ScreenArguments::seat>},
    {.name = "no-supervisor",
     .help = "nobody gives the console back when this program is killed",
     .store = put_false<&ScreenArguments::supervise>},
    {.name = "wait",
     .kind = Kind::number,
     .value = "SECONDS",
     .initial = "for ever",
     .unit = "s",
     .max = kLongest_s,
     .help = "gives up when no display comes in this time",
     .store = put<&ScreenArguments::wait_s>},
    {.name = "window",
     .help = "in a window of the desktop, where the program was built with it",
     .store = store_window},
    {.name = "headless", .help = "without any display", .store = store_headless},
    {.name = "list-outputs",
     .help = "prints connectors and modes",
     .store = put<&ScreenArguments::list_outputs>},
    {.name = "json", .help = "prints them for programs", .store = put<&ScreenArguments::json>},
};

}  // namespace

constinit const OptionGroup kScreenGroups[1] = {{"display", kDisplayRows}};

}  // namespace karst::app
