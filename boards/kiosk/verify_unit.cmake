# SPDX-License-Identifier: MIT
# cmake -D ANALYZE=systemd-analyze -D UNIT=FILE.service -D PROGRAM=karst -D WORK=DIR -P verify_unit.cmake
#
# systemd finds nothing wrong with the unit, when the program is where it was built.
file(READ ${UNIT} text)
string(REPLACE "/usr/bin/karst" "${PROGRAM}" text "${text}")
cmake_path(GET UNIT FILENAME name)
file(WRITE ${WORK}/${name} "${text}")
execute_process(COMMAND ${ANALYZE} verify ${WORK}/${name} RESULT_VARIABLE failed ERROR_VARIABLE said)
# Words about other units of this machine are not about ours.
string(REGEX MATCHALL "[^\n]*${name}[^\n]*" ours "${said}")
if(failed OR ours)
  message(FATAL_ERROR "${ANALYZE} verify: ${said}")
endif()
