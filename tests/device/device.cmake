# SPDX-License-Identifier: MIT
# What `./dev gpu` takes to other machines; see folder/make.sh. Included by tests/CMakeLists.txt.
find_package(nlohmann_json)
if(NOT nlohmann_json_FOUND OR NOT TARGET karst OR NOT TARGET karst-bench)
  return()
endif()

# Boards may lack libpng.
find_library(KARST_PNG_ARCHIVE libpng16.a)
find_library(KARST_ZLIB_ARCHIVE libz.a)
add_library(karst_png_archive INTERFACE)
if(KARST_PNG_ARCHIVE AND KARST_ZLIB_ARCHIVE)
  target_link_libraries(karst_png_archive INTERFACE ${KARST_PNG_ARCHIVE} ${KARST_ZLIB_ARCHIVE} m)
else()
  target_link_libraries(karst_png_archive INTERFACE PNG::PNG)
endif()

# karst_portable(target): the program needs EGL, GLES and the C library and nothing else. What a driver brings
# with it (libdrm, another C++ library) is never ours.
function(karst_portable target)
  if(NOT CMAKE_BUILD_TYPE STREQUAL "Release")
    return()
  endif()
  set_property(TARGET ${target} PROPERTY KARST_PORTABLE ON)
  target_link_options(${target} PRIVATE
    -static-libstdc++ -static-libgcc -Wl,--as-needed -Wl,--gc-sections
    -Wl,--exclude-libs,ALL)
endfunction()

file(GLOB device_sources CONFIGURE_DEPENDS device/machine/*.cpp device/report/*.cpp device/run/*.cpp)
add_library(karst_device_lib STATIC ${device_sources} golden/picture.cpp)
target_link_libraries(karst_device_lib PUBLIC karst_test_options karst_test_support karst_renderer
  karst_app_common karst_platform nlohmann_json::nlohmann_json PRIVATE ${karst_png})
add_executable(karst-device device/program/main.cpp)
target_link_libraries(karst-device PRIVATE karst_device_lib)
# karst without screens, and so without their libraries.
add_executable(karst_device_karst ${PROJECT_SOURCE_DIR}/app/main.cpp)
target_compile_definitions(karst_device_karst PRIVATE KARST_NO_VIEW)
target_link_libraries(karst_device_karst PRIVATE karst_app)
set_target_properties(karst_device_karst PROPERTIES
  OUTPUT_NAME karst RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/device)

set(device_programs karst-device karst_device_karst karst-bench karst_gl_tests karst_library_tests
  karst_golden_tests karst_bench_draws)
foreach(target ${device_programs})
  karst_portable(${target})
endforeach()
add_custom_target(karst_device_folder DEPENDS ${device_programs})
if(TARGET karst-bake)
  add_dependencies(karst_device_folder karst-bake)
endif()

karst_suite(device karst_device_lib)
set(makes_folder 0)
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND TARGET karst-bake)
  set(makes_folder 1)
  add_dependencies(karst_device_tests karst_device_folder)
  karst_long(device karst_device_tests DeviceFolder.* 60 KARST_DEVICE_PLAN=full)
endif()
target_compile_definitions(karst_device_tests PRIVATE
  KARST_BUILD_DIR="${PROJECT_BINARY_DIR}" KARST_DEVICE_FOLDER=${makes_folder})
