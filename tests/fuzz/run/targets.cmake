# SPDX-License-Identifier: MIT
# Targets of fuzzing, tests/fuzz/targets: a program each, karst_fuzz_NAME, and karst_make_seeds. With
# KARST_FUZZ (preset fuzz) they are libFuzzer's; in all other builds they run over their seeds and simple
# damage of them.
find_package(ZLIB REQUIRED)
set(fuzz_run ${CMAKE_CURRENT_LIST_DIR})
set(fuzz_targets ${fuzz_run}/../targets)
set(fuzz_seeds ${CMAKE_CURRENT_BINARY_DIR}/fuzz_seeds)
add_custom_target(karst_fuzz_targets)

add_executable(karst_make_seeds ${fuzz_run}/make_seeds.cpp)
target_link_libraries(karst_make_seeds PRIVATE karst_test_options karst_test_support GTest::gtest
  karst_app_common karst_boards karst_cigi karst_tile_encoder)
if(TARGET karst_bake_lib)
  target_sources(karst_make_seeds PRIVATE bake/bake_files.cpp)
  target_link_libraries(karst_make_seeds PRIVATE karst_bake_lib)
  target_compile_definitions(karst_make_seeds PRIVATE KARST_FUZZ_BAKE)
endif()
add_dependencies(karst_fuzz_targets karst_make_seeds)
add_test(NAME fuzz.make_seeds COMMAND karst_make_seeds ${fuzz_seeds})
set_tests_properties(fuzz.make_seeds PROPERTIES LABELS fuzz FIXTURES_SETUP fuzz_seeds TIMEOUT 60)

# karst_fuzz(name start library...): start is where the target works, no (in its process) or serve (and as a
# child of it).
function(karst_fuzz name start)
  set(target karst_fuzz_${name})
  set(main replay_main)
  if(KARST_FUZZ)
    set(main libfuzzer_main)
  endif()
  add_executable(${target} ${fuzz_targets}/${name}.cpp ${fuzz_run}/${start}_start.cpp
    ${fuzz_run}/${main}.cpp)
  target_link_libraries(${target} PRIVATE karst_test_options ${ARGN})
  add_dependencies(karst_fuzz_targets ${target})
  if(KARST_FUZZ)
    target_link_options(${target} PRIVATE -fsanitize=fuzzer)
    return()
  endif()
  set(how)
  if(start STREQUAL "serve")
    set(how --as-they-are)
  endif()
  add_test(NAME fuzz.target_${name} COMMAND ${target} ${how} ${fuzz_seeds}/${name})
  set_tests_properties(fuzz.target_${name} PROPERTIES LABELS fuzz FIXTURES_REQUIRED fuzz_seeds
    ENVIRONMENT "ASAN_OPTIONS=detect_leaks=0" TIMEOUT ${KARST_TEST_TIMEOUT_S})
endfunction()

karst_fuzz(world no karst_test_support GTest::gtest)
karst_fuzz(sections no karst_test_support GTest::gtest)
karst_fuzz(tile no karst_tiles)
karst_fuzz(camera_path no karst_app_common)
karst_fuzz(poses no karst_app_motion)
karst_fuzz(board no karst_boards)
karst_fuzz(cigi no karst_cigi)
karst_fuzz(png no karst_app_common ZLIB::ZLIB)
if(TARGET karst_bake_lib)
  karst_fuzz(carve no karst_bake_lib)
  karst_fuzz(material_file no karst_bake_lib)
  karst_fuzz(elevation serve karst_bake_lib)
  karst_fuzz(material_image serve karst_bake_lib)
endif()

# Five minutes of libFuzzer, in a build of its own.
if(NOT KARST_FUZZ AND NOT CMAKE_CROSSCOMPILING AND NOT CMAKE_CXX_FLAGS MATCHES "sanitize")
  add_test(NAME long.fuzz CONFIGURATIONS Long COMMAND ${PROJECT_SOURCE_DIR}/dev fuzz 300)
  set_tests_properties(long.fuzz PROPERTIES LABELS long RUN_SERIAL TRUE SKIP_RETURN_CODE 77 TIMEOUT 5400
    ENVIRONMENT KARST_NO_INSTALL=1)
endif()
