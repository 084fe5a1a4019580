// SPDX-License-Identifier: MIT
// make_seeds FOLDER: what mutations of each target start from, as FOLDER/TARGET/N.
#include "app/files/png_file.h"
#include "boards/board_profile.h"
#include "ig/cigi/message_writer.h"
#include "terrain/imagery/image_tile.h"
#include "tests/fuzz/run/seed_tile.h"
#include "tests/fuzz/run/seed_worlds.h"
#include "tiles/encode_tile.h"
#include "tiles/write_tile.h"
#ifdef KARST_FUZZ_BAKE
#include "tests/bake/bake_files.h"
#endif

#include <zstd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

std::filesystem::path root;

void write(const std::string& target, std::string_view text) {
  static int number = 0;
  std::filesystem::create_directories(root / target);
  std::ofstream(root / target / std::to_string(number++), std::ios::binary) << text;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void write_worlds() {
  using namespace karst::core;
  const std::vector<std::vector<std::byte>> worlds = karst::seed_worlds();
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    write("world", text_of(worlds[w]));
    const auto sections = load_at<std::uint32_t>(worlds[w], world_offsets::kSections);
    for (std::uint32_t s = 0; s <= sections; ++s) {
      std::string input = {static_cast<char>(w), static_cast<char>(s)};
      if (s < sections)
        input +=
            text_of(section_at(worlds[w], world_offsets::kTable + std::size_t{s} * world_offsets::kEntry));
      write("sections", input);
    }
  }
}

// As they are in files, and what zstd holds of them.
void write_tiles() {
  karst::tiles::TileEncoder encoder;
  for (int size = 0; size < 4; ++size) {
    std::vector<std::byte> bytes;
    encoder.run(karst::seed_tile_key(size), karst::seed_ground(), karst::seed_tile(size), 1, bytes);
    const std::string head(1, static_cast<char>(size));
    write("tile", head + std::string(text_of(bytes)));
    std::vector<std::byte> contents(karst::tiles::contents_bytes(size));
    if (ZSTD_decompress(contents.data(), contents.size(), bytes.data(), bytes.size()) != contents.size())
      std::exit(1);
    write("tile", head + std::string(text_of(contents)));
    // As editors write it.
    std::vector<std::uint64_t> room(karst::tiles::kWriteTileRoom / 8);
    const karst::core::Tile tile = karst::seed_tile(size);
    write("tile", head + std::string(text_of(karst::tiles::write_tile(
                             karst::seed_tile_key(size), karst::seed_ground(), tile, tile.children,
                             std::as_writable_bytes(std::span(room))))));
    // The head of an image tile with a child in the north-west.
    karst::core::ImageChildren children;
    children.places[0] = {400, karst::core::image_tile_bytes(karst::core::ImageFormat::etc2_rgb), 77};
    write("tile", head + std::string(text_of(std::as_bytes(std::span(children.places)))));
  }
}

// A profile with numbers beyond all ranges in each key in turn.
void write_large_numbers(std::string_view board) {
  for (std::size_t at = board.find(" = "); at != std::string_view::npos; at = board.find(" = ", at + 1)) {
    const std::size_t end = std::min(board.find_first_of("#\n", at), board.size());
    for (const char* number : {"1e300 ", "3x1e300 ", "-1e300x2 "}) {
      std::string text(board.substr(0, at + 3));
      write("board", text.append(number).append(board.substr(end)));
    }
  }
}

void write_texts() {
  const char path[] = "# east up south yaw pitch\n0 120.5 -40 90 -12\r\n1e3 ~1.7 -2.5e2 -180 0  # a walker\n";
  write("camera_path", path);
  write("camera_path",
        "\xef\xbb\xbf"
        "0 ~2 0 0 0\n");
  write("camera_path", "10,~2,-20,45,-3");
  write("poses", std::string("\x07") + path + "1 2 3\n");
  write("poses",
        "\x01"
        "1 2 3 4 5\n6 7 8 9 10");
  for (const karst::BoardText& board : karst::board_texts()) write("board", board.text);
  write_large_numbers(karst::board_texts().front().text);
  write("carve", R"([{"shape": "box", "op": "fill", "center": [0, 10, 0], "size": [5, 4, 3], "radius": 1},
 {"shape": "sphere", "op": "empty", "blend": 2.5, "center": [1e3, -4, 2], "radius": 7},
 {"shape": "capsule", "op": "empty", "radius": 3, "points": [[0, 0, 0], [10, 2, 3], [20, 0, 8]]}])");
  write("material_file", R"({"side": 64, "format": "etc2", "repeat": 2, "materials": [
 {"name": "rock", "sample": "rock", "slope": [null, 0.6], "fray": 0.5},
 {"name": "mud", "albedo": "mud.png", "height": "h.png", "normal": "n.png", "roughness": "r.png",
  "relief": 0.1, "elevation": [-5, 200], "slope_soft": 0.1, "elevation_soft": 3, "cave": 1}],
 "paint": [{"center": [0, 0, 0], "size": [9, 9, 9], "material": "mud"}],
 "blend_map": {"image": "map.png", "materials": ["rock", "mud"]},
 "lights": [{"position": [1, 2, 3], "radius": 8, "color": [1, 0.5, 0.25]}]})");
}

