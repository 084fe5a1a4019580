// SPDX-License-Identifier: MIT
// karst render: pictures and statistics of a world.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "app/files/output_place.h"
#include "app/files/png_file.h"
#include "app/files/whole_file.h"
#include "app/render/output_name.h"
#include "app/render/render_options.h"
#include "app/stage/camera_ground.h"
#include "app/stage/camera_view.h"
#include "app/stage/frame_statistics.h"
#include "app/stage/stage_view.h"
#include "platform/headless/headless_display.h"

namespace karst::app {
namespace {

// What the options name; none: the overview.
Error read_places(const CameraArguments& camera, std::vector<CameraPlace>& places) {
  if (camera.has_camera) places.push_back(camera.camera);
  if (camera.path_file.empty()) return {};
  WholeFile file;
  if (Error error = file.open(camera.path_file, WholeFile::kMostText); !error.ok()) return error;
  const std::string_view text = file.text();
  return parse_camera_path(text, camera.path_file, places);
}

class Render {
 public:
  explicit Render(RenderOptions options) : options_(std::move(options)) {}

  Error run() {
    if (Error error = read_places(options_.camera, places_); !error.ok()) return error;
    several_ = places_.size() > 1;
    if (Error error = check_outputs(); !error.ok()) return error;
    if (Error error = open_stage(); !error.ok()) return error;
    if (Error error = place_cameras(); !error.ok()) return error;
    if (Error error = draw_frames(); !error.ok()) return error;
    if (const unsigned code = stage_.target().take_error(); code != 0) {
      char text[64];
      std::snprintf(text, sizeof text, "OpenGL error 0x%04x; the pictures may be wrong", code);
      return text;
    }
    return write_statistics();
  }

 private:
  // Told before the work and not after it.
  Error check_outputs() {
    std::vector<NamedFile> outputs{{"--stats", options_.stats}};
    if (!options_.output.empty()) {
      if (Error error = output_.parse(options_.output); !error.ok()) return error;
      const std::size_t frames = std::max<std::size_t>(places_.size(), 1);
      for (std::size_t n = 0; n < frames; ++n) outputs.push_back({"--output", output_.frame(n, several_)});
    }
    if (Error error =
            check_outputs_apart(outputs, files_read(options_.world, options_.scene, options_.camera));
        !error.ok())
      return error;
    if (!options_.output.empty()) {
      if (Error error = check_writable(output_.frame(0, several_)); !error.ok()) return error;
    }
    return options_.stats.empty() || options_.stats == "-" ? Error() : check_writable(options_.stats);
  }

  Error open_stage() {
    if (Error error = stage_.load(options_.world, options_.scene, {.queries = 1}); !error.ok()) return error;
    Error error;
    display_ = open_headless_display({}, error);
    if (display_ == nullptr) return error;
    return stage_.attach(*display_, options_.scene.width, options_.scene.height);
  }

  Error place_cameras() {
    const WorldInfo& world = stage_.world().info();
    const PictureShape shape{options_.scene.width, options_.scene.height, options_.scene.fov_y_deg, 0,
                             stage_.reversed_depth()};
    if (places_.empty()) places_.push_back(overview(world, shape.fov_y_deg));
    CameraGround ground;
    if (Error error = ground.open(stage_.world()); !error.ok()) return error;
    view_ = stage_view(options_.scene, world);
    bool lit = false;
    bool warned = false;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const bool path = !options_.camera.path_file.empty();
      const std::string what = path ? options_.camera.path_file + ": frame " + std::to_string(i) : "--camera";
      if (const Error error = ground.stand(places_[i]); !error.ok()) return what + ": " + error.text();
      ViewState& camera = cameras_.emplace_back(view_.view);
      if (const Status status = place_view(places_[i], world, ground.axes_at(places_[i].position_m), shape,
                                           ground.clearance_m(places_[i].position_m), camera);
          !status.ok())
        return Error(what, status);
      if (!lit) turn_sun(ground.axes_at(places_[i].position_m), world, view_);
      lit = true;
      if (warned) continue;
      if (const Error rock = ground.in_rock(places_[i]); !rock.ok()) {
        print_error("karst render", what + ": " + rock.text());
        warned = true;
      }
    }
    // A camera would stand too high or too low, and nobody would know.
    if (ground.failed_reads() > 0) return options_.world + ": could not be read where a camera stands";
    return {};
  }

  Error draw_frames() {
    Progress progress("drawing", cameras_.size());
    const auto pixels =
        static_cast<std::size_t>(options_.scene.width) * static_cast<std::size_t>(options_.scene.height);
    std::vector<std::uint8_t> rgba(options_.output.empty() ? 0 : pixels * 4);
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (Error error = draw_frame(cameras_[i]); !error.ok()) return error;
      if (!options_.output.empty()) {
        if (Error error = write_picture(i, rgba); !error.ok()) return error;
      }
      progress.update(i + 1);
    }
    return {};
  }

  Error draw_frame(const ViewState& camera) {
    view_.view = camera;
    return stage_.draw(view_, records_.emplace_back());
  }

  Error write_picture(std::size_t frame, std::vector<std::uint8_t>& rgba) {
    if (const Status status = stage_.target().read_colour(rgba); !status.ok())
      return Error("picture", status);
    const std::string name = output_.frame(frame, several_);
    std::vector<std::byte> png;
    if (Error error = encode_png(rgba, options_.scene.width, options_.scene.height, png); !error.ok()) {
      return name + ": " + error.text();
    }
    return write_file_atomic(name, png);
  }

  Error write_statistics() {
    if (options_.stats.empty()) return {};
    double lookups = 0;
    if (Error error = stage_.count_lookups(view_, lookups); !error.ok()) return error;
    const std::string text = statistics_json(stage_, records_, lookups);
    if (options_.stats == "-") {
      std::fputs(text.c_str(), stdout);
      return {};
    }
    return write_file_atomic(options_.stats, std::as_bytes(std::span(text)));
  }

  RenderOptions options_;
  OutputName output_;
  bool several_ = false;
  std::unique_ptr<Display> display_;  // before stage_, whose objects are in its context
  Stage stage_;
  std::vector<CameraPlace> places_;
  std::vector<ViewState> cameras_;
  StageView view_;  // the camera aside, the same for all frames
  std::vector<FrameRecord> records_;
};

}  // namespace

int run_render(std::span<const char* const> words) {
  CommandLine line;
  RenderOptions options;
  if (const Error usage = parse_render_options(words, line, options); !usage.ok()) {
    print_error("karst render", usage.text());
    return kExitUsage;
  }
  if (line.wants_help()) {
    std::fputs(help_text(kRenderSpec).c_str(), stdout);
    return kExitOk;
  }
  if (const Error error = Render(std::move(options)).run(); !error.ok()) {
    print_error("karst render", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::app
