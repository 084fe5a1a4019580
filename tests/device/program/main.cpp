// SPDX-License-Identifier: MIT
// karst-device: runs tests, golden pictures and benchmarks on a machine, and makes tables of what came of it.
// `./dev gpu` puts it into a folder with all that it needs; see docs/devices.md.
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "app/common/arguments.h"
#include "app/files/atomic_file.h"
#include "tests/device/machine/probe.h"
#include "tests/device/report/tables.h"
#include "tests/device/run/session.h"
#include "tests/golden/cases.h"
#include "tests/support/process.h"

namespace karst::device {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr int kExitInterrupted = 130;

constexpr const char* kHelp =
    R"(usage: ./run [options]

Runs karst's GL tests, golden pictures and benchmarks on this machine and writes what came of them into one
JSON file. Needs EGL with OpenGL ES 3.0, the C library and a shell; nothing is installed.

  -o, --output FILE  the JSON, written anew after every part (karst-device.json)
      --quick        a few tests, pictures and frames, to see whether it works: a minute at most
      --plan NAME    of plans/ (full); or a file: a part a line, to be changed and extended
      --only KIND    runs parts of one kind alone: tests, pictures, frames, program
      --keep DIR     where drawn pictures are left that are not the stored ones to the bit
      --limit S      seconds that a test may print nothing (600); other parts may take three times as long
      --list         prints the plan's parts
  -h, --help         this

A part that fails, crashes or hangs does not stop the others. Exit code: 0 all is well; 1 something failed
(it is listed at the end and under "failures"); 2 the command line is wrong; 130 it was interrupted.

  ./run                            # everything
  ./run --quick
  ./run --only frames -o rock5b.json
  ./run --plan my.plan             # one line of it: frames near : canyon_fine --shadows 0 --frames 100
  EGL_PLATFORM=surfaceless ./run   # drivers read their own variables, as always

karst-device.json is what docs/devices.md of karst is made of: ./dev devices.
)";

struct Arguments {
  SessionOptions session;
  std::string only;
  bool list = false;
  bool help = false;
};

Error take_value(const Words& words, std::size_t& n, std::string& value) {
  if (n + 1 == words.size()) return words[n] + ": a value is missing";
  value = words[++n];
  return {};
}

Error parse(const Words& words, Arguments& arguments) {
  SessionOptions& session = arguments.session;
  for (std::size_t n = 0; n < words.size(); ++n) {
    const std::string word = words[n];
    std::string limit;
    Error error;
    if (word == "--folder") {
      error = take_value(words, n, session.folder);
    } else if (word == "-o" || word == "--output") {
      error = take_value(words, n, session.json);
    } else if (word == "--quick") {
      session.plan = "quick";
    } else if (word == "--plan") {
      error = take_value(words, n, session.plan);
    } else if (word == "--only") {
      error = take_value(words, n, arguments.only);
    } else if (word == "--keep") {
      error = take_value(words, n, session.keep);
    } else if (word == "--limit") {
      error = take_value(words, n, limit);
      if (error.ok()) error = app::parse_number(limit, word, 1, 1e6, session.limits.silence_s);
    } else if (word == "--list") {
      arguments.list = true;
    } else if (word == "-h" || word == "--help") {
      arguments.help = true;
    } else {
      error = "unknown option '" + word + "'; see --help";
    }
    if (!error.ok()) return error;
  }
  return {};
}

// Plans of the folder are called by their names, others by their files.
Error read_plan(Arguments& arguments) {
  SessionOptions& session = arguments.session;
  std::string file = session.folder + "/plans/" + session.plan + ".plan";
  if (!fs::exists(file)) file = session.plan;
  if (!fs::is_regular_file(file)) return "--plan: there is no '" + session.plan + "'";
  if (Error error = parse_plan(test::read_text(file), file, session.parts); !error.ok()) return error;
  session.plan = fs::path(file).stem().string();
  if (arguments.only.empty()) return {};
  std::erase_if(session.parts, [&](const Part& part) {
    return arguments.only != kPartKinds[static_cast<std::size_t>(part.kind)];
  });
  return session.parts.empty() ? Error("--only: the plan has no '" + arguments.only + "'") : Error();
}

