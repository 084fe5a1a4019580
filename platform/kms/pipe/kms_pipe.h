// SPDX-License-Identifier: MIT
// What sets modes and shows pictures on one connector: the atomic calls or the legacy ones, behind the same
// functions.
//
// They return 0 or a negative errno, because what an error means is for the caller to decide: EACCES and
// EPERM when another program is the master, EBUSY when a flip is under way, EINVAL, ERANGE and ENOSPC when
// the hardware cannot do it, ENODEV when it is gone.
#pragma once

#include <xf86drmMode.h>

#include <cstdint>
#include <span>

namespace karst {

// What a plane shows: a framebuffer as large as the mode, or as large as the mode turned when the plane turns
// it.
struct KmsPicture {
  std::uint32_t framebuffer = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int plane_turns = 0;  // quarter turns counter-clockwise that the plane makes
};

class KmsPipe {
 public:
  KmsPipe() = default;
  KmsPipe(const KmsPipe&) = delete;
  KmsPipe& operator=(const KmsPipe&) = delete;
  virtual ~KmsPipe() = default;

  // Layouts that the plane takes for the format; empty where it does not say.
  virtual std::span<const std::uint64_t> modifiers() const = 0;
  virtual bool can_turn(int quarter_turns) const = 0;

  // Whether test() asks the driver; else it is 0 and only set_mode() tells.
  virtual bool can_test() const = 0;
  virtual int test(const drmModeModeInfo& mode, const KmsPicture& picture) = 0;
  // Sets the mode with this picture; done on return.
  virtual int set_mode(const drmModeModeInfo& mode, const KmsPicture& picture) = 0;
  // What set_mode() does, for messages.
  virtual const char* set_mode_text() const = 0;
  // Shows another picture at the next refresh; the card's descriptor becomes readable then, and
  // drmHandleEvent() calls the handler with user.
  virtual int flip(const KmsPicture& picture, void* user) = 0;
};

}  // namespace karst
