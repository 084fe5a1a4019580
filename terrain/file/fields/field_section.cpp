// SPDX-License-Identifier: MIT
#include "terrain/file/fields/field_section.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "terrain/base/check.h"
#include "terrain/shading/materials.h"

namespace karst::core::field_section {
namespace {

// Offsets in the header.
constexpr std::size_t kCorner = 0;
constexpr std::size_t kBlocks = 12;
constexpr std::size_t kCellLog2 = 24;
constexpr std::size_t kSampleBits = 28;
constexpr std::size_t kStored = 32;
constexpr std::size_t kReach = 36;
constexpr std::size_t kHasMaterials = 40;
constexpr std::size_t kMaterialBlocks = 44;
constexpr std::size_t kReserved = 48;

// What a block is.
constexpr unsigned kAllAir = 0;
constexpr unsigned kAllSolid = 1;
constexpr unsigned kSamples = 2;
// What a block's materials are where they are not one code.
constexpr unsigned kOwnCodes = 255;
static_assert(material_code::kCount <= kOwnCodes && kMostFieldMaterials == kMostMaterials);

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

struct Sink {
  const void* context;
  Write write;
};

Status put(const Sink& sink, std::span<const std::byte> bytes) {
  if (bytes.empty() || sink.write(sink.context, bytes)) return {};
  return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
}

template <class Sample>
Status put_blocks(const ScalarField<Sample>& field, std::size_t count, const Sink& sink) {
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

// The code of all of a block's materials, or kOwnCodes.
unsigned filling_at(const FieldMaterials& materials, glm::ivec3 block) {
  const std::span<const std::uint8_t> codes = materials.block(block);
  if (codes.empty()) return materials.filling(block);
  const bool alike = std::ranges::all_of(codes, [&](std::uint8_t c) { return c == codes[0]; });
  return alike ? codes[0] : kOwnCodes;
}

Status put_materials(const FieldMaterials& materials, std::size_t count, const Sink& sink) {
  std::array<std::byte, 512> fillings;
  for (std::size_t first = 0; first < count; first += fillings.size()) {
    const auto piece = std::span(fillings).first(std::min(fillings.size(), count - first));
    for (std::size_t n = 0; n < piece.size(); ++n)
      piece[n] = static_cast<std::byte>(filling_at(materials, place_of(first + n, materials.blocks())));
    if (const Status status = put(sink, piece); !status.ok()) return status;
  }
  for (std::size_t n = 0; n < count; ++n) {
    const glm::ivec3 block = place_of(n, materials.blocks());
    if (filling_at(materials, block) != kOwnCodes) continue;
    if (const Status status = put(sink, std::as_bytes(materials.block(block))); !status.ok()) return status;
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
  info.has_materials = false;
  info.material_blocks = 0;
  if (!field.materials().exists()) return info;
  for (std::size_t n = 0; n < info.table_blocks(); ++n) {
    const unsigned filling = filling_at(field.materials(), place_of(n, info.blocks));
    info.has_materials = info.has_materials || filling != 0;
    info.material_blocks += filling == kOwnCodes ? 1u : 0u;
  }
  return info;
}

Status encode(const FieldBlocks& field, const void* context, Write write) {
  const Sink sink{context, write};
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
  store(header, kHasMaterials, info.has_materials ? std::uint32_t{1} : std::uint32_t{0});
  store(header, kMaterialBlocks, info.material_blocks);
  Status status = put(sink, header);
  if (status.ok())
    status = field.with([&](const auto& samples) { return put_blocks(samples, info.table_blocks(), sink); });
  if (status.ok() && info.has_materials) status = put_materials(field.materials(), info.table_blocks(), sink);
  return status;
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
  if (load<std::uint32_t>(bytes, kHasMaterials) > 1) return {"neither 0 nor 1", kHasMaterials};
  read.has_materials = load<std::uint32_t>(bytes, kHasMaterials) == 1;
  read.material_blocks = load<std::uint32_t>(bytes, kMaterialBlocks);
  if (const Status status = validate(read); !status.ok()) {
    const struct {
      std::string_view field;
      std::uint64_t offset;
    } fields[] = {{"corner", kCorner},
                  {"blocks", kBlocks},
                  {"cell_log2", kCellLog2},
                  {"sample_bits", kSampleBits},
                  {"stored", kStored},
                  {"reach_cells", kReach},
                  {"material_blocks", kMaterialBlocks}};
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

bool Decode::is_known(unsigned code) const {
  if (code >= material_code::kCount) return false;
  const MaterialMix mix = mix_of(static_cast<std::uint8_t>(code));
  return std::max(mix.first, mix.second) <= materials_;
}

// What a block's materials are: a code, or kOwnCodes.
Fault Decode::take_filling(unsigned code) {
  const auto block = static_cast<std::size_t>(at_ - samples_end(info_));
  if (block == 0) block_ = 0;
  if (code == kOwnCodes) {
    if (coded_++ == info_.material_blocks) return {"more blocks have materials than stated", at_};
  } else if (!is_known(code)) {
    return {"a block has a material that is not there", at_};
  }
  any_code_ = any_code_ || code != 0;
  const bool is_last = block + 1 == info_.table_blocks();
  if (is_last && coded_ != info_.material_blocks) return {"fewer blocks have materials than stated", at_};
  if (is_last && !any_code_) return {"all of its materials are by rules", at_};
  if (out_ == nullptr) return {};
  if (code != kOwnCodes) {
    out_->materials().fill(place(block), static_cast<std::uint8_t>(code));
  } else {
    const bool opened = !out_->materials().open(place(block)).empty();
    KARST_ASSERT(opened);  // reset() had room for info_.material_blocks
    static_cast<void>(opened);
  }
  return {};
}

Fault Decode::take_codes() {
  const auto codes = std::span(samples_).first(FieldBlocks::kBlockBytes);
  const std::uint64_t start = at_ - codes.size();
  bool alike = true;
  for (const std::byte code : codes) {
    if (!is_known(std::to_integer<unsigned>(code)))
      return {"a sample has a material that is not there", start};
    alike = alike && code == codes[0];
  }
  if (alike) return {"a block of materials is all alike", start};
  if (out_ == nullptr) return {};
  while (out_->materials().block(place(block_)).empty()) ++block_;
  std::memcpy(out_->materials().open(place(block_)).data(), codes.data(), codes.size());
  ++block_;
  return {};
}

Fault Decode::feed(std::span<const std::byte> bytes) {
  const std::uint64_t kinds_end = kHeaderBytes + info_.table_blocks();
  const std::uint64_t fillings = samples_end(info_);
  const std::uint64_t fillings_end = fillings + (info_.has_materials ? info_.table_blocks() : 0);
  const std::size_t block_bytes = FieldBlocks::kBlockBytes * static_cast<std::size_t>(info_.sample_bits / 8);
  while (!bytes.empty()) {
    if (at_ == section_bytes(info_)) return {"bytes follow the last block", at_};
    Fault fault;
    if (at_ < kinds_end || (at_ >= fillings && at_ < fillings_end)) {
      const auto byte = std::to_integer<unsigned>(bytes[0]);
      fault = at_ < kinds_end ? take_kind(byte) : take_filling(byte);
      if (fault.what != nullptr) return fault;
      bytes = bytes.subspan(1);
      ++at_;
      continue;
    }
    const bool samples = at_ < fillings;
    const std::size_t whole = samples ? block_bytes : FieldBlocks::kBlockBytes;
    const auto piece = bytes.first(std::min(bytes.size(), whole - used_));
    std::ranges::copy(piece, samples_.begin() + static_cast<std::ptrdiff_t>(used_));
    bytes = bytes.subspan(piece.size());
    used_ += piece.size();
    at_ += piece.size();
    if (used_ < whole) break;
    used_ = 0;
    fault = !samples                  ? take_codes()
            : info_.sample_bits == 16 ? take_block(out_ == nullptr ? nullptr : &out_->words())
                                      : take_block(out_ == nullptr ? nullptr : &out_->bytes());
    if (fault.what != nullptr) return fault;
  }
  return {};
}

Fault Decode::finish() const {
  return at_ == section_bytes(info_) ? Fault() : Fault{"the samples end early", at_};
}

}  // namespace karst::core::field_section
