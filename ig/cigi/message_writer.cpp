// SPDX-License-Identifier: MIT
#include "ig/cigi/message_writer.h"

#include "ig/cigi/tables.h"

namespace karst::cigi {
namespace {

const Layout& layout_of(const Packet& packet) {
  const ComponentControl* component = std::get_if<ComponentControl>(&packet);
  if (component != nullptr && component->short_form) return layouts().back();
  return layouts()[packet.index()];
}

}  // namespace

bool MessageWriter::write(const Packet& packet) {
  const Column column = column_of(version_);
  const Layout& layout = layout_of(packet);
  const bool host_head = std::holds_alternative<IgControl>(packet);
  const bool head = host_head || std::holds_alternative<StartOfFrame>(packet);
  const bool entity =
      std::holds_alternative<EntityControl>(packet) || std::holds_alternative<EntityPosition>(packet);
  if (!is_spoken(version_) || head != (size_ == 0) || (entity && column == kColumn3)) return false;
  const std::size_t size = layout.sizes[column];
  if (size > room()) return false;
  std::byte* at = buffer_.data() + size_;
  encode(layout, column, order_, packet, at);
  if (head) {
    const Head& place = host_head ? kIgControlHead : kStartOfFrameHead;
    store(at + place.major_at[column], 1, order_, version_.major);
    std::byte& minor = at[place.minor_at[column]];
    minor |= static_cast<std::byte>(version_.minor << 4);
    if (column == kColumn3) store(at + kSwapAt, 2, order_, kSwapMark);
  }
  size_ += size;
  return true;
}

bool MessageWriter::write_entity(const EntityControl& control, const EntityPosition& position) {
  const Column column = column_of(version_);
  const Packet first = control;
  const Packet second = position;
  if (column == kColumn4) {
    const std::size_t both = layout_of(first).sizes[column] + layout_of(second).sizes[column];
    return both <= room() && write(first) && write(second);
  }
  const std::size_t size = layout_of(first).sizes[column];
  if (!is_spoken(version_) || size_ == 0 || size > room()) return false;
  // The two tables have no bits in common but the number of the entity.
  std::byte* at = buffer_.data() + size_;
  std::array<std::byte, kMaxPacketBytes> other{};
  encode(layout_of(first), column, order_, first, at);
  encode(layout_of(second), column, order_, second, other.data());
  for (std::size_t i = 4; i < size; ++i) at[i] |= other[i];
  size_ += size;
  return true;
}

}  // namespace karst::cigi
