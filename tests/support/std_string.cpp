// SPDX-License-Identifier: MIT
// gtest's archive leaves functions of std::string open, and takes them from the first archive that has them.
// Here they are, before those of platform's code for screens, which would bring libdrm into every test.
#include <string>

template class std::basic_string<char>;
