// SPDX-License-Identifier: MIT
#include "bake/base/image_threads.h"

#include <OpenImageIO/imageio.h>

namespace karst::bake {

void keep_image_threads_away() {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", -1);
}

}  // namespace karst::bake
