# SPDX-License-Identifier: MIT
# Builds karst for 64-bit ARM boards that run Debian 12 or something newer, on a Debian PC:
#
#   boards/cross/sysroot.sh build/aarch64-sysroot
#   cmake --preset aarch64 && cmake --build --preset aarch64
#
# Compiler: package g++-aarch64-linux-gnu. Tests run under qemu-aarch64-static (package qemu-user-static).
# KARST_SYSROOT: the folder that sysroot.sh filled.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_STRIP aarch64-linux-gnu-strip)
set(CMAKE_OBJDUMP aarch64-linux-gnu-objdump)

set(KARST_SYSROOT "" CACHE PATH "What boards/cross/sysroot.sh made")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES KARST_SYSROOT)
if(NOT EXISTS ${KARST_SYSROOT}/tree/usr/include/gbm.h)
  message(FATAL_ERROR "KARST_SYSROOT: '${KARST_SYSROOT}' is not what boards/cross/sysroot.sh makes")
endif()
set(CMAKE_SYSROOT ${KARST_SYSROOT}/tree)
set(CMAKE_FIND_ROOT_PATH ${CMAKE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

set(ENV{PKG_CONFIG_DIR} "")
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CMAKE_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR}
  ${CMAKE_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${CMAKE_SYSROOT}/usr/share/pkgconfig)

find_program(KARST_QEMU NAMES qemu-aarch64-static qemu-aarch64)
if(KARST_QEMU)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${KARST_QEMU} -L ${CMAKE_SYSROOT})
endif()
