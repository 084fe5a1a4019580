# SPDX-License-Identifier: MIT
# cmake -D ANALYZE=systemd-analyze -D UNIT=FILE.service -D PROGRAM=karst -D INSTALLED=/usr/bin/karst
#   -D WORK=DIR -P verify_unit.cmake
#
# systemd finds nothing wrong with the unit, when the program is where it was built, and calls what it may do
# little: an exposure of 2.0 at most.
file(READ ${UNIT} text)
string(REPLACE "${INSTALLED}" "${PROGRAM}" text "${text}")
cmake_path(GET UNIT FILENAME name)
file(WRITE ${WORK}/${name} "${text}")
execute_process(COMMAND ${ANALYZE} verify ${WORK}/${name} RESULT_VARIABLE failed ERROR_VARIABLE said)
# Words about other units of this machine are not about ours.
string(REGEX MATCHALL "[^\n]*${name}[^\n]*" ours "${said}")
if(failed OR ours)
  message(FATAL_ERROR "${ANALYZE} verify: ${said}")
endif()

if(NOT text MATCHES "\nStartLimitIntervalSec=0\n")
  message(FATAL_ERROR "${name} gives up after a few starts: StartLimitIntervalSec=0 is missing")
endif()
execute_process(COMMAND ${ANALYZE} security --help OUTPUT_VARIABLE help ERROR_QUIET)
if(NOT help MATCHES "--offline")
  message(STATUS "not checked: this systemd-analyze has no security --offline")
  return()
endif()
execute_process(
  COMMAND ${ANALYZE} security --offline=true --threshold=20 --no-pager ${WORK}/${name}
  RESULT_VARIABLE exposed OUTPUT_VARIABLE said ERROR_VARIABLE said)
string(REGEX MATCH "Overall exposure level[^\n]*" level "${said}")
message(STATUS "${level}")
if(exposed OR NOT level)
  message(FATAL_ERROR "${ANALYZE} security: more than 2.0\n${said}")
endif()
