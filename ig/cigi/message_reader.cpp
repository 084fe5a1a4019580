// SPDX-License-Identifier: MIT
#include "ig/cigi/message_reader.h"

#include "ig/cigi/tables.h"

#include <algorithm>

namespace karst::cigi {
namespace {

// What a message's first packet says.
struct Opening {
  Version version{0, 0};
  Order order = Order::little;
  bool complete = false;  // the packet is whole, and of a version that is read
};

Opening opening(std::span<const std::byte> message, Speaker speaker) {
  Opening result;
  if (message.size() < kHeadBytes) return result;
  const std::byte* at = message.data();
  const Head& head = speaker == Speaker::host ? kIgControlHead : kStartOfFrameHead;
  const Layout& layout = *std::find_if(layouts().begin(), layouts().end(),
                                       [&](const Layout& row) { return row.speaker == speaker; });
  const auto version = [&](Column column) {
    const std::uint64_t minor = load(at + head.minor_at[column], 1, Order::little) >> 4;
    return Version{static_cast<std::uint8_t>(at[head.major_at[column]]), static_cast<std::uint8_t>(minor)};
  };
  // Versions 1 to 3 begin with the packet's number, 4 with its size, which is never that number. 1 and 2 have
  // no minor version, and other sizes.
  if (load(at, 1, Order::little) == layout.ids[kColumn3]) {
    result.version = version(kColumn3);
    if (result.version.major < 3) result.version.minor = 0;
    const std::uint64_t mark = load(at + kSwapAt, 2, Order::little);
    result.order = mark == kSwapMark ? Order::little : Order::big;
    const bool marked = mark == kSwapMark || load(at + kSwapAt, 2, Order::big) == kSwapMark;
    result.complete = result.version.major == 3 && is_spoken(result.version) && marked &&
                      load(at + 1, 1, Order::little) == kHeadBytes;
    return result;
  }
  for (const Order order : {Order::little, Order::big}) {
    if (load(at, 2, order) != kHeadBytes || load(at + 2, 2, order) != layout.ids[kColumn4]) continue;
    result.version = version(kColumn4);
    result.order = order;
    result.complete = result.version.major >= 4 && is_spoken(result.version);
  }
  return result;
}

bool is_head(const Layout& layout) {
  return layout.ids[kColumn3] == 1 || layout.ids[kColumn3] == 101;
}

}  // namespace

bool MessageReader::open(std::span<const std::byte> message, Speaker speaker) {
  counts_.bytes += message.size();
  const Opening found = opening(message, speaker);
  version_ = found.version;
  order_ = found.order;
  speaker_ = speaker;
  rest_ = {};
  second_ = {};
  if (!found.complete) {
    ++counts_.rejected;
    return false;
  }
  ++counts_.messages;
  rest_ = message;
  return true;
}

bool MessageReader::next(Packet& packet) {
  const Column column = column_of(version_);
  const auto find = [&](std::uint64_t id, std::size_t after) -> const Layout* {
    for (const Layout& row : layouts().subspan(after)) {
      if (row.speaker == speaker_ && row.ids[column] == id) return &row;
    }
    return nullptr;
  };
  constexpr std::size_t kPositionRow = 2;
  if (!second_.empty()) {
    const std::byte* at = second_.data();
    second_ = {};
    return decode(layouts()[kPositionRow], column, order_, at, packet);  // next() saw that it can be read
  }
  while (!rest_.empty()) {
    const std::byte* at = rest_.data();
    std::uint64_t id = 0, size = 0;
    if (rest_.size() >= header_bytes(column)) {
      id = column == kColumn3 ? load(at, 1, order_) : load(at + 2, 2, order_);
      size = column == kColumn3 ? load(at + 1, 1, order_) : load(at, 2, order_);
    }
    if (size == 0 || size % 8 != 0 ||
        size > rest_.size()) {  // packets are multiples of 8; the next is not found
      ++counts_.cut;
      rest_ = {};
      return false;
    }
    rest_ = rest_.subspan(size);
    const Layout* layout = find(id, 0);
    if (layout == nullptr) {
      ++counts_.unknown;
      continue;
    }
    bool good = size == layout->sizes[column];
    if (good && is_head(*layout)) {
      const Opening again = opening({at, kHeadBytes}, speaker_);
      good = again.complete && again.version == version_ && again.order == order_;
    }
    const bool twice = column == kColumn3 && layout == &layouts()[kPositionRow - 1];
    if (good && twice) good = decode(layouts()[kPositionRow], column, order_, at, packet);
    if (!good || !decode(*layout, column, order_, at, packet)) {
      ++counts_.malformed;
      continue;
    }
    if (twice) second_ = {at, size};
    ++counts_.packets;
    return true;
  }
  return false;
}

}  // namespace karst::cigi
