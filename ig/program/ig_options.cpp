// SPDX-License-Identifier: MIT
#include "ig/program/ig_options.h"

#include <algorithm>
#include <array>
#include <utility>

#include "app/common/arguments.h"

namespace karst::ig {
namespace {

using app::OptionGroup;
using app::OptionPart;
using app::OptionRow;
using app::OptionValue;
using app::put;
using Kind = app::ValueKind;

IgOptions& ig_of(void* options) {
  return *static_cast<IgOptions*>(options);
}

Error store_listen(void* options, const OptionValue& value) {
  ig_of(options).listen = value.text;
  return {};
}

Error store_host(void* options, const OptionValue& value) {
  ig_of(options).host = value.text;
  return {};
}

// Two numbers or three.
Error store_anchor(void* options, const OptionValue& value) {
  std::array<double, 3> numbers{};
  const bool has_altitude = std::count(value.text.begin(), value.text.end(), ',') == 2;
  if (Error error =
          app::parse_numbers(value.text, value.what, ',', std::span(numbers).first(has_altitude ? 3 : 2));
      !error.ok())
    return error;
  if (!(numbers[0] >= -89.9 && numbers[0] <= 89.9)) return "--anchor: the latitude is not within -89.9..89.9";
  if (!(numbers[1] >= -180 && numbers[1] <= 180)) return "--anchor: the longitude is not within -180..180";
  if (!(numbers[2] >= -1e4 && numbers[2] <= 1e5)) return "--anchor: the altitude is not within -1e4..1e5 m";
  ig_of(options).anchor = Geodetic{numbers[1], numbers[0], numbers[2]};
  return {};
}

Error store_views(void* options, const OptionValue& value) {
  return parse_view_layout(value.text, value.what, ig_of(options).views);
}

Error store_box(void* options, const OptionValue& value) {
  std::array<double, 3> sides{};
  if (Error error = app::parse_numbers(value.text, value.what, ',', sides); !error.ok()) return error;
  for (const double side : sides) {
    if (!(side >= 0.01 && side <= 1e4)) return "--box: a side is not within 0.01..1e4 m";
  }
  ig_of(options).box_m = {sides[0], sides[1], sides[2]};
  return {};
}

constexpr OptionRow kHostRows[] = {
    {.name = "listen",
     .kind = Kind::text,
     .value = "[ADDRESS:]PORT",
     .initial = "8004",
     .help = "where the host's datagrams arrive: of this machine, unless an address is given",
     .store = store_listen},
    {.name = "host",
     .kind = Kind::text,
     .value = "[ADDRESS:]PORT",
     .initial = "8005",
     .help = "where the host is: on this machine, unless an address is given; what others send is not read",
     .store = store_host},
    {.name = "remote",
     .help = "allows addresses of other machines: whoever can send from the host's moves the picture",
     .store = put<&IgOptions::remote>},
    {.name = "database",
     .kind = Kind::integer,
     .value = "N",
     .initial = "1",
     .min = 1,
     .max = 127,
     .help = "the world's number to the host",
     .store = put<&IgOptions::database>},
    {.name = "anchor",
     .kind = Kind::other,
     .value = "LAT,LON[,ALT]",
     .help = "where the world's middle lies, degrees and metres; for worlds that do not know it",
     .store = store_anchor},
    {.name = "views",
     .kind = Kind::other,
     .value = "IDS",
     .initial = "0",
     .help = "numbers of the views, side by side (0,1,2), rows with / between them (0,1/2,3)",
     .store = store_views},
    {.name = "box",
     .kind = Kind::other,
     .value = "L,W,H",
     .initial = "12,10,4",
     .unit = "m",
     .help = "length, width and height of entities",
     .store = store_box},
    {.name = "rate",
     .kind = Kind::number,
     .value = "HZ",
     .initial = "60",
     .unit = "frames a second",
     .min = 1,
     .max = 1000,
     .help = "where no screen says when",
     .store = put<&IgOptions::rate_hz>},
};

constexpr OptionRow kRunRows[] = {
    {.name = "seconds",
     .kind = Kind::number,
     .value = "S",
     .unit = "s",
     .min = 1e-3,
     .max = 1e9,
     .help = "ends after this time",
     .store = put<&IgOptions::seconds>},
    {.name = "stats",
     .kind = Kind::file,
     .value = "FILE.json",
     .help = "what frames, answers and latency were; - prints it; at the end and at SIGHUP",
     .store = put<&IgOptions::stats>},
    {.name = "picture",
     .kind = Kind::file,
     .value = "FILE.png",
     .help = "the last frame, at the end",
     .store = put<&IgOptions::picture>},
    {.name = "version", .help = "prints the version"},
};

constexpr OptionGroup kHostGroups[] = {{"host", kHostRows}};
constexpr OptionGroup kRunGroups[] = {{"run", kRunRows}};
constexpr OptionPart kParts[] = {kHostGroups, app::kScreenGroups, kRunGroups, app::kSceneGroups};

}  // namespace

constinit const app::CommandSpec kIgSpec = {
    .name = "karst-ig",
    .brief = "draws a world for a simulator that drives it by CIGI 3.3 or 4.0",
    .usage = "WORLD [options]\n--list-outputs [--card PATH] [--json]",
    .about =
        "An image generator: takes the messages of a host (entities, views, sun, visibility), shows them on "
        "a "
        "bare display (DRM/KMS), in a window, or nowhere, tells each frame with Start Of Frame, and answers "
        "heights (HAT/HOT) and lines of sight (LOS). SIGTERM and Ctrl-C end it and give the console back, "
        "SIGHUP writes the statistics.",
    .parts = kParts,
    .examples =
        "karst-ig alps.karst\n"
        "karst-ig canyon.karst --anchor 36.1,-112.1,600 --listen 8004 --host 8005\n"
        "karst-ig alps.karst --remote --listen 0.0.0.0:8004 --host 192.168.1.10:8005\n"
        "karst-ig alps.karst --views 1,2,3 --connector HDMI-A-1\n"
        "karst-ig alps.karst --headless --size 320x180 --seconds 10 --stats - --picture last.png\n"};

Error parse_ig_options(std::span<const char* const> words, app::CommandLine& line, IgOptions& options) {
  if (Error error = line.parse(words, kIgSpec); !error.ok()) return error;
  if (line.wants_help() || line.has("version")) return {};
  const bool lists = line.has("list-outputs");
  const std::size_t worlds = line.positional().size();
  if (worlds > 1) return "more than one WORLD";
  if (worlds == 0 && !lists) return "which WORLD?";
  if (worlds == 1 && lists) return "--list-outputs takes no WORLD";
  if (line.has("json") && !lists) return "--json goes with --list-outputs";
  if (worlds == 1) options.world = line.positional()[0];
  void* const targets[] = {&options, static_cast<app::ScreenArguments*>(&options), &options, &options.scene};
  if (Error error = line.store(targets); !error.ok()) return error;
  if (!line.has("format") && options.scene.rgb565) options.kms.format = ColourFormat::rgb565;
  if (!line.has("buffers")) options.kms.buffers = options.scene.buffers;
  options.scene.rgb565 = options.kms.format == ColourFormat::rgb565;
  if (Error error = parse_address(options.listen, "--listen", options.listen_address); !error.ok())
    return error;
  if (Error error = parse_address(options.host, "--host", options.host_address); !error.ok()) return error;
  for (const auto& [what, address] :
       {std::pair("--listen", &options.listen_address), std::pair("--host", &options.host_address)}) {
    if (!options.remote && !is_loopback(*address))
      return std::string(what) + " is not of this machine; --remote allows it";
  }
  return check_scene(options.scene, line.has("drape-repeat"));
}

}  // namespace karst::ig
