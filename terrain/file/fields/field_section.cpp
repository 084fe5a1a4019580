// SPDX-License-Identifier: MIT
#include "terrain/file/fields/field_section.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "terrain/base/check.h"

namespace karst::core::field_section {
namespace {

// Offsets in the header.
constexpr std::size_t kCorner = 0;
constexpr std::size_t kBlocks = 12;
constexpr std::size_t kCellLog2 = 24;
constexpr std::size_t kSampleBits = 28;
constexpr std::size_t kStored = 32;
constexpr std::size_t kReach = 36;
constexpr std::size_t kReserved = 40;

// What a block is.
constexpr unsigned kAllAir = 0;
constexpr unsigned kAllSolid = 1;
constexpr unsigned kSamples = 2;

template <class T>
T load(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class T>
void store(std::span<std::byte> bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

glm::ivec3 place_of(std::size_t block, glm::ivec3 blocks) {
  const auto x = static_cast<std::size_t>(blocks.x), y = static_cast<std::size_t>(blocks.y);
  return {static_cast<int>(block % x), static_cast<int>(block / x % y), static_cast<int>(block / x / y)};
}

template <class Sample>
unsigned kind_of(std::span<const Sample> samples, Sample filling) {
  using Field = ScalarField<Sample>;
  if (samples.empty()) return filling == Field::kAir ? kAllAir : kAllSolid;
  if (samples[0] != Field::kAir && samples[0] != Field::kSolid) return kSamples;
  if (!std::ranges::all_of(samples, [&](Sample s) { return s == samples[0]; })) return kSamples;
  return samples[0] == Field::kAir ? kAllAir : kAllSolid;
}

template <class Sample>
unsigned kind_at(const ScalarField<Sample>& field, glm::ivec3 block) {
  return kind_of(field.block(block), field.filling(block));
}

Status put(const ByteSink& sink, std::span<const std::byte> bytes) {
  if (bytes.empty() || sink.write(sink.context, bytes)) return {};
  return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
}

template <class Sample>
Status put_blocks(const ScalarField<Sample>& field, std::size_t count, const ByteSink& sink) {
  std::array<std::byte, 512> kinds;
  for (std::size_t first = 0; first < count; first += kinds.size()) {
    const auto piece = std::span(kinds).first(std::min(kinds.size(), count - first));
    for (std::size_t n = 0; n < piece.size(); ++n)
      piece[n] = static_cast<std::byte>(kind_at(field, place_of(first + n, field.blocks())));
    if (const Status status = put(sink, piece); !status.ok()) return status;
  }
  for (std::size_t n = 0; n < count; ++n) {
    const glm::ivec3 block = place_of(n, field.blocks());
    if (kind_at(field, block) != kSamples) continue;
    if (const Status status = put(sink, std::as_bytes(field.block(block))); !status.ok()) return status;
  }
  return {};
}

}  // namespace

FieldInfo info_of(const FieldBlocks& field) {
  FieldInfo info = field.info();
  info.stored = 0;
  field.with([&](const auto& samples) {
    for (std::size_t n = 0; n < info.table_blocks(); ++n)
      info.stored += kind_at(samples, place_of(n, info.blocks)) == kSamples ? 1u : 0u;
  });
  return info;
}

Status encode(const FieldBlocks& field, const ByteSink& sink) {
  const FieldInfo info = info_of(field);
  std::array<std::byte, kHeaderBytes> header{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int n = static_cast<int>(axis);
    store(header, kCorner + axis * sizeof(std::int32_t), std::int32_t{info.corner[n]});
    store(header, kBlocks + axis * sizeof(std::int32_t), std::int32_t{info.blocks[n]});
  }
  store(header, kCellLog2, std::int32_t{info.cell_log2});
  store(header, kSampleBits, static_cast<std::uint32_t>(info.sample_bits));
  store(header, kStored, info.stored);
  store(header, kReach, info.reach_cells);
  if (const Status status = put(sink, header); !status.ok()) return status;
  return field.with([&](const auto& samples) { return put_blocks(samples, info.table_blocks(), sink); });
}

Fault decode_header(std::span<const std::byte> bytes, FieldInfo& info) {
  KARST_ASSERT(bytes.size() == kHeaderBytes);
  FieldInfo read;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int n = static_cast<int>(axis);
    read.corner[n] = load<std::int32_t>(bytes, kCorner + axis * sizeof(std::int32_t));
    read.blocks[n] = load<std::int32_t>(bytes, kBlocks + axis * sizeof(std::int32_t));
  }
  read.cell_log2 = load<std::int32_t>(bytes, kCellLog2);
  read.sample_bits = load<std::int32_t>(bytes, kSampleBits);
  read.stored = load<std::uint32_t>(bytes, kStored);
  read.reach_cells = load<float>(bytes, kReach);
  if (const Status status = validate(read); !status.ok()) {
    const struct {
      std::string_view field;
      std::uint64_t offset;
    } fields[] = {{"corner", kCorner},          {"blocks", kBlocks}, {"cell_log2", kCellLog2},
                  {"sample_bits", kSampleBits}, {"stored", kStored}, {"reach_cells", kReach}};
    for (const auto& f : fields) {
      if (f.field == status.field()) return {status.what(), f.offset};
    }
    return {status.what(), 0};
  }
  const auto rest = bytes.subspan(kReserved);
  if (!std::ranges::all_of(rest, [](std::byte b) { return b == std::byte{0}; }))
    return {"a reserved field is not 0", kReserved};
  info = read;
  return {};
}

glm::ivec3 Decode::place(std::size_t block) const {
  return place_of(block, info_.blocks);
}

Fault Decode::take_kind(unsigned kind) {
  const auto block = static_cast<std::size_t>(at_ - kHeaderBytes);
  if (kind > kSamples) return {"a block is of no kind", at_};
  if (kind == kSamples && stored_ == info_.stored) return {"more blocks have samples than stated", at_};
  if (kind == kSamples) ++stored_;
  if (block + 1 == info_.table_blocks() && stored_ != info_.stored)
    return {"fewer blocks have samples than stated", at_};
  if (out_ == nullptr || kind == kAllAir) return {};
  const auto set = [&](auto& field) {
    using Field = std::remove_reference_t<decltype(field)>;
    if (kind == kAllSolid) {
      field.fill(place(block), Field::kSolid);
    } else {
      const bool opened = !field.open(place(block)).empty();
      KARST_ASSERT(opened);  // reset() had room for info_.stored
      static_cast<void>(opened);
    }
  };
  if (info_.sample_bits == 16) {
    set(out_->words());
  } else {
    set(out_->bytes());
  }
  return {};
}

template <class Sample>
Fault Decode::take_block(ScalarField<Sample>* out) {
  std::array<Sample, ScalarField<Sample>::kBlockSamples> samples;
  std::memcpy(samples.data(), samples_.data(), sizeof samples);
  const bool alike = kind_of(std::span<const Sample>(samples), Sample{0}) != kSamples;
  if (alike) return {"a block of samples is all air or all solid", at_ - sizeof samples};
  if (out == nullptr) return {};
  while (out->block(place(block_)).empty()) ++block_;
  std::ranges::copy(samples, out->open(place(block_)).begin());
  ++block_;
  return {};
}

Fault Decode::feed(std::span<const std::byte> bytes) {
  const std::uint64_t kinds_end = kHeaderBytes + info_.table_blocks();
  for (; at_ < kinds_end && !bytes.empty(); bytes = bytes.subspan(1), ++at_) {
    if (const Fault fault = take_kind(std::to_integer<unsigned>(bytes[0])); fault.what != nullptr)
      return fault;
  }
  const std::size_t block_bytes = FieldBlocks::kBlockBytes * static_cast<std::size_t>(info_.sample_bits / 8);
  while (!bytes.empty()) {
    if (at_ == section_bytes(info_)) return {"bytes follow the last block", at_};
    const auto piece = bytes.first(std::min(bytes.size(), block_bytes - used_));
    std::ranges::copy(piece, samples_.begin() + static_cast<std::ptrdiff_t>(used_));
    bytes = bytes.subspan(piece.size());
    used_ += piece.size();
    at_ += piece.size();
    if (used_ < block_bytes) break;
    used_ = 0;
    const Fault fault = info_.sample_bits == 16 ? take_block(out_ == nullptr ? nullptr : &out_->words())
                                                : take_block(out_ == nullptr ? nullptr : &out_->bytes());
    if (fault.what != nullptr) return fault;
  }
  return {};
}

Fault Decode::finish() const {
  return at_ == section_bytes(info_) ? Fault() : Fault{"the samples end early", at_};
}

}  // namespace karst::core::field_section
