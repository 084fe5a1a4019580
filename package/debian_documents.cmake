# SPDX-License-Identifier: MIT
# Run by CPack over the files of each package: Debian's names for licence and changelog, and manuals and
# changelogs compressed.
find_program(GZIP gzip REQUIRED)
file(GLOB folders LIST_DIRECTORIES TRUE ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/doc/*)
foreach(folder ${folders})
  if(EXISTS ${folder}/LICENSE)
    file(RENAME ${folder}/LICENSE ${folder}/copyright)
    file(RENAME ${folder}/CHANGELOG.md ${folder}/changelog)
    execute_process(COMMAND ${GZIP} -9n ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  endif()
endforeach()
file(GLOB pages ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/man/man1/*.1)
foreach(page ${pages})
  execute_process(COMMAND ${GZIP} -9n ${page} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