void list_parts(const std::vector<Part>& parts) {
  for (const Part& part : parts) {
    std::printf("%-9s %-12s :", kPartKinds[static_cast<std::size_t>(part.kind)], part.name.c_str());
    for (const std::string& word : part.words) std::printf(" %s", word.c_str());
    std::printf("\n");
  }
}

int fail(const Error& error, int code) {
  app::print_error("karst-device", error.text());
  return code;
}

int run(const Words& words, const std::string& self) {
  Arguments arguments;
  arguments.session.self = self;
  arguments.session.folder = fs::path(self).parent_path().parent_path().string();
  if (const Error error = parse(words, arguments); !error.ok()) return fail(error, app::kExitUsage);
  if (arguments.help) {
    std::fputs(kHelp, stdout);
    return app::kExitOk;
  }
  if (const Error error = read_plan(arguments); !error.ok()) return fail(error, app::kExitUsage);
  if (arguments.list) {
    list_parts(arguments.session.parts);
    return app::kExitOk;
  }
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    action.sa_handler = [](int) { interrupt_children(); };
    sigaction(number, &action, nullptr);
  }
  SessionEnd end;
  if (const Error error = run_session(arguments.session, end); !error.ok())
    return fail(error, app::kExitFailure);
  std::fprintf(stderr, "%s: %s\n", arguments.session.json.c_str(),
               !end.complete ? "interrupted"
               : end.good    ? "all is well"
                             : "something failed");
  return !end.complete ? kExitInterrupted : end.good ? app::kExitOk : app::kExitFailure;
}

int probe() {
  Json device;
  if (const Error error = probe_device(device); !error.ok()) {
    std::printf("%s\n", error.text().c_str());
    return app::kExitFailure;
  }
  std::printf("%s\n", device.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  return app::kExitOk;
}

// What make.sh bakes: golden worlds, and those of plans.
int worlds(const Words& plans) {
  const auto print = [](const std::string& name, const Words& bake) {
    std::printf("%s", name.c_str());
    for (const std::string& word : bake) std::printf(" %s", word.c_str());
    std::printf("\n");
  };
  for (const test::GoldenWorld& world : test::kGoldenWorlds) print(world.name, world.bake);
  for (const std::string& plan : plans) {
    std::vector<Part> parts;
    if (const Error error = parse_plan(test::read_text(plan), plan, parts); !error.ok())
      return fail(error, app::kExitFailure);
    for (const Part& part : parts) {
      if (part.kind == PartKind::world) print(part.name, part.words);
    }
  }
  return app::kExitOk;
}

// With a page the tables are put into it, else they are printed.
int tables(const std::string& page, const Words& files) {
  std::vector<DeviceReport> reports;
  Error error = files.empty() ? Error("which FILE.json?") : read_reports(files, reports);
  if (!error.ok()) return fail(error, app::kExitFailure);
  const std::string text = device_tables(reports);
  if (page.empty()) {
    std::fputs(text.c_str(), stdout);
    return app::kExitOk;
  }
  std::string whole = test::read_text(page);
  error = replace_tables(text, whole);
  if (!error.ok()) return fail(page + ": " + error.text(), app::kExitFailure);
  error = app::write_file_atomic(page, std::as_bytes(std::span(whole)));
  return error.ok() ? app::kExitOk : fail(error, app::kExitFailure);
}

int command(const Words& words) {
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  const std::string name = words.empty() ? "" : words[0];
  const Words rest(words.begin() + (words.empty() ? 0 : 1), words.end());
  if (name == "probe") return probe();
  if (name == "worlds") return worlds(rest);
  if (name == "table") return tables("", rest);
  if (name == "page" && !rest.empty()) return tables(rest[0], Words(rest.begin() + 1, rest.end()));
  return run(words, self);
}

}  // namespace
}  // namespace karst::device

int main(int argc, char** argv) {
  try {
    return karst::device::command(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::exception& e) {  // no memory, no temporary folder
    karst::app::print_error("karst-device", e.what());
    return karst::app::kExitFailure;
  }
}
