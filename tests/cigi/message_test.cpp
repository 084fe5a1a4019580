// SPDX-License-Identifier: MIT
// What is written is what is read, in both versions and orders; what is not as it must be is skipped, counted
// and never read beyond.
#include "ig/cigi/message_reader.h"
#include "ig/cigi/tables.h"
#include "tests/cigi/samples.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace karst::cigi {
namespace {

std::vector<Packet> read_all(MessageReader& reader, std::span<const std::byte> bytes, Speaker speaker) {
  std::vector<Packet> packets;
  Packet packet;
  if (!reader.open(bytes, speaker)) return packets;
  while (reader.next(packet)) packets.push_back(packet);
  return packets;
}

class Message : public testing::Test {
 protected:
  // A message of one packet behind the first one.
  std::vector<std::byte> message(const Packet& packet, Version version, Order order) {
    MessageWriter writer(buffer_, version, order);
    EXPECT_TRUE(
        writer.write(speaker_of(packet) == Speaker::host ? Packet(IgControl{}) : Packet(StartOfFrame{})));
    EXPECT_TRUE(writer.write(packet));
    return {writer.bytes().begin(), writer.bytes().end()};
  }

  std::vector<std::byte> buffer_ = std::vector<std::byte>(kMaxMessageBytes);
};

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST_F(Message, EveryPacketGoesRoundInEveryVersionAndOrder) {
  Random random(1);
  for (const Version version : kVersions) {
    for (const Order order : kOrders) {
      for (const Speaker speaker : {Speaker::host, Speaker::ig}) {
        MessageReader reader;
        for (int round = 0; round < 200; ++round) {
          const std::vector<Packet> packets = sample_message(speaker, version, random, 3);
          MessageWriter writer(buffer_, version, order);
          ASSERT_TRUE(write_all(packets, writer));
          const std::vector<Packet> read = read_all(reader, writer.bytes(), speaker);
          ASSERT_EQ(read.size(), packets.size());
          for (std::size_t i = 0; i < read.size(); ++i) EXPECT_EQ(read[i], packets[i]) << name_of(packets[i]);
          EXPECT_EQ(reader.version(), version);
          EXPECT_EQ(reader.order(), order);
        }
        const ReadCounts& counts = reader.counts();
        EXPECT_EQ(counts.messages, 200u);
        EXPECT_EQ(counts.unknown + counts.malformed + counts.cut + counts.rejected, 0u);
      }
    }
  }
}

// Fields of one packet share no bits, lie inside of it and behind its header.
TEST_F(Message, FieldsDoNotOverlap) {
  for (const Layout& layout : layouts()) {
    for (const Column column : {kColumn3, kColumn4}) {
      std::array<unsigned, 256> used{};
      for (const Field& field : layout.fields) {
        const Place place = field.places[column];
        if (place.at == kAbsent) continue;
        EXPECT_GE(place.at, header_bytes(column));
        const bool bits = field.kind == Kind::bits8 || field.kind == Kind::bits16;
        std::size_t n = 1;
        if (field.kind == Kind::u16 || field.kind == Kind::bits16) n = 2;
        if (field.kind == Kind::u32 || field.kind == Kind::f32) n = 4;
        if (field.kind == Kind::f64) n = 8;
        ASSERT_LE(place.at + n, layout.sizes[column]);
        EXPECT_TRUE(bits || place.at % n == 0);
        for (std::size_t i = 0; i < n; ++i) {
          const unsigned mask = bits ? ((1u << field.width) - 1) << place.shift >> (8 * i) & 0xff : 0xff;
          EXPECT_EQ(used[place.at + i] & mask, 0u) << layout.alternative << " byte " << place.at + i;
          used[place.at + i] |= mask;
        }
      }
    }
  }
}

// By hand.
TEST_F(Message, BytesAreThoseOfTheStandard) {
  IgControl control;
  control.database = 5;
  control.mode = IgMode::operate;
  control.timestamp_valid = true;
  control.host_frame = 0x01020304;
  control.timestamp_10us = 0x11121314;
  control.last_ig_frame = 0x21222324;
  MessageWriter big(buffer_, {3, 3}, Order::big);
  ASSERT_TRUE(big.write(control));
  EXPECT_EQ(std::vector(big.bytes().begin(), big.bytes().end()),
            bytes_of({1,    24,   3,    5,    0x35, 0,    0x80, 0,    1, 2, 3, 4,
                      0x11, 0x12, 0x13, 0x14, 0x21, 0x22, 0x23, 0x24, 0, 0, 0, 0}));
  std::array<std::byte, 24> small{};
  MessageWriter little(small, {4, 0}, Order::little);
  ASSERT_TRUE(little.write(control));
  EXPECT_EQ(std::vector(little.bytes().begin(), little.bytes().end()),
            bytes_of({24,   0,    0,    0,    4,    5,    0,    5,    4, 3, 2, 1,
                      0x24, 0x23, 0x22, 0x21, 0x14, 0x13, 0x12, 0x11, 0, 0, 0, 0}));
  StartOfFrame frame;
  frame.database = -5;
  frame.paging = true;
  frame.mode = IgMode::offline;
  frame.ig_frame = 1;
  frame.timestamp_10us = 2;
  frame.last_host_frame = 3;
  MessageWriter answer(small, {4, 0}, Order::big);
  ASSERT_TRUE(answer.write(frame));
  EXPECT_EQ(std::vector(answer.bytes().begin(), answer.bytes().end()),
            bytes_of({0, 24, 255, 255, 4, 251, 0, 3, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 2, 0, 0, 0}));
}

TEST_F(Message, UnknownPacketsAreSkippedByTheirSize) {
  for (const Version version : {Version{3, 3}, Version{4, 0}}) {
    for (const Order order : kOrders) {
      HatHotRequest request;
      request.id = 77;
      std::vector<std::byte> bytes = message(request, version, order);
      std::vector<std::byte> other(64, std::byte{0xff});
      if (version.major == 3) {
        store(other.data(), 1, order, 200);
        store(other.data() + 1, 1, order, other.size());
      } else {
        store(other.data(), 2, order, other.size());
        store(other.data() + 2, 2, order, 0x1234);
      }
      bytes.insert(bytes.begin() + 24, other.begin(), other.end());
      MessageReader reader;
      const std::vector<Packet> read = read_all(reader, bytes, Speaker::host);
      ASSERT_EQ(read.size(), 2u);
      EXPECT_EQ(std::get<HatHotRequest>(read[1]).id, 77);
      EXPECT_EQ(reader.counts().unknown, 1u);
      EXPECT_EQ(reader.counts().packets, 2u);
    }
  }
}

// Answers are no packets of a host, nor requests of an IG.
TEST_F(Message, PacketsOfTheOtherSideAreUnknown) {
  std::vector<std::byte> bytes = message(HatHotRequest{}, {3, 3}, Order::little);
  const std::vector<std::byte> answer = message(LosResponse{}, {3, 3}, Order::little);
  bytes.insert(bytes.end(), answer.begin(), answer.end());
  MessageReader reader;
  EXPECT_EQ(read_all(reader, bytes, Speaker::host).size(), 2u);
  EXPECT_EQ(reader.counts().unknown, 2u);
}

TEST_F(Message, ACutMessageEndsWhereItIsCut) {
  for (const Version version : kVersions) {
    LosSegmentRequest request;
    const std::vector<std::byte> whole = message(request, version, Order::big);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // As long as it is, so that sanitizers see what reads on.
      const std::vector<std::byte> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      MessageReader reader;
      const std::vector<Packet> read = read_all(reader, part, Speaker::host);
      EXPECT_EQ(read.size(), size < 24 ? 0u : 1u);
      EXPECT_EQ(reader.counts().rejected, size < 24 ? 1u : 0u);
      EXPECT_EQ(reader.counts().cut, size > 24 ? 1u : 0u);
      EXPECT_EQ(reader.counts().bytes, size);
    }
  }
}

