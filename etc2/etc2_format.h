// SPDX-License-Identifier: MIT
// Facts of ETC2 and EAC that encoder and decoder share: tables and bit fields. All from the OpenGL ES 3.0
// specification, appendix C; table numbers are its.
//
// A block is 64 bits, the first byte highest. Texel p = x * 4 + y of a block has its index of two bits at
// bits 16 + p (high) and p (low) of an ETC2 block, and of three bits at 45 - 3 p of an EAC block.
#pragma once

#include <algorithm>
#include <cstdint>

namespace karst::etc2 {

inline constexpr int kTexels = 16;  // of a block
inline constexpr int kChannels = 3;

// Intensity modifiers of individual and differential mode (table C.4), small and large; indices 0..3 stand
// for +small, +large, -small, -large.
inline constexpr int kTables = 8;
inline constexpr int kModifiers[kTables][2] = {{2, 8},   {5, 17},  {9, 29},   {13, 42},
                                               {18, 60}, {24, 80}, {33, 106}, {47, 183}};

inline constexpr int modifier(int table, int index) {
  const int size = kModifiers[table][index & 1];
  return (index & 2) != 0 ? -size : size;
}

// Distances of T and H mode (table C.8).
inline constexpr int kDistances[8] = {3, 6, 11, 16, 23, 32, 41, 64};

// Modifiers of EAC (table C.10).
inline constexpr int kAlphaTables = 16;
inline constexpr int kAlphaModifiers[kAlphaTables][8] = {
    {-3, -6, -9, -15, 2, 5, 8, 14}, {-3, -7, -10, -13, 2, 6, 9, 12}, {-2, -5, -8, -13, 1, 4, 7, 12},
    {-2, -4, -6, -13, 1, 3, 5, 12}, {-3, -6, -8, -12, 2, 5, 7, 11},  {-3, -7, -9, -11, 2, 6, 8, 10},
    {-4, -7, -8, -11, 3, 6, 7, 10}, {-3, -5, -8, -11, 2, 4, 7, 10},  {-2, -6, -8, -10, 1, 5, 7, 9},
    {-2, -5, -8, -10, 1, 4, 7, 9},  {-2, -4, -8, -10, 1, 3, 7, 9},   {-2, -5, -7, -10, 1, 4, 6, 9},
    {-3, -4, -7, -10, 2, 3, 6, 9},  {-1, -2, -3, -10, 0, 1, 2, 9},   {-4, -6, -8, -9, 3, 5, 7, 8},
    {-3, -5, -7, -9, 2, 4, 6, 8}};

inline constexpr int clamp_byte(int v) {
  return std::clamp(v, 0, 255);
}

// A value of `bits` bits (4..7) to a byte, by repeating its highest bits.
inline constexpr int extend(int v, int bits) {
  return (v << (8 - bits) | v >> (2 * bits - 8)) & 0xff;
}

// The `count` bits whose lowest is `low`.
inline constexpr int field(std::uint64_t block, int low, int count) {
  return static_cast<int>(block >> low & ((std::uint64_t{1} << count) - 1));
}
inline constexpr int signed_field(std::uint64_t block, int low, int count) {
  const int v = field(block, low, count);
  return v >= 1 << (count - 1) ? v - (1 << count) : v;
}
inline constexpr std::uint64_t place(int v, int low) {
  return static_cast<std::uint64_t>(v) << low;
}

inline constexpr int kDifferentialBit = 33;
inline constexpr int kFlipBit = 32;

// Value of a plane at (x, y); o, h, v: the corner's bytes at (0, 0), (4, 0), (0, 4).
inline constexpr int plane_at(int o, int h, int v, int x, int y) {
  return clamp_byte((x * (h - o) + y * (v - o) + 4 * o + 2) >> 2);
}

}  // namespace karst::etc2
