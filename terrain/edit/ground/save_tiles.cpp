// SPDX-License-Identifier: MIT
#include "terrain/edit/ground/save_tiles.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "terrain/base/check.h"
#include "terrain/base/checksum.h"

namespace karst::core {
namespace {

// The last bytes of tiles that an editor has added to: this, and u64 where its own begin.
constexpr char kMark[] = "ADDED AT";
constexpr std::size_t kMarkBytes = 8;
constexpr std::size_t kEndBytes = kMarkBytes + sizeof(std::uint64_t);

bool is_same(const Tile& a, const Tile& b) {
  return std::memcmp(a.heights, b.heights, sizeof a.heights) == 0 &&
         std::equal(std::begin(a.nodes), std::end(a.nodes), std::begin(b.nodes));
}

}  // namespace

// Where in the file's tiles those that an editor added begin; any place is right that is behind all images.
Status SaveTiles::find_kept() {
  const std::uint64_t all = in_.reader.tile_bytes();
  added_.kept = all;
  if (all < kEndBytes) return {};
  std::array<std::byte, kEndBytes> end;
  if (const Status status = in_.reader.read_tile({all - kEndBytes, kEndBytes, 0}, end); !status.ok())
    return status;
  if (std::memcmp(end.data(), kMark, kMarkBytes) != 0) return {};
  std::uint64_t begin = 0;
  std::memcpy(&begin, end.data() + kMarkBytes, sizeof begin);
  const TilePlace& image = in_.reader.root_image();
  if (begin <= all - kEndBytes && begin >= image.offset + image.bytes) added_.kept = begin;
  return {};
}

Status SaveTiles::put(Pass& pass, std::span<const std::byte> bytes) const {
  pass.end += bytes.size();
  if (pass.sink == nullptr) {
    pass.crc = crc32c(bytes, pass.crc);
    return {};
  }
  if (pass.sink->write(pass.sink->context, bytes)) return {};
  return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
}

Status SaveTiles::visit_children(NodeKey key, std::span<TilePlace, 4> children, Pass& pass,
                                 bool& moved) const {
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    TilePlace& child = children[static_cast<std::size_t>(quadrant)];
    if (!child.exists()) continue;
    const TilePlace before = child;
    if (const Status status = visit(key.child(quadrant), child, pass); !status.ok()) return status;
    moved = moved || !(child == before);
  }
  return {};
}

// place: where the file has the tile, then where it lies.
Status SaveTiles::visit(NodeKey key, TilePlace& place, Pass& pass) const {
  const EditedTile* const edited = in_.overlay.find(key);
  // A kept tile's children are kept, and those above an edited one are in the overlay.
  bool moved = place.offset > added_.kept || added_.kept - place.offset < place.bytes;
  if (edited == nullptr && !moved) return {};
  const Tile* tile = nullptr;
  if (edited == nullptr || edited->stamp != 0) {
    if (const Status status = in_.file.get(key, tile); !status.ok()) return status;
  }
  if (edited != nullptr && edited->stamp != 0 && !is_same(edited->tile, *tile)) moved = pass.differs = true;
  std::array<TilePlace, 4> children;
  std::copy_n(edited != nullptr ? edited->tile.children : tile->children, 4, children.begin());
  if (const Status status = visit_children(key, children, pass, moved); !status.ok()) return status;
  if (!moved) return {};
  if (edited != nullptr) {
    tile = &edited->tile;
  } else if (const Status status = in_.file.get(key, tile); !status.ok()) {
    return status;
  }
  const std::span<const std::byte> bytes = in_.write(key, in_.info, *tile, children, in_.room);
  place = {pass.end, static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)};
  ++pass.tiles;
  return put(pass, bytes);
}

Status SaveTiles::run(Pass& pass, TilePlace& root) const {
  root = in_.reader.root_tile();
  const NodeKey key = tile_of({in_.info.top_size(), 0, 0});
  if (const Status status = visit(key, root, pass); !status.ok()) return status;
  std::array<std::byte, kEndBytes> end;
  std::memcpy(end.data(), kMark, kMarkBytes);
  std::memcpy(end.data() + kMarkBytes, &added_.kept, sizeof added_.kept);
  return put(pass, end);
}

Status SaveTiles::plan() {
  added_ = {};
  tiles_ = 0;
  if (const Status status = find_kept(); !status.ok()) return status;
  Pass pass;
  pass.end = added_.kept;
  pass.crc = in_.reader.section_crc(WorldSection::tiles);
  if (added_.kept < in_.reader.tile_bytes()) {
    pass.crc = 0;
    std::uint64_t left = added_.kept;
    const auto add = [&](std::span<const std::byte> piece) {
      piece = piece.first(static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size())));
      left -= piece.size();
      pass.crc = crc32c(piece, pass.crc);
      return true;
    };
    const Status status = in_.reader.copy_section(WorldSection::tiles, ByteSink::to(add));
    if (!status.ok()) return status;
  }
  if (const Status status = run(pass, added_.root); !status.ok()) return status;
  if (!pass.differs) return {};
  tiles_ = pass.tiles;
  added_.bytes = pass.end - added_.kept;
  added_.crc = pass.crc;
  added_.low = in_.info.low;
  added_.high = in_.info.high;
  added_.context = this;
  added_.put = [](const void* context, const ByteSink& sink) {
    const auto& self = *static_cast<const SaveTiles*>(context);
    Pass again;
    again.sink = &sink;
    again.end = self.added_.kept;
    TilePlace root;
    const Status status = self.run(again, root);
    KARST_ASSERT(!status.ok() || root == self.added_.root);
    return status;
  };
  return {};
}

}  // namespace karst::core
