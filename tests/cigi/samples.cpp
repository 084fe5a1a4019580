// SPDX-License-Identifier: MIT
#include "tests/cigi/samples.h"

#include "tests/cigi/fields.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <type_traits>

namespace karst::cigi {
namespace {

constexpr std::size_t kAlternatives = std::variant_size_v<Packet>;

bool has(Version version, In in) {
  return in == In::both || (in == In::v4) == (version.major >= 4);
}

struct Fill {
  Version version;
  Random& random;

  template <class T>
  void operator()(const char*, T& member, About about) const {
    if (!has(version, about.in)) return;  // as it was made
    const std::uint64_t value = random();
    if (!about.valid) {
      member = T{};
    } else if constexpr (std::is_floating_point_v<T>) {
      member = (static_cast<T>(value % 100'001) - T{50'000}) / T{8};
    } else if constexpr (std::is_same_v<T, bool>) {
      member = value % 2 != 0;
    } else {
      member = static_cast<T>(about.most == ~0u ? value : value % (about.most + 1ull));
    }
  }
};

struct Tell {
  Version version;
  std::vector<std::pair<std::string, std::string>>& out;

  template <class T>
  void operator()(const char* name, const T& member, About about) const {
    if (!has(version, about.in)) return;
    std::array<char, 40> text{};
    if constexpr (std::is_floating_point_v<T>) {
      std::snprintf(text.data(), text.size(), "%.17g", static_cast<double>(member));
    } else {
      std::snprintf(text.data(), text.size(), "%lld", static_cast<long long>(member));
    }
    out.emplace_back(name, text.data());
  }
};

template <std::size_t I = 0>
Packet make(std::size_t alternative) {
  if constexpr (I + 1 < kAlternatives) {
    if (alternative != I) return make<I + 1>(alternative);
  }
  return std::variant_alternative_t<I, Packet>{};
}

}  // namespace

const char* name_of(const Packet& packet) {
  constexpr std::array<const char*, kAlternatives> kNames = {
      "IgControl",        "EntityControl",          "EntityPosition",    "RateControl",
      "ComponentControl", "CelestialSphereControl", "AtmosphereControl", "WeatherControl",
      "ViewControl",      "ViewDefinition",         "HatHotRequest",     "LosSegmentRequest",
      "LosVectorRequest", "StartOfFrame",           "HatHotResponse",    "HatHotExtendedResponse",
      "LosResponse",      "LosExtendedResponse"};
  return kNames[packet.index()];
}

Speaker speaker_of(const Packet& packet) {
  return packet.index() >= Packet(StartOfFrame{}).index() ? Speaker::ig : Speaker::host;
}

Packet sample(std::size_t alternative, Version version, Random& random) {
  Packet packet = make(alternative);
  std::visit([&](auto& value) { fields(value, Fill{version, random}); }, packet);
  if (version == Version{3, 2}) {  // has 16 classes of components, and no smoothing
    if (ComponentControl* component = std::get_if<ComponentControl>(&packet))
      component->component_class %= 16;
    if (IgControl* control = std::get_if<IgControl>(&packet)) control->smoothing = false;
    if (EntityControl* control = std::get_if<EntityControl>(&packet)) control->smoothing = false;
  }
  return packet;
}

std::vector<std::pair<std::string, std::string>> text_of(const Packet& packet, Version version) {
  std::vector<std::pair<std::string, std::string>> out;
  Packet copy = packet;
  std::visit([&](auto& value) { fields(value, Tell{version, out}); }, copy);
  return out;
}

std::vector<Packet> sample_message(Speaker speaker, Version version, Random& random, int rounds) {
  std::vector<Packet> packets;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < kAlternatives; ++i) {
      Packet packet = sample(i, version, random);
      const bool head =
          std::holds_alternative<IgControl>(packet) || std::holds_alternative<StartOfFrame>(packet);
      if (speaker_of(packet) != speaker || (head && round > 0)) continue;
      if (EntityPosition* position = std::get_if<EntityPosition>(&packet)) {
        position->entity = std::get<EntityControl>(packets.back()).entity;
      }
      packets.push_back(packet);
    }
  }
  return packets;
}

bool write_all(const std::vector<Packet>& packets, MessageWriter& writer) {
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const EntityControl* control = std::get_if<EntityControl>(&packets[i]);
    if (control == nullptr) {
      if (!writer.write(packets[i])) return false;
    } else if (!writer.write_entity(*control, std::get<EntityPosition>(packets[++i]))) {
      return false;
    }
  }
  return true;
}

}  // namespace karst::cigi
