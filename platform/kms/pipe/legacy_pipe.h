// SPDX-License-Identifier: MIT
// The legacy calls: a CRTC shows a framebuffer, and nothing can be asked beforehand.
#pragma once

#include <memory>

#include "platform/kms/pipe/kms_pipe.h"
#include "platform/kms/pipe/kms_route.h"

namespace karst {

std::unique_ptr<KmsPipe> make_legacy_pipe(const KmsRoute& route);

}  // namespace karst
