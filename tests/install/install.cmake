# SPDX-License-Identifier: MIT
# karst as strangers use it: see install_test.sh. Included by tests/CMakeLists.txt.
if(KARST_INSTALL AND KARST_BOTH_LIBRARIES AND TARGET karst-bake AND NOT CMAKE_CROSSCOMPILING
   AND NOT CMAKE_CXX_FLAGS MATCHES "sanitize")
  foreach(step headers cmake pkgconfig subproject readme packages)
    add_test(NAME install.${step}
      COMMAND ${CMAKE_CURRENT_LIST_DIR}/install_test.sh ${step} ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}
              ${CMAKE_COMMAND} ${CMAKE_CXX_COMPILER} ${CMAKE_CXX_COMPILER_LAUNCHER})
    set_tests_properties(install.${step} PROPERTIES
      LABELS install SKIP_RETURN_CODE 77 TIMEOUT ${KARST_TEST_TIMEOUT_S})
  endforeach()
endif()
