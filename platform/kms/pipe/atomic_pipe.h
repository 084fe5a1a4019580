// SPDX-License-Identifier: MIT
// The atomic calls: connector, CRTC and primary plane change together or not at all, and the driver can be
// asked beforehand.
#pragma once

#include <cstdint>
#include <memory>

#include "platform/base/error.h"
#include "platform/kms/pipe/kms_pipe.h"
#include "platform/kms/pipe/kms_route.h"

namespace karst {

// Looks up the CRTC's primary plane and all property ids; a driver that lacks a needed one is refused: pipe
// is null then. format: of DRM_FORMAT_*, what the plane must take.
Error open_atomic_pipe(const KmsRoute& route, std::uint32_t format, std::unique_ptr<KmsPipe>& pipe);

}  // namespace karst
