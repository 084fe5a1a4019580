// SPDX-License-Identifier: MIT
// A display card and its connectors.
#pragma once

#include <xf86drmMode.h>

#include <cstdint>
#include <string>
#include <vector>

#include "platform/base/error.h"
#include "platform/seat/seat.h"

namespace karst {

struct KmsConnector {
  std::uint32_t id = 0;
  std::string name;  // as the kernel's: "HDMI-A-1"
  bool connected = false;
  std::uint32_t crtcs = 0;  // bit n: CRTC n of the card can feed it
  int width_mm = 0;
  int height_mm = 0;
  std::vector<drmModeModeInfo> modes;
};

class KmsCard {
 public:
  KmsCard() = default;
  KmsCard(const KmsCard&) = delete;
  KmsCard& operator=(const KmsCard&) = delete;
  ~KmsCard() { close(); }

  // The error tells why the card is of no use. The seat must outlive the card.
  Error open(Seat& seat, const std::string& path);
  void close();
  bool is_open() const { return device_.fd >= 0; }

  int fd() const { return device_.fd; }
  const std::string& path() const { return path_; }
  const std::string& driver() const { return driver_; }
  bool atomic() const { return atomic_; }              // the driver has the atomic calls
  bool modifiers() const { return modifiers_; }        // framebuffers may have modifiers
  const std::string& lacks() const { return lacks_; }  // what the driver does not have; for reports
  const std::vector<std::uint32_t>& crtcs() const { return crtcs_; }

  // All connectors, asking the monitors again. Takes milliseconds to a second on real connectors.
  Error read_connectors(std::vector<KmsConnector>& out) const;

 private:
  Seat* seat_ = nullptr;
  SeatDevice device_;
  std::string path_;
  std::string driver_;
  std::string lacks_;
  std::vector<std::uint32_t> crtcs_;
  bool atomic_ = false;
  bool modifiers_ = false;
};

}  // namespace karst
