// SPDX-License-Identifier: MIT
// A world that is edited through the public headers, and all that it is, as one number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/library/host.h"
#include "tests/support/edited_world.h"

#include "karst/edit.h"
#include "scene/world/world_object.h"

namespace karst::test {

// A world that is edited, with all that a file of it holds.
class LiveWorld {
 public:
  LiveWorld(const Needs& needs, std::vector<std::byte> file)
      : host(needs, {.axes = Axes::east_up_south}, std::move(file)) {
    EXPECT_TRUE(host.world->take_editor(editor).ok());
  }
  ~LiveWorld() { host.world->release(editor); }
  LiveWorld(const LiveWorld&) = delete;
  LiveWorld& operator=(const LiveWorld&) = delete;

  core::WorldObject& object() const { return static_cast<core::WorldObject&>(*host.world); }
  core::World& world() const { return object().terrain.world; }
  std::vector<std::byte> saved() const { return saved_by(*editor); }
  void settle() const { object().editor.settle(1e9); }

  std::uint64_t state() const {
    settle();
    std::string all;
    const auto add = [&](const auto& value) {
      all.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const auto& [key, facts] : facts_of(world())) {
      add(key.bits());
      all.append(reinterpret_cast<const char*>(facts.bytes.data()), facts.bytes.size());
    }
    std::map<core::PatchKey, std::uint8_t> painted;
    for (std::size_t n = 0; n < world().parts().size(); ++n) {
      const core::WorldPart& part = world().parts()[n];
      for (core::PatchId id = 0; id < part.patches(); ++id) {
        if (part.surface.is_free(id)) continue;
        painted[core::key_of(part.surface, id, static_cast<std::uint32_t>(n))] =
            world().material_overrides()[part.first + id];
      }
    }
    for (const auto& [key, override] : painted) add(override);
    for (const std::byte texel : world().painted_texels()) add(texel);
    add(world().materials().blend_map.materials);
    core::EditGround& ground = *object().ground_edits;
    const core::GroundInfo& info = ground.info();
    for (std::int64_t k = 0; k < info.samples[1]; ++k) {
      for (std::int64_t i = 0; i < info.samples[0]; ++i) {
        std::int32_t height = 0;
        EXPECT_TRUE(ground.height(i, k, height).ok());
        add(height);
      }
    }
    for (const std::byte byte : saved_by(*editor)) add(byte);
    return std::hash<std::string>()(all);
  }

  HostWorld host;
  Editor* editor = nullptr;
};

// An edit that is not refused.
inline EditResult apply(LiveWorld& live, const karst::Edit& edit) {
  EditResult result;
  const Status status = live.editor->apply(edit, result);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
  return result;
}

}  // namespace karst::test
