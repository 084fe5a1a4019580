// SPDX-License-Identifier: MIT
// Work on bytes that nobody can trust, by libraries that do not bound what they take: in a process of its own
// with a limit on memory and on time. What goes wrong there is an error here.
//
// The process is this program, started anew: a copy (fork) would begin with locks held by threads that it
// does not have, and image libraries start threads while they are loaded, before main().
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/error.h"

namespace karst::bake {

struct ChildLimits {
  std::uint64_t memory_bytes = 256u << 20;  // that the work may take on top of what the process has
  unsigned cpu_seconds = 30;                // and four times as long where it does nothing
  std::size_t result_bytes = 0;             // the most that comes back
};

// Work that a child does. work fills result from the request, or tells why not.
struct ChildTask {
  std::string_view name;
  Error (*work)(std::span<const std::byte> request, std::vector<std::byte>& result);
  // Tasks of one library share a process; two libraries may each set handlers of a third for the whole of it.
  enum class Library : std::uint8_t { open_image_io, gdal, count } library = Library::open_image_io;
};

// The first call in main(): in a child, works until its parent ends or has no more, and returns the exit
// code. words: of main(), the program's name first. tasks: all that run_in_child is called with.
std::optional<int> serve_as_child(std::span<const char* const> words, std::span<const ChildTask> tasks);

// Has task done by a child, which is started by the library's first call and stays for the next ones, and
// waits for it.
// result: what the task filled, empty on an error. subject: the file, for messages of a child that died;
// those of the task are handed on as they are. One call at a time. Under AddressSanitizer and
// ThreadSanitizer, whose shadow is larger than any limit, memory has none.
Error run_in_child(const std::string& subject, const ChildLimits& limits, const ChildTask& task,
                   std::span<const std::byte> request, std::vector<std::byte>& result);

}  // namespace karst::bake
