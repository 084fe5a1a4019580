// SPDX-License-Identifier: MIT
#include "app/view/camera_source.h"

#include <algorithm>

#include "app/files/whole_file.h"
#include "app/stage/camera_view.h"
#include "app/view/start_place.h"
#include "platform/base/clock.h"

namespace karst::app {
namespace {

constexpr double kStepVoxels = 0.5;       // what a walker climbs without noticing
constexpr double kStartSpeed_m_s = 10.0;  // of whoever stands on the ground

}  // namespace

Error CameraSource::open() {
  if (!options_.poses.empty()) {
    if (Error error = poses_.open(options_.poses, messages_); !error.ok()) return error;
  }
  if (options_.camera.path_file.empty()) return {};
  WholeFile file;
  if (Error error = file.open(options_.camera.path_file, WholeFile::kMostText); !error.ok()) return error;
  const std::string_view text = file.text();
  return parse_camera_path(text, options_.camera.path_file, path_);
}

Error CameraSource::begin(World& world) {
  const WorldInfo& info = world_ = world.info();
  if (Error error = ground_.open(world); !error.ok()) return error;
  for (std::size_t i = 0; i < path_.size(); ++i) {
    if (Error error = settle(path_[i]); !error.ok())
      return options_.camera.path_file + ": frame " + std::to_string(i) + ": " + error.text();
  }
  NavigatorSettings settings;
  settings.mode = options_.navigate;
  settings.overview = overview(info, options_.scene.fov_y_deg);
  const auto [low, high] = shown_box(info);
  settings.centre_m = {(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
  // Across what is shown in ten seconds.
  settings.speed_m_s = settings.overview_speed_m_s = 0.1 * std::max(high.x - low.x, high.z - low.z);
  // A pose that came before the world was there and has no ground to stand on is left out, like later ones.
  if (posed_) posed_ = take(place_);
  std::string what = "--poses";
  if (!posed_) {
    what = path_.empty() ? "--camera" : options_.camera.path_file;
    place_ = options_.camera.has_camera ? options_.camera.camera : settings.overview;
    if (!path_.empty()) place_ = path_.front();
    const bool by_hand = options_.navigate == NavigatorMode::fly || options_.navigate == NavigatorMode::walk;
    if (by_hand && !options_.camera.has_camera && path_.empty() && options_.poses.empty() &&
        start_place(ground_, world, settings.eye_height_m, place_))
      settings.speed_m_s = std::min(settings.speed_m_s, kStartSpeed_m_s);
    if (const Error error = settle(place_); !error.ok()) return what + ": " + error.text();
  }
  posed_ = false;
  if (const Error rock = ground_.in_rock(place_); !rock.ok())
    messages_.say(what + ": " + rock.text(), now_ns());
  settings.start = place_;
  if (info.basis != Basis::plane) {
    settings.axes_at = [this](const glm::dvec3& place_m) {
      const LocalAxes axes = ground_.axes_at(place_m);
      return glm::dmat3(axes.east.x, axes.east.y, axes.east.z, axes.up.x, axes.up.y, axes.up.z, -axes.north.x,
                        -axes.north.y, -axes.north.z);
    };
  }
  settings.ground_m = [this, step_m = kStepVoxels * info.voxel_size_m](const glm::dvec3& place_m) {
    return ground_.below_m(place_m, step_m);
  };
  navigator_.emplace(std::move(settings));
  place_ = navigator_->place();
  return {};
}

bool CameraSource::take_poses() {
  CameraPlace pose;
  if (!poses_.dispatch(pose) || !take(pose)) return false;
  posed_ = true;
  if (navigator_) navigator_->set_place(place_);
  return true;
}

// A pose that counts from the ground waits for the world: begin() comes with it.
bool CameraSource::take(CameraPlace pose) {
  if (ground_.is_open()) {
    if (const Error error = settle(pose); !error.ok()) {
      if (messages_.may_say(now_ns(), Messages::About::others)) messages_.print("--poses: " + error.text());
      return false;
    }
  }
  place_ = pose;
  return true;
}

Error CameraSource::settle(CameraPlace& place) {
  CameraPlace settled = place;
  if (Error error = ground_.stand(settled); !error.ok()) return error;
  if (const Status status = check_place(settled, world_); !status.ok()) return {"camera", status};
  place = settled;
  return {};
}

bool CameraSource::handle(const InputEvent& event, std::int64_t now) {
  if (!navigator_) return false;
  const bool was_moving = navigator_->moving();
  const bool changed = navigator_->handle(event);
  if (!was_moving && navigator_->moving()) moved_at_ = now;
  if (changed && !posed_) {
    if (check_place(navigator_->place(), world_).ok()) {
      place_ = navigator_->place();
    } else {
      navigator_->set_place(place_);
    }
  }
  return changed;
}

bool CameraSource::moving() const {
  const bool plays = options_.loop ? !path_.empty() : path_frame_ + 1 < path_.size();
  return plays || navigator_->moving();
}

const CameraPlace& CameraSource::advance(double world_s, std::int64_t now, double fixed_s) {
  if (!play_path(world_s) && navigator_->moving()) {
    navigator_->advance(fixed_s >= 0 ? fixed_s : ms_between(moved_at_, now) * 1e-3);
    moved_at_ = now;
    // At the end of the reach it stands still.
    if (check_place(navigator_->place(), world_).ok()) {
      place_ = navigator_->place();
    } else {
      navigator_->set_place(place_);
    }
  }
  posed_ = false;
  return place_;
}

bool CameraSource::play_path(double world_s) {
  if (path_.empty()) return false;
  const double line = world_s * options_.path_hz + 1e-6;
  auto frame = static_cast<std::size_t>(line);
  if (options_.loop) frame %= path_.size();
  path_frame_ = std::min(frame, path_.size() - 1);
  place_ = path_[path_frame_];
  navigator_->set_place(place_);
  return true;
}

}  // namespace karst::app
