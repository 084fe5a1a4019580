// SPDX-License-Identifier: MIT
// A message of CIGI: what is read of it is bounded and counted, and is the same when it is written and read.
#include "ig/cigi/message_reader.h"
#include "ig/cigi/message_writer.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <vector>

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  if (input.empty()) return;
  const bool host = (std::to_integer<unsigned>(input[0]) & 1u) != 0;
  const cigi::Speaker speaker = host ? cigi::Speaker::host : cigi::Speaker::ig;
  const std::span<const std::byte> message = input.subspan(1);
  cigi::MessageReader reader;
  if (!reader.open(message, speaker)) {
    cigi::Packet packet;
    must(!reader.next(packet));
    must(reader.counts().rejected == 1 && reader.counts().messages == 0);
    return;
  }
  static std::vector<cigi::Packet> packets;  // kept: most of the time went into its growing
  packets.clear();
  cigi::Packet packet;
  while (reader.next(packet)) {
    packets.push_back(packet);
    must(packets.size() <= message.size() / 8 + message.size() / 48);
  }
  must(!reader.next(packet));
  const cigi::ReadCounts& counts = reader.counts();
  must(counts.messages == 1 && counts.rejected == 0 && counts.cut <= 1 && counts.bytes == message.size());
  must(counts.packets + counts.unknown + counts.malformed <= message.size() / 8);
  must(counts.packets <= packets.size() && packets.size() <= 2 * counts.packets);

  // A first packet inside of a message begins another.
  std::vector<std::byte> buffer(message.size() + 24);
  std::size_t checked = 0;
  while (checked < packets.size()) {
    cigi::MessageWriter writer(buffer, reader.version(), reader.order());
    std::size_t end = checked;
    const auto is_head = [&](std::size_t i) {
      return std::holds_alternative<cigi::IgControl>(packets[i]) ||
             std::holds_alternative<cigi::StartOfFrame>(packets[i]);
    };
    if (!is_head(checked)) must(writer.write(host ? cigi::Packet(cigi::IgControl{}) : cigi::StartOfFrame{}));
    const std::size_t first = is_head(checked) ? 0 : 1;
    for (; end < packets.size() && (end == checked || !is_head(end)); ++end) {
      const cigi::EntityControl* control = std::get_if<cigi::EntityControl>(&packets[end]);
      if (reader.version().major == 3 && control != nullptr) {
        must(end + 1 < packets.size());  // its position comes with it
        ++end;
        must(writer.write_entity(*control, std::get<cigi::EntityPosition>(packets[end])));
      } else {
        must(writer.write(packets[end]));
      }
    }
    cigi::MessageReader again;
    must(again.open(writer.bytes(), speaker));
    for (std::size_t i = 0; i < first; ++i) must(again.next(packet));
    for (; checked < end; ++checked) must(again.next(packet) && packet == packets[checked]);
    must(!again.next(packet) && again.counts().malformed + again.counts().unknown + again.counts().cut == 0);
  }
}

}  // namespace karst
