// SPDX-License-Identifier: MIT
#include "bake/fields/field_file.h"

#include "bake/fields/field_vdb.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>
#include <vector>

#include "bake/base/byte_message.h"
#include "platform/base/text.h"

namespace karst::bake {
namespace {

constexpr std::uint64_t kMemoryBytes = std::uint64_t{1} << 31;
constexpr unsigned kCpuSeconds = 120;
constexpr std::size_t kMostHeader = 64 << 10;  // of NRRD, bytes

enum class Type : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, single, twice, none };

// The names that NRRD gives them, too.
Type type_of(std::string_view name) {
  const struct {
    std::string_view name;
    Type type;
  } names[] = {{"int8", Type::int8},
               {"signed char", Type::int8},
               {"int8_t", Type::int8},
               {"uint8", Type::uint8},
               {"uchar", Type::uint8},
               {"unsigned char", Type::uint8},
               {"uint8_t", Type::uint8},
               {"int16", Type::int16},
               {"short", Type::int16},
               {"short int", Type::int16},
               {"signed short", Type::int16},
               {"signed short int", Type::int16},
               {"int16_t", Type::int16},
               {"uint16", Type::uint16},
               {"ushort", Type::uint16},
               {"unsigned short", Type::uint16},
               {"unsigned short int", Type::uint16},
               {"uint16_t", Type::uint16},
               {"int32", Type::int32},
               {"int", Type::int32},
               {"signed int", Type::int32},
               {"int32_t", Type::int32},
               {"uint32", Type::uint32},
               {"uint", Type::uint32},
               {"unsigned int", Type::uint32},
               {"uint32_t", Type::uint32},
               {"float", Type::single},
               {"double", Type::twice}};
  for (const auto& n : names) {
    if (n.name == name) return n.type;
  }
  return Type::none;
}

std::size_t bytes_of(Type type) {
  constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 4, 8, 0};
  return kBytes[static_cast<std::size_t>(type)];
}

struct Layout {
  glm::ivec3 size{0};
  Type type = Type::none;
  bool big_endian = false;
  bool gzip = false;
  std::uint64_t skip = 0;  // bytes before the data
  std::uint64_t skip_lines = 0;
  bool skip_to_end = false;  // the data are the file's last bytes
  double spacing_m = 0;
  std::string data_path;
};

template <class T>
void to_floats(std::span<const std::byte> bytes, bool swap, std::vector<float>& out) {
  out.resize(bytes.size() / sizeof(T));
  for (std::size_t n = 0; n < out.size(); ++n) {
    std::array<std::byte, sizeof(T)> one;
    std::memcpy(one.data(), bytes.data() + n * sizeof(T), sizeof(T));
    if (swap) std::ranges::reverse(one);
    out[n] = static_cast<float>(std::bit_cast<T>(one));
  }
}

