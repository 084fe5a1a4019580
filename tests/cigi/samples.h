// SPDX-License-Identifier: MIT
// Packets with all fields set by chance, and messages of them.
#pragma once

#include "ig/cigi/message_writer.h"

#include <random>
#include <string>
#include <utility>
#include <vector>

namespace karst::cigi {

using Random = std::mt19937_64;

constexpr Version kVersions[] = {{3, 2}, {3, 3}, {4, 0}};
constexpr Order kOrders[] = {Order::little, Order::big};

// "IgControl"...
const char* name_of(const Packet& packet);
Speaker speaker_of(const Packet& packet);
// A packet of Packet's alternative, as a reader gives it in that version: what is not valid is 0. Floats are
// multiples of 1/8 that decimal text of seven digits holds.
Packet sample(std::size_t alternative, Version version, Random& random);
// Name and value, as text, of the fields that the version has.
std::vector<std::pair<std::string, std::string>> text_of(const Packet& packet, Version version);
// All packets of the speaker, the first packet first and the entity's position behind its control, with the
// same number; rounds times.
std::vector<Packet> sample_message(Speaker speaker, Version version, Random& random, int rounds);
// False: the buffer is too small.
bool write_all(const std::vector<Packet>& packets, MessageWriter& writer);

}  // namespace karst::cigi
