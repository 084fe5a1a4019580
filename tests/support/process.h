// SPDX-License-Identifier: MIT
// Programs run as a user runs them, in a folder of the test's own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace karst::test {

struct ProcessResult {
  int code = -1;  // exit code; 128 + signal where a signal ended it
  std::string out;
  std::string err;
};

// environment: "NAME=value" settings on top of this process's. Throws std::runtime_error where it cannot be
// started.
ProcessResult run_process(const std::string& program, const std::vector<std::string>& arguments,
                          const std::vector<std::string>& environment = {});

// A new empty folder, removed with everything in it at the end.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const { return (root_ / name).string(); }
  std::string write(const std::string& name, std::span<const std::byte> bytes) const;
  std::string write(const std::string& name, const std::string& text) const;
  // Names of what lies in it, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path root_;
};

std::string read_text(const std::string& path);

}  // namespace karst::test
