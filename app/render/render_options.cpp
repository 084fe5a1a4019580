// SPDX-License-Identifier: MIT
#include "app/render/render_options.h"

#include "app/render/output_name.h"

#include <algorithm>
#include <iterator>
#include <string>

namespace karst::app {
namespace {

using Kind = ValueKind;

// Pictures are PNG, and a name that says otherwise would deceive.
Error check_extension(std::string_view name) {
  const std::size_t dot = name.find_last_of("./");
  if (dot == std::string_view::npos || name[dot] != '.') return {};
  std::string extension(name.substr(dot + 1));
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  static constexpr std::string_view kOthers[] = {"jpg", "jpeg", "jpe",  "jp2", "jxl", "webp", "avif", "heic",
                                                 "gif", "tif",  "tiff", "bmp", "tga", "exr",  "hdr",  "ppm",
                                                 "pgm", "pnm",  "pam",  "svg", "pdf", "mp4"};
  if (std::find(std::begin(kOthers), std::end(kOthers), extension) == std::end(kOthers)) return {};
  return "--output: pictures are PNG, not " + extension + "; name it " + std::string(name.substr(0, dot)) +
         ".png";
}

Error store_output(void* options, const OptionValue& value) {
  auto& render = *static_cast<RenderOptions*>(options);
  render.output = value.text;
  if (Error error = check_extension(value.text); !error.ok()) return error;
  return OutputName().parse(value.text);
}

constexpr OptionRow kOutputRows[] = {
    {.name = "output",
     .letter = 'o',
     .kind = Kind::file,
     .value = "FILE",
     .help = "the picture, a PNG; for several frames OUT_0000.png, OUT_0001.png, ..., or frame%04d.png says "
             "where the "
             "number goes",
     .store = store_output},
    {.name = "stats",
     .kind = Kind::file,
     .value = "FILE.json",
     .help = "what the frames cost and drew; - prints it",
     .store = put<&RenderOptions::stats>},
};
constexpr OptionGroup kOutputGroups[] = {{"output", kOutputRows}};
constexpr OptionPart kParts[] = {kOutputGroups, kCameraGroups, kSceneGroups};

}  // namespace

constinit const CommandSpec kRenderSpec = {
    .name = "karst render",
    .brief = "draws pictures of a world",
    .usage = "WORLD [-o OUT.png] [options]",
    .about =
        "Draws a world that karst-bake made, without a screen. All frames are complete, unless "
        "--generate-ms gives them no time.",
    .parts = kParts,
    .examples =
        "karst render canyon.karst -o canyon.png\n"
        "karst render canyon.karst -o near.png --camera 20,~2,60,35,-5 --sun 120,20 --size 1920x1080\n"
        "karst render canyon.karst --path flight.txt --stats flight.json\n"};

Error parse_render_options(std::span<const char* const> words, CommandLine& line, RenderOptions& options) {
  if (Error error = line.parse(words, kRenderSpec); !error.ok()) return error;
  if (line.wants_help()) return {};
  if (line.positional().size() != 1) {
    return line.positional().empty() ? "which WORLD?" : "more than one WORLD";
  }
  options.world = line.positional()[0];
  if (!line.has("output") && !line.has("stats")) return "nothing to do: give -o OUT.png or --stats FILE.json";
  if (line.has("camera") && line.has("path")) return "--camera and --path exclude each other";
  void* const targets[] = {&options, &options.camera, &options.scene};
  if (Error error = line.store(targets); !error.ok()) return error;
  return check_scene(options.scene, line.has("drape-repeat"));
}

}  // namespace karst::app