void convert(std::span<const std::byte> bytes, const Layout& layout, std::vector<float>& out) {
  switch (layout.type) {
    case Type::int8:
      return to_floats<std::int8_t>(bytes, false, out);
    case Type::uint8:
      return to_floats<std::uint8_t>(bytes, false, out);
    case Type::int16:
      return to_floats<std::int16_t>(bytes, layout.big_endian, out);
    case Type::uint16:
      return to_floats<std::uint16_t>(bytes, layout.big_endian, out);
    case Type::int32:
      return to_floats<std::int32_t>(bytes, layout.big_endian, out);
    case Type::uint32:
      return to_floats<std::uint32_t>(bytes, layout.big_endian, out);
    case Type::single:
      return to_floats<float>(bytes, layout.big_endian, out);
    case Type::twice:
      return to_floats<double>(bytes, layout.big_endian, out);
    case Type::none:
      break;
  }
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

// Three numbers with blanks between.
template <class T>
bool three(std::string_view text, std::array<T, 3>& out) {
  for (T& value : out) {
    text = trimmed(text);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return trimmed(text).empty();
}

bool whole(std::string_view text, std::int64_t& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

// "(1,0,0) (0,1,0) (0,0,1)": the length of each, where the axes are not turned.
bool directions(std::string_view text, std::array<double, 3>& out) {
  std::string plain(text);
  for (char& c : plain) c = c == '(' || c == ')' || c == ',' ? ' ' : c;
  std::string_view rest = plain;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double length2 = 0;
    for (int k = 0; k < 3; ++k) {
      rest = trimmed(rest);
      double value = 0;
      const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
      if (error != std::errc()) return false;
      rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
      length2 += value * value;
    }
    out[axis] = std::sqrt(length2);
  }
  return trimmed(rest).empty();
}

Error set_spacing(const std::array<double, 3>& spacing, Layout& layout) {
  const auto [least, most] = std::ranges::minmax(spacing);
  if (!(least > 0) || !std::isfinite(most)) return "its spacings are not above 0";
  if (most > least * 1.001)
    return "its samples are not as far apart along all axes: resample it to cubes first";
  layout.spacing_m = spacing[0];
  return {};
}

// A line of an NRRD header after the first.
Error take_line(std::string_view line, const std::string& folder, Layout& layout) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.substr(colon, 2) == ":=") return {};
  const std::string_view name = trimmed(line.substr(0, colon)), value = trimmed(line.substr(colon + 1));
  const auto wrong = [&](const char* what) { return Error("in its header " + quote(line) + " " + what); };
  std::int64_t number = 0;
  if (name == "type") {
    layout.type = type_of(value);
    return layout.type == Type::none ? wrong("is not a type of numbers that karst-bake reads") : Error();
  }
  if (name == "dimension") return value == "3" ? Error() : wrong("is not 3: it has to be a grid in space");
  if (name == "sizes") {
    std::array<int, 3> sizes{};
    if (!three(value, sizes)) return wrong("is not three whole numbers");
    layout.size = {sizes[0], sizes[1], sizes[2]};
    return {};
  }
  if (name == "encoding") {
    layout.gzip = value == "gzip" || value == "gz";
    return layout.gzip || value == "raw" ? Error()
                                         : wrong("is neither raw nor gzip: save it as one of these");
  }
  if (name == "endian") {
    layout.big_endian = value == "big";
    return layout.big_endian || value == "little" ? Error() : wrong("is neither little nor big");
  }
  if (name == "spacings" || name == "space directions") {
    std::array<double, 3> spacing{};
    if (!(name == "spacings" ? three(value, spacing) : directions(value, spacing)))
      return wrong("is not three of them");
    return set_spacing(spacing, layout);
  }
  if (name == "byte skip" || name == "byteskip") {
    if (!whole(value, number) || number < -1) return wrong("is not a number of bytes");
    layout.skip_to_end = number < 0;
    layout.skip = number < 0 ? 0 : static_cast<std::uint64_t>(number);
    return {};
  }
  if (name == "line skip" || name == "lineskip") {
    if (!whole(value, number) || number < 0) return wrong("is not a number of lines");
    layout.skip_lines = static_cast<std::uint64_t>(number);
    return {};
  }
  if (name == "data file" || name == "datafile") {
    if (value.empty() || value.starts_with("LIST") || value.find('%') != std::string_view::npos)
      return wrong("is not one file");
    layout.data_path = value.front() == '/' ? std::string(value) : folder + std::string(value);
  }
  return {};
}

// The header of an NRRD file, and where the data begin.
Error read_header(const std::string& path, std::string_view text, Layout& layout) {
  const std::size_t slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  std::size_t at = 0;
  bool first = true, ended = false;
  while (at < text.size() && !ended) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos) break;
    const std::string_view line = trimmed(text.substr(at, end - at));
    at = end + 1;
    ended = line.empty();
    if (!first && !ended && line.front() != '#') {
      if (Error error = take_line(line, folder, layout); !error.ok()) return error;
    }
    first = false;
  }
  if (layout.type == Type::none) return "its header has no type";
  if (layout.size.x == 0) return "its header has no sizes";
  if (!layout.data_path.empty()) return {};
  if (!ended) return "its header does not end with an empty line within 64 KiB";
  layout.data_path = path;
  layout.skip += at;
  return {};
}

Error check_size(glm::ivec3 size) {
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] < 2 || size[axis] > FieldGrid::kMostSide)
      return "its sides are not within 2 to 4080 samples: cut or resample it";
  }
  const std::uint64_t samples = static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y) *
                                static_cast<std::uint64_t>(size.z);
  if (samples <= FieldGrid::kMostSamples) return {};
  return "it has more than 67108864 samples: cut or resample it";
}

Error inflate_all(std::ifstream& file, std::span<std::byte> out) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) return "its data cannot be decompressed";
  std::vector<char> in(64 << 10);
  std::size_t done = 0;
  int code = Z_OK;
  while (code == Z_OK && done < out.size()) {
    if (stream.avail_in == 0) {
      file.read(in.data(), static_cast<std::streamsize>(in.size()));
      stream.next_in = reinterpret_cast<Bytef*>(in.data());
      stream.avail_in = static_cast<uInt>(file.gcount());
      if (stream.avail_in == 0) break;
    }
    const std::size_t piece = std::min<std::size_t>(out.size() - done, 1 << 20);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    stream.avail_out = static_cast<uInt>(piece);
    code = inflate(&stream, Z_NO_FLUSH);
    done += piece - stream.avail_out;
  }
  inflateEnd(&stream);
  if (code != Z_OK && code != Z_STREAM_END) return "its data are not a whole gzip stream";
  return done == out.size() ? Error() : Error("it has fewer samples than its sizes say");
}