TEST_F(Message, SizesThatLeadNowhereEndTheMessage) {
  for (const int size : {0, 1, 2, 7, 9, 31, 255}) {
    std::vector<std::byte> bytes = message(HatHotRequest{}, {3, 3}, Order::little);
    bytes[25] = static_cast<std::byte>(size);
    MessageReader reader;
    EXPECT_EQ(read_all(reader, bytes, Speaker::host).size(), 1u) << size;
    EXPECT_EQ(reader.counts().cut, 1u) << size;
  }
  std::vector<std::byte> bytes = message(HatHotRequest{}, {3, 3}, Order::little);
  bytes[25] = std::byte{16};  // not a request's size; the next packet is what lies behind
  MessageReader reader;
  EXPECT_EQ(read_all(reader, bytes, Speaker::host).size(), 1u);
  EXPECT_EQ(reader.counts().malformed, 1u);
}

TEST_F(Message, NumbersMustBeFiniteWhereTheyCount) {
  for (const Version version : {Version{3, 3}, Version{4, 0}}) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      HatHotRequest request;
      request.longitude_deg_or_y_m = bad;
      RateControl rate;
      rate.yaw_deg_s = static_cast<float>(bad);
      ViewControl view;
      view.pitch_deg = static_cast<float>(bad);  // not valid: nobody reads it
      MessageWriter writer(buffer_, version, Order::little);
      EntityPosition position;
      position.altitude_m_or_z_m = bad;
      ASSERT_TRUE(writer.write(IgControl{}) && writer.write(request) && writer.write(rate) &&
                  writer.write(view) && writer.write_entity({}, position));
      MessageReader reader;
      const std::vector<Packet> read = read_all(reader, writer.bytes(), Speaker::host);
      // 4.0 says the entity's state in another packet than its place.
      ASSERT_EQ(read.size(), version.major == 3 ? 2u : 3u);
      EXPECT_EQ(std::get<ViewControl>(read[1]), ViewControl{});
      EXPECT_EQ(reader.counts().malformed, 3u);
    }
  }
}

