// SPDX-License-Identifier: MIT
// Frames as zstd itself reads them.
#include "tiles/frame/zstd_frame.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace karst::tiles {
namespace {

using Bytes = std::vector<std::byte>;

// Returns the frame's length.
std::size_t expect_read(const std::vector<Bytes>& pieces, const std::string& what) {
  Bytes all;
  for (const Bytes& piece : pieces) all.insert(all.end(), piece.begin(), piece.end());
  Bytes frame(FrameWriter::most_bytes(all.size(), pieces.size()));
  FrameWriter writer(frame, all.size());
  for (std::size_t n = 0; n < pieces.size(); ++n) writer.add(pieces[n], n + 1 == pieces.size());
  EXPECT_LE(writer.bytes(), frame.size()) << what;
  Bytes read(all.size() + 1);
  const std::size_t got = ZSTD_decompress(read.data(), read.size(), frame.data(), writer.bytes());
  EXPECT_EQ(ZSTD_isError(got), 0u) << what << ": " << ZSTD_getErrorName(got);
  EXPECT_EQ(ZSTD_getFrameContentSize(frame.data(), writer.bytes()), all.size()) << what;
  read.resize(std::min(got, read.size()));
  EXPECT_TRUE(read == all) << what;
  return writer.bytes();
}

// Symbols of one of many distributions: how many there are, how steeply they get rarer, and which they are.
Bytes any_piece(std::mt19937& random, std::size_t most) {
  const std::size_t bytes = 1 + random() % most;
  const unsigned symbols = 1 + static_cast<unsigned>(random() % 256);
  const double steep = std::exp(std::uniform_real_distribution<double>(-6, 1.5)(random));
  std::vector<double> chances;
  for (unsigned n = 0; n < symbols; ++n) chances.push_back(std::exp(-std::min(steep * n, 40.0)));
  std::discrete_distribution<unsigned> draw(chances.begin(), chances.end());
  std::vector<unsigned> names(256);
  for (unsigned n = 0; n < 256; ++n) names[n] = n;
  if (random() % 2 == 0) std::shuffle(names.begin(), names.end(), random);
  Bytes piece(bytes);
  for (std::byte& byte : piece) byte = static_cast<std::byte>(names[draw(random)]);
  return piece;
}

TEST(ZstdFrame, ZstdReadsWhatIsWritten) {
  std::mt19937 random(1);
  std::size_t frames = 0, shorter = 0;
  for (int n = 0; n < 4'000; ++n) {
    std::vector<Bytes> pieces;
    std::size_t bytes = 0;
    for (int piece = 0; piece < 4 || bytes < 256; ++piece) {
      pieces.push_back(any_piece(random, random() % 8 == 0 ? 12'000 : 300));
      bytes += pieces.back().size();
    }
    ++frames;
    shorter += expect_read(pieces, std::to_string(n)) < bytes ? 1u : 0u;
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(shorter, frames / 2);
}

// Each number of symbols, at the ends of what their lengths can be told by.
TEST(ZstdFrame, EveryNumberOfSymbols) {
  for (unsigned symbols = 1; symbols <= 256; ++symbols) {
    for (const bool from_above : {false, true}) {
      for (const int kind : {0, 1, 2}) {
        Bytes piece;
        for (unsigned n = 0; n < symbols; ++n) {
          const auto count = kind == 0 ? 5u : kind == 1 ? 1 + (n < 14 ? 1u << n : 0u) / 2 : 1 + n % 7;
          const unsigned symbol = from_above ? 255 - n : n;
          piece.insert(piece.end(), count, static_cast<std::byte>(symbol));
        }
        if (piece.size() > FrameWriter::kMostPiece) piece.resize(FrameWriter::kMostPiece);
        expect_read({Bytes(256), piece}, std::to_string(symbols));
        ASSERT_FALSE(HasFailure()) << symbols << " " << from_above << " " << kind;
      }
    }
  }
}

TEST(ZstdFrame, RareSymbolsHaveCodesThatAreNotTooLong) {
  // Counts of Fibonacci make the longest codes.
  Bytes piece;
  unsigned before = 1, count = 1;
  for (unsigned symbol = 0; piece.size() + count <= 10'000; ++symbol) {
    piece.insert(piece.end(), count, static_cast<std::byte>(symbol));
    before = std::exchange(count, count + before);
  }
  EXPECT_LT(expect_read({Bytes(256), piece}, "Fibonacci"), piece.size() / 2);
}

TEST(ZstdFrame, OneByteAgainAndAgainTakesFour) {
  EXPECT_EQ(expect_read({Bytes(5'000, std::byte{7}), Bytes(1, std::byte{9})}, "runs"), 7u + 4u + 4u);
}

}  // namespace
}  // namespace karst::tiles