Error read_data(const Layout& layout, std::vector<float>& values) {
  const auto samples = static_cast<std::size_t>(layout.size.x) * static_cast<std::size_t>(layout.size.y) *
                       static_cast<std::size_t>(layout.size.z);
  std::vector<std::byte> bytes(samples * bytes_of(layout.type));
  std::ifstream file(layout.data_path, std::ios::binary);
  if (!file) return "its data file " + quote(layout.data_path) + " cannot be opened";
  std::string line;
  if (layout.skip_lines > 0) {
    for (std::uint64_t n = 0; n < layout.skip_lines && std::getline(file, line); ++n) {
    }
  }
  if (layout.skip_to_end) {
    file.seekg(-static_cast<std::streamoff>(bytes.size()), std::ios::end);
  } else {
    file.seekg(static_cast<std::streamoff>(layout.skip), std::ios::cur);
  }
  if (layout.gzip) {
    if (Error error = inflate_all(file, bytes); !error.ok()) return error;
  } else {
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (static_cast<std::size_t>(file.gcount()) != bytes.size())
      return "it has fewer samples than its sizes say";
  }
  convert(bytes, layout, values);
  if (!std::ranges::all_of(values, [](float v) { return std::isfinite(v); }))
    return "a value is infinite or not a number";
  return {};
}

Error read_here(const ReadField& settings, FieldGrid& grid) {
  std::ifstream file(settings.path, std::ios::binary);
  if (!file) return "it cannot be opened";
  std::string head(kMostHeader, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  Layout layout;
  if (settings.size.x > 0) {
    layout.size = settings.size;
    layout.type = type_of(settings.type);
    layout.data_path = settings.path;
    std::ifstream end(settings.path, std::ios::binary | std::ios::ate);
    const auto wanted = static_cast<std::uint64_t>(layout.size.x) *
                        static_cast<std::uint64_t>(layout.size.y) *
                        static_cast<std::uint64_t>(layout.size.z) * bytes_of(layout.type);
    const auto has = static_cast<std::uint64_t>(end.tellg());
    if (has != wanted) {
      return "it has " + std::to_string(has) + " bytes, and --field-size with --field-type asks for " +
             std::to_string(wanted);
    }
  } else if (is_vdb(head)) {
    return read_vdb(settings.path, grid);
  } else if (!head.starts_with("NRRD000")) {
    return "it is not NRRD; for raw samples say --field-size X,Y,Z and --field-type";
  } else if (Error error = read_header(settings.path, head, layout); !error.ok()) {
    return error;
  }
  if (Error error = check_size(layout.size); !error.ok()) return error;
  grid.size = layout.size;
  grid.spacing_m = layout.spacing_m;
  return read_data(layout, grid.values);
}

// In a child.
Error read_field(std::span<const std::byte> request, std::vector<std::byte>& result) {
  ReadField settings;
  ReadMessage message(request);
  message.take_text(settings.path);
  message.take_text(settings.type);
  for (int axis = 0; axis < 3; ++axis) message.take(settings.size[axis]);
  FieldGrid grid;
  if (const Error error = read_here(settings, grid); !error.ok()) return settings.path + ": " + error.text();
  WriteMessage out(result);
  for (int axis = 0; axis < 3; ++axis) out.put(grid.size[axis]);
  out.put(grid.spacing_m);
  const auto values = std::as_bytes(std::span(grid.values));
  result.insert(result.end(), values.begin(), values.end());
  return {};
}

}  // namespace

const ChildTask kReadField{"read field", read_field};

Error ReadField::run(FieldGrid& grid) const {
  ChildLimits limits;
  limits.memory_bytes = kMemoryBytes;
  limits.cpu_seconds = kCpuSeconds;
  limits.result_bytes = FieldGrid::kMostSamples * sizeof(float) + 64;
  std::vector<std::byte> request, result;
  WriteMessage words(request);
  words.put_text(path);
  words.put_text(type);
  for (int axis = 0; axis < 3; ++axis) words.put(size[axis]);
  if (Error error = run_in_child(path, limits, kReadField, request, result); !error.ok()) return error;
  ReadMessage message(result);
  grid = {};
  for (int axis = 0; axis < 3; ++axis) message.take(grid.size[axis]);
  message.take(grid.spacing_m);
  constexpr std::size_t kHead = 3 * sizeof(int) + sizeof(double);
  if (!message.whole() || !check_size(grid.size).ok()) return path + ": its reader stopped early";
  const auto samples = static_cast<std::size_t>(grid.size.x) * static_cast<std::size_t>(grid.size.y) *
                       static_cast<std::size_t>(grid.size.z);
  if (result.size() != kHead + samples * sizeof(float)) return path + ": its reader stopped early";
  grid.values.resize(samples);
  std::memcpy(grid.values.data(), result.data() + kHead, samples * sizeof(float));
  return {};
}

}  // namespace karst::bake