TEST_F(Message, ValuesThatAFieldDoesNotHaveAreMalformed) {
  HatHotRequest request;
  request.type = HatHotType{3};
  CelestialSphereControl celestial;
  celestial.date_time_valid = true;
  celestial.hour = 24;
  WeatherControl weather;
  weather.scope = WeatherScope{3};
  EntityControl entity;
  entity.state = EntityState{3};
  for (const Version version : {Version{3, 3}, Version{4, 0}}) {
    MessageWriter writer(buffer_, version, Order::big);
    ASSERT_TRUE(writer.write(IgControl{}) && writer.write(request) && writer.write(celestial) &&
                writer.write(weather) && writer.write_entity(entity, {}));
    celestial.hour = 23;
    ASSERT_TRUE(writer.write(celestial));
    celestial.hour = 24;
    MessageReader reader;
    EXPECT_EQ(read_all(reader, writer.bytes(), Speaker::host).size(), version.major == 3 ? 2u : 3u);
    EXPECT_EQ(reader.counts().malformed, 4u);
  }
}

TEST_F(Message, TheFirstPacketSaysVersionAndOrder) {
  const auto opens = [](const std::vector<std::byte>& bytes, Speaker speaker, Version version) {
    MessageReader reader;
    const bool open = reader.open(bytes, speaker);
    EXPECT_EQ(reader.version(), version);
    EXPECT_EQ(reader.counts().rejected, open ? 0u : 1u);
    EXPECT_EQ(reader.counts().messages, open ? 1u : 0u);
    return open;
  };
  const std::vector<std::byte> good = message(HatHotRequest{}, {3, 3}, Order::big);
  EXPECT_TRUE(opens(good, Speaker::host, {3, 3}));
  EXPECT_FALSE(opens(good, Speaker::ig, {0, 0}));
  std::vector<std::byte> bad = good;
  bad[kSwapAt] = std::byte{1};  // no mark
  EXPECT_FALSE(opens(bad, Speaker::host, {3, 3}));
  bad = good;
  bad[4] = std::byte{0x15};  // 3.1
  EXPECT_FALSE(opens(bad, Speaker::host, {3, 1}));
  bad = good;
  bad[2] = std::byte{2};
  EXPECT_FALSE(opens(bad, Speaker::host, {2, 0}));
  bad = good;
  bad[2] = std::byte{4};
  EXPECT_FALSE(opens(bad, Speaker::host, {4, 3}));
  bad = message(HatHotRequest{}, {4, 0}, Order::big);
  EXPECT_TRUE(opens(bad, Speaker::host, {4, 0}));
  bad[4] = std::byte{5};
  EXPECT_FALSE(opens(bad, Speaker::host, {5, 0}));
  bad = good;
  bad.erase(bad.begin(), bad.begin() + 24);  // begins with the request
  EXPECT_FALSE(opens(bad, Speaker::host, {0, 0}));
  // A rejected message has no packets, whatever was open before.
  MessageReader reader;
  Packet packet;
  ASSERT_TRUE(reader.open(good, Speaker::host));
  EXPECT_FALSE(reader.open(bad, Speaker::host));
  EXPECT_FALSE(reader.next(packet));
}

