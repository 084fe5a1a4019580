# SPDX-License-Identifier: MIT
# cmake -D BOARDS=FILE;FILE;... -D OUTPUT=FILE.cpp -P embed_boards.cmake
#
# Writes the table of board_texts() (board_profile.h), each board under its file's name.
set(entries "")
foreach(file ${BOARDS})
  cmake_path(GET file STEM name)
  file(READ ${file} text)
  string(APPEND entries "    {\"${name}\", R\"board(${text})board\"},\n")
endforeach()
set(head "// Made by embed_boards.cmake.\n#include \"boards/board_profile.h\"\n\nnamespace karst {\n\n")
file(WRITE ${OUTPUT} "${head}constexpr BoardText kTexts[] = {\n${entries}};\n
std::span<const BoardText> board_texts() { return kTexts; }\n\n}  // namespace karst\n")
