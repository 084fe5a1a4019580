# SPDX-License-Identifier: MIT
# cmake -D OBJDUMP=... -D PROGRAM=... [-D STRIP=... -D COPY=FILE] -P board_libraries.cmake
#
# Fails where the board program needs a shared library that boards do not have (GDAL or OpenImageIO would
# pull in some 260 libraries), or, stripped, is larger than it may be. Prints its size.
set(most_bytes 2359296)  # 2.25 MiB
set(allowed
  libEGL libGLESv2 libgbm libdrm libinput libseat libudev libpng16  # graphics, input, pictures
  libstdc++ libc++ libc++abi libgcc_s libm libc libpthread libdl ld-linux.*)  # C++ and C

execute_process(COMMAND ${OBJDUMP} -p ${PROGRAM} OUTPUT_VARIABLE headers RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "${OBJDUMP} cannot read ${PROGRAM}")
endif()
string(REGEX MATCHALL "NEEDED +[^\n]+" needed "${headers}")
if(NOT needed)
  message(FATAL_ERROR "${PROGRAM} names no shared libraries: is it a dynamic program?")
endif()
foreach(line ${needed})
  string(REGEX REPLACE "NEEDED +" "" library "${line}")
  set(known FALSE)
  foreach(name ${allowed})
    string(REPLACE "+" "\\+" pattern "${name}")
    if(library MATCHES "^${pattern}(-[^.]*)?\\.so")
      set(known TRUE)
    endif()
  endforeach()
  if(NOT known)
    message(FATAL_ERROR "${PROGRAM} needs ${library}, which is not for boards")
  endif()
endforeach()

if(STRIP)
  execute_process(COMMAND ${STRIP} -o ${COPY} ${PROGRAM} COMMAND_ERROR_IS_FATAL ANY)
  file(SIZE ${COPY} bytes)
  message(STATUS "${PROGRAM}: ${bytes} bytes stripped, of ${most_bytes}")
  if(bytes GREATER most_bytes)
    message(FATAL_ERROR "${PROGRAM} is too large for boards")
  endif()
endif()
