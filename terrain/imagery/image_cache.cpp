// SPDX-License-Identifier: MIT
#include "terrain/imagery/image_cache.h"

namespace karst::core {

void ImageCache::reset(const ImageSource& source, NodeKey root, const TilePlace& root_place) {
  source_ = source;
  root_ = root;
  root_place_ = root_place;
  slots_.reset();
  ++version_;
}

void ImageCache::forget() {
  slots_.forget();
  ++version_;
}

bool ImageCache::wait() {
  if (counts().under_way == 0) return false;
  if (source_.wait != nullptr) source_.wait(source_.context);
  return true;
}

bool ImageCache::poll(std::int32_t& layer, ImageArrival& out) {
  while (counts().under_way > 0) {
    const TileSource::Answer answer = source_.poll(source_.context, out);
    if (answer == TileSource::Answer::none) return false;
    layer = slots_.take(out.key, answer);
    if (layer < 0) continue;
    children_[static_cast<std::size_t>(layer)] = out.children;
    ++version_;
    return true;
  }
  return false;
}

}  // namespace karst::core