// All packets of both sides, in each version and order of bytes.
void write_messages() {
  using namespace karst::cigi;
  std::vector<std::byte> buffer(4'096);
  for (const Version version : {Version{3, 2}, Version{3, 3}, Version{4, 0}}) {
    for (const Order order : {Order::little, Order::big}) {
      ComponentControl short_component;
      short_component.short_form = true;
      MessageWriter host(buffer, version, order);
      const bool sent = host.write(IgControl{}) && host.write_entity({}, {}) && host.write(RateControl{}) &&
                        host.write(ComponentControl{}) && host.write(short_component) &&
                        host.write(CelestialSphereControl{}) && host.write(AtmosphereControl{}) &&
                        host.write(WeatherControl{}) && host.write(ViewControl{}) &&
                        host.write(ViewDefinition{}) && host.write(HatHotRequest{}) &&
                        host.write(LosSegmentRequest{}) && host.write(LosVectorRequest{});
      write("cigi", std::string("\1").append(text_of(host.bytes())));
      MessageWriter ig(buffer, version, order);
      const bool answered = ig.write(StartOfFrame{}) && ig.write(HatHotResponse{}) &&
                            ig.write(HatHotExtendedResponse{}) && ig.write(LosResponse{}) &&
                            ig.write(LosExtendedResponse{});
      write("cigi", std::string("\2").append(text_of(ig.bytes())));
      if (!sent || !answered) std::exit(1);
    }
  }
}

void write_pictures() {
  std::vector<std::uint8_t> rgba(4 * 7 * 5);
  for (std::size_t k = 0; k < rgba.size(); ++k) rgba[k] = static_cast<std::uint8_t>(37 * k);
  std::vector<std::byte> png;
  if (!karst::app::encode_png(rgba, 7, 5, png).ok()) std::exit(1);
  write("png", text_of(png));
  write("material_image", text_of(png));
  write("elevation", text_of(png));
}

#ifdef KARST_FUZZ_BAKE
void write_images() {
  using namespace karst::bake;
  std::vector<float> samples;
  for (int k = 0; k < 16 * 12; ++k) samples.push_back(static_cast<float>(k % 23) / 32.0f);
  const auto image = [&](const char* name, const char* type, int tile) {
    const std::string file = root / name;
    write_image(file, 16, 12, samples, type, tile);
    std::ifstream in(file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    write("elevation", bytes);
    write("material_image", bytes);
    if (name == std::string_view("a.png")) write("png", bytes);
    std::filesystem::remove(file);
  };
  image("a.tif", "float", 0);
  image("b.tif", "int16", 16);
  image("c.tif", "uint8", 0);
  image("a.png", "uint16", 0);
  image("a.exr", "half", 0);
  image("b.exr", "float", 16);
  const std::string raw(24, '\x05');
  write("elevation", TiffBuilder(4, 3, 16, 2, raw)
                         .pixel_scale(30, 30)
                         .tie_point(0, 200)
                         .geo_keys({1024, 1, 1025, 1, 3072, 32633})
                         .ascii(42113, "-9999")
                         .bytes());
  write("elevation", std::string("ENVI\nsamples = 4\nlines = 3\nbands = 1\ndata type = 2\nbyte order = 0\n"
                                 "interleave = bsq\nmap info = {UTM, 1, 1, 0, 0, 30, 30, 33, North}\n") +
                         '\0' + raw);
  write("elevation", std::string("BYTEORDER I\nLAYOUT BIL\nNROWS 3\nNCOLS 4\nNBANDS 1\nNBITS 16\n"
                                 "PIXELTYPE SIGNEDINT\nNODATA -9999\n") +
                         '\0' + raw);
}
#endif

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: make_seeds FOLDER\n");
    return 2;
  }
  root = words[1];
  std::filesystem::remove_all(root);
  write_worlds();
  write_tiles();
  write_texts();
  write_messages();
  write_pictures();
#ifdef KARST_FUZZ_BAKE
  write_images();
#endif
  return 0;
}
