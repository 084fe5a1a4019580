// SPDX-License-Identifier: MIT
// karst_cigi_dump MAJOR MINOR little|big host|ig MESSAGES: messages of packets set by chance, a line of JSON
// each: {"bytes": hexadecimal, "packets": [{"name": ..., "fields": {name: value, ...}}, ...]}. For
// dissect_test.py.
#include "tests/cigi/samples.h"

#include <cstdio>
#include <cstdlib>

using namespace karst::cigi;

int main(int count, char** words) {
  if (count != 6) return 2;
  const Version version{static_cast<std::uint8_t>(std::atoi(words[1])),
                        static_cast<std::uint8_t>(std::atoi(words[2]))};
  const Order order = std::string(words[3]) == "big" ? Order::big : Order::little;
  const Speaker speaker = std::string(words[4]) == "ig" ? Speaker::ig : Speaker::host;
  Random random(20'260'731);
  std::vector<std::byte> buffer(kMaxMessageBytes);
  for (int message = 0; message < std::atoi(words[5]); ++message) {
    const std::vector<Packet> packets = sample_message(speaker, version, random, 1);
    MessageWriter writer(buffer, version, order);
    if (!write_all(packets, writer)) return 1;
    std::printf("{\"bytes\": \"");
    for (const std::byte byte : writer.bytes()) std::printf("%02x", std::to_integer<unsigned>(byte));
    std::printf("\", \"packets\": [");
    for (std::size_t i = 0; i < packets.size(); ++i) {
      std::printf("%s{\"name\": \"%s\", \"fields\": {", i == 0 ? "" : ", ", name_of(packets[i]));
      const char* before = "";
      for (const auto& [name, value] : text_of(packets[i], version)) {
        std::printf("%s\"%s\": %s", before, name.c_str(), value.c_str());
        before = ", ";
      }
      std::printf("}}");
    }
    std::printf("]}\n");
  }
  return 0;
}
