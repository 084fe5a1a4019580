// SPDX-License-Identifier: MIT
// Messages that are damaged by chance, and bytes that are no messages: a reader ends, counts, and gives
// packets that are whole.
#include "ig/cigi/message_reader.h"
#include "tests/cigi/fields.h"
#include "tests/cigi/samples.h"

#include <gtest/gtest.h>

#include <cmath>

namespace karst::cigi {
namespace {

struct Finite {
  template <class T>
  void operator()(const char* name, const T& member, About) const {
    if constexpr (std::is_floating_point_v<T>) {
      EXPECT_TRUE(std::isfinite(member)) << name;
    } else {
      static_cast<void>(name);
    }
  }
};
struct InRange {
  template <class T>
  void operator()(const char* name, const T& member, About about) const {
    if constexpr (sizeof(T) == 1 && !std::is_same_v<T, std::int8_t>) {
      const std::string_view percent = "humidity_percent";  // bits enough for more, and nobody is hurt
      if (name != percent) {
        EXPECT_LE(static_cast<unsigned>(member), about.most) << name;
      }
    }
  }
};

// How many packets of the message were read.
std::size_t drain(MessageReader& reader, std::span<const std::byte> bytes, Speaker speaker) {
  std::size_t packets = 0;
  Packet packet;
  if (!reader.open(bytes, speaker)) return 0;
  while (reader.next(packet)) {
    ++packets;
    std::visit([](auto& value) { fields(value, Finite{}), fields(value, InRange{}); }, packet);
  }
  EXPECT_LE(packets, bytes.size() / 8 + bytes.size() / 48);
  return packets;
}

TEST(DamagedMessage, EveryReadEndsAndIsCounted) {
  Random random(7);
  std::vector<std::byte> buffer(kMaxMessageBytes);
  std::uint64_t damaged = 0, whole = 0;
  for (int round = 0; round < 20'000; ++round) {
    const Version version = kVersions[random() % 3];
    const Order order = kOrders[random() % 2];
    const Speaker speaker = random() % 2 == 0 ? Speaker::host : Speaker::ig;
    const std::vector<Packet> packets = sample_message(speaker, version, random, 1);
    MessageWriter writer(buffer, version, order);
    ASSERT_TRUE(write_all(packets, writer));
    std::vector<std::byte> bytes(writer.bytes().begin(), writer.bytes().end());
    const std::size_t changes = random() % 4;
    for (std::size_t i = 0; i < changes; ++i)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    if (random() % 8 == 0) bytes.insert(bytes.begin(), random() % 8, std::byte{0});
    bytes.shrink_to_fit();
    MessageReader reader;
    const std::size_t read = drain(reader, bytes, speaker);
    const ReadCounts& counts = reader.counts();
    EXPECT_EQ(counts.messages + counts.rejected, 1u);
    EXPECT_EQ(counts.bytes, bytes.size());
    (read == packets.size() ? whole : damaged) += 1;
  }
  EXPECT_GT(whole, 1'000u);
  EXPECT_GT(damaged, 1'000u);
}

// A flood of all kinds of bytes behind a good first packet, which is what junk needs to be read at all.
TEST(DamagedMessage, JunkBehindAFirstPacketIsSkipped) {
  Random random(8);
  std::vector<std::byte> buffer(kMaxMessageBytes);
  MessageReader reader;
  for (int round = 0; round < 2'000; ++round) {
    const Version version = kVersions[random() % 3];
    MessageWriter writer(buffer, version, kOrders[random() % 2]);
    ASSERT_TRUE(writer.write(IgControl{}));
    const std::size_t head = writer.bytes().size();
    const std::size_t size = head + random() % 1'400;
    for (std::size_t at = head; at < size; ++at) buffer[at] = static_cast<std::byte>(random());
    EXPECT_GE(drain(reader, std::span(buffer).first(size), Speaker::host), 1u);
  }
  EXPECT_EQ(reader.counts().messages, 2'000u);
  EXPECT_GT(reader.counts().cut, 1'000u);
}

}  // namespace
}  // namespace karst::cigi
