# SPDX-License-Identifier: MIT
# Debian packages, one for each component that is built: `cpack` in the build folder, or `./dev package`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME karst)
set(CPACK_PACKAGE_VENDOR "karst")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_CONTACT "The karst authors <karst@example.org>")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
# Compresses manuals and lays down what Debian wants beside each package.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_SOURCE_DIR}/debian_documents.cmake)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")  # 0.x: every minor version may change anything
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(same_version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(about "karst draws terrain with caves, arches and overhangs from a fixed memory budget,
with OpenGL ES 3.0.")

# karst_deb(component package section summary text): sets the CPack variables of a package.
macro(karst_deb component package section summary text)
  string(TOUPPER ${component} component_upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${component_upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${component_upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${component_upper}_DESCRIPTION "${summary}\n${about}\n\n${text}")
endmacro()

set(CPACK_COMPONENTS_ALL)
if(TARGET karst_shared)
  karst_deb(library libkarst libs "terrain with caves for embedded GPUs: library"
    "This package holds the shared library.")
  set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libkarst ${same_version}, libzstd-dev")
endif()
karst_deb(dev libkarst-dev libdevel "terrain with caves for embedded GPUs: headers"
  "This package holds what programs are built with that draw terrain with karst:
headers, the libraries for the linker, CMake and pkg-config files, and examples.")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "libegl-dev, libgles-dev, karst-bake")
if(TARGET karst)
  karst_deb(karst karst graphics "terrain with caves for embedded GPUs: viewer"
    "This package holds the program that shows worlds on a board's screen, and draws
pictures of them without one.")
  set(CPACK_DEBIAN_KARST_PACKAGE_RECOMMENDS "libgl1-mesa-dri")
  set(CPACK_DEBIAN_KARST_PACKAGE_SUGGESTS "karst-bake")
endif()
if(TARGET karst-ig)
  karst_deb(karst-ig karst-ig graphics "terrain with caves for embedded GPUs: image generator"
    "This package holds the program that draws worlds for a simulator, which drives it
by the Common Image Generator Interface (CIGI) 3.3 or 4.0.")
  set(CPACK_DEBIAN_KARST-IG_PACKAGE_RECOMMENDS "libgl1-mesa-dri")
  set(CPACK_DEBIAN_KARST-IG_PACKAGE_SUGGESTS "karst, karst-bake")
endif()
if(TARGET karst-bake)
  karst_deb(karst-bake karst-bake graphics "terrain with caves for embedded GPUs: makes worlds"
    "This package holds the program that makes worlds from elevation models and
images.")
  set(CPACK_DEBIAN_KARST-BAKE_PACKAGE_SUGGESTS "karst")
endif()
include(CPack)