// Two messages in one datagram: as one, if they are of one version and order.
TEST_F(Message, AnotherFirstPacketInsideMustBeOfTheSameKind) {
  for (const Order second : kOrders) {
    std::vector<std::byte> bytes = message(HatHotRequest{}, {3, 3}, Order::little);
    const std::vector<std::byte> more = message(HatHotRequest{}, {3, 3}, second);
    bytes.insert(bytes.end(), more.begin(), more.end());
    MessageReader reader;
    const std::size_t read = read_all(reader, bytes, Speaker::host).size();
    EXPECT_EQ(reader.counts().malformed, second == Order::little ? 0u : 1u);
    EXPECT_EQ(read, second == Order::little ? 4u : 3u);
  }
}

TEST_F(Message, AWriterWritesWholePacketsOrNothing) {
  for (const Version version : {Version{3, 3}, Version{4, 0}}) {
    Random random(3);
    const std::vector<Packet> packets = sample_message(Speaker::host, version, random, 1);
    for (std::size_t size = 0; size < 700; ++size) {
      std::vector<std::byte> room(size);
      MessageWriter writer(room, version, Order::little);
      const bool all = write_all(packets, writer);
      EXPECT_LE(writer.bytes().size(), size);
      MessageReader reader;
      const std::size_t read = read_all(reader, writer.bytes(), Speaker::host).size();
      EXPECT_EQ(reader.counts().cut + reader.counts().malformed, 0u);
      EXPECT_EQ(read == packets.size(), all);
    }
  }
  MessageWriter writer(buffer_, {3, 3}, Order::little);
  EXPECT_FALSE(writer.write(HatHotRequest{}));
  EXPECT_FALSE(writer.write_entity({}, {}));
  EXPECT_TRUE(writer.write(IgControl{}));
  EXPECT_FALSE(writer.write(IgControl{}));
  EXPECT_FALSE(writer.write(EntityControl{}));
  EXPECT_FALSE(writer.write(EntityPosition{}));
  EXPECT_EQ(writer.bytes().size(), 24u);
  writer.clear();
  EXPECT_EQ(writer.room(), kMaxMessageBytes);
  MessageWriter unspoken(buffer_, {3, 1}, Order::little);
  EXPECT_FALSE(unspoken.write(IgControl{}));
}

}  // namespace
}  // namespace karst::cigi
