// SPDX-License-Identifier: MIT
// One section of a world file that is right elsewhere. Input: the world's number, the section's, then what
// the section holds; a number past the last puts a section of unknown kind behind the others.
#include "tests/fuzz/run/fuzz_target.h"
#include "tests/fuzz/run/seed_worlds.h"
#include "tests/fuzz/world_file_target.h"
#include "tests/support/world_damage.h"

namespace karst {
namespace {

using namespace core;
using namespace core::world_offsets;

// The world again, with other bytes in a section and all that lies behind it moved.
std::vector<std::byte> with_section(std::span<const std::byte> world, std::size_t changed,
                                    std::span<const std::byte> content) {
  const std::size_t before = load_at<std::uint32_t>(world, kSections);
  const std::size_t sections = std::max(before, changed + 1);
  std::vector<std::byte> file(kTable + sections * kEntry);
  std::copy_n(world.begin(), kTable + before * kEntry, file.begin());
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t entry = kTable + i * kEntry;
    if (i == before) store_at(file, entry, std::uint32_t{0x4b4e5546});  // FUNK, and not required
    const std::span<const std::byte> bytes = i == changed ? content : section_at(world, kTable + i * kEntry);
    file.resize((file.size() + 63) / 64 * 64);
    store_at(file, entry + kEntryOffset, std::uint64_t{file.size()});
    store_at(file, entry + kEntryBytes, std::uint64_t{bytes.size()});
    file.insert(file.end(), bytes.begin(), bytes.end());
  }
  store_at(file, kSections, static_cast<std::uint32_t>(sections));
  store_at(file, kHeaderBytes, static_cast<std::uint32_t>(kTable + sections * kEntry));
  store_at(file, kFileBytes, std::uint64_t{file.size()});
  fix_checksums(file);
  return file;
}

}  // namespace

void fuzz_one(std::span<const std::byte> input) {
  if (input.size() < 2) return;
  static const std::vector<std::vector<std::byte>> worlds = seed_worlds();
  const auto number = [&](std::size_t k) { return std::to_integer<std::size_t>(input[k]); };
  const std::vector<std::byte>& world = worlds[number(0) % worlds.size()];
  const std::size_t sections = load_at<std::uint32_t>(world, kSections);
  fuzz_world_file(with_section(world, std::min(number(1), sections), input.subspan(2)));
}

}  // namespace karst
