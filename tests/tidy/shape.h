// SPDX-License-Identifier: MIT
// The shape of the code as a whole: how large folders and classes are, and what depends on what. Each rule
// takes all files of the repository; exceptions are listed in shape.cpp, by name and with the reason, and one
// that is not needed any more is a finding too.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/tidy/rules.h"

namespace karst::tidy {

inline constexpr std::size_t kMostFiles = 12;
inline constexpr int kMostMembers = 20;

struct Exception {
  std::string name;  // of a folder; of a class, or of two folders "a - b" that include each other
  std::size_t most;  // files or members
  std::string reason;
};
using Exceptions = std::vector<Exception>;

// At most kMostFiles files a folder, CMakeLists.txt not counted.
void check_folder_sizes(const std::vector<Source>& sources, const Exceptions& exceptions, Findings& out);

// No two folders include each other, however long the way round.
void check_circles(const std::vector<Source>& sources, const Exceptions& exceptions, Findings& out);

struct ClassSize {
  std::string path;
  int line;  // of its first member
  std::string name;
  int members;  // data members that are not static: those whose names end in '_'
};
// All classes of a C++ source that have such members.
std::vector<ClassSize> class_sizes(const Source& source);

// At most kMostMembers members a class.
void check_class_sizes(const std::vector<Source>& sources, const Exceptions& exceptions, Findings& out);

// What the repository is allowed.
const Exceptions& large_folders();
const Exceptions& circles();
const Exceptions& large_classes();

}  // namespace karst::tidy
