// SPDX-License-Identifier: MIT
// CRC-32C (Castagnoli polynomial 0x1EDC6F41, reflected; RFC 3720, appendix B.4): the checksum of the world
// file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

// The CRC-32C of some earlier bytes, whose CRC is previous, followed by bytes. 0 is the CRC of nothing.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t previous = 0);

}  // namespace karst::core
