# SPDX-License-Identifier: MIT
# cmake -D SHADER_DIR=... -D TEXT_DIR=... -D EMBEDDED=... -P embed_shaders.cmake
#
# For each line of variants.def: the two shader files with their includes spliced in, in TEXT_DIR with the
# variant's macros defined after the version line, for the reference compiler. EMBEDDED becomes a C++ file
# with all texts (gles_shaders/shader_texts.h), the macros beside them: variants of the same files are the
# same literals then, which the program holds once. Comments and indentation are left out.

cmake_minimum_required(VERSION 3.25)

# Sets `out` to the text of `file` with #include "x" lines replaced by the files. No include guards: a file
# is included once at most by each shader, which an error enforces.
function(read_shader file out)
  file(READ ${SHADER_DIR}/${file} text)
  while(text MATCHES "#include \"([a-z_.]+)\"")
    set(name ${CMAKE_MATCH_1})
    if(name IN_LIST included)
      message(FATAL_ERROR "${file} includes ${name} twice")
    endif()
    list(APPEND included ${name})
    file(READ ${SHADER_DIR}/${name} part)
    string(REPLACE "#include \"${name}\"" "${part}" text "${text}")
  endwhile()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

function(make_text file out)
  read_shader(${file} text)
  if(NOT text MATCHES "^#version 300 es\n")
    message(FATAL_ERROR "${file} must begin with #version 300 es")
  endif()
  strip_text(text)
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

function(write_text path defines text)
  string(REGEX REPLACE "^#version 300 es\n" "#version 300 es\n${defines}" text "${text}")
  file(WRITE ${path} "${text}")
endfunction()

# Without comments and indentation.
macro(strip_text name)
  set(text "${${name}}")
  string(REGEX REPLACE "[ ]*//[^\n]*" "" text "${text}")
  string(REGEX REPLACE "\n[ ]+" "\n" text "${text}")
  string(REGEX REPLACE "\n\n+" "\n" text "${text}")
  set(${name} "${text}")
endmacro()

# Semicolons would split lists: lines of variants.def hold none.
file(STRINGS ${SHADER_DIR}/variants.def lines REGEX "^KARST_VARIANT")
set(entries "")
foreach(line ${lines})
  if(NOT line MATCHES "^KARST_VARIANT\\(([a-z_]+), \"([a-z_.]+)\", \"([a-z_.]+)\", \"([A-Z_0-9 ]*)\"\\)$")
    message(FATAL_ERROR "variants.def: cannot read '${line}'")
  endif()
  set(name ${CMAKE_MATCH_1})
  set(vertex_file ${CMAKE_MATCH_2})
  set(fragment_file ${CMAKE_MATCH_3})
  string(REPLACE " " ";" macros "${CMAKE_MATCH_4}")
  set(defines "")
  foreach(macro ${macros})
    string(APPEND defines "#define KARST_${macro} 1\n")
  endforeach()
  make_text(${vertex_file} vertex)
  make_text(${fragment_file} fragment)
  # Of worlds with water, whose shaders are those of dry ones and more, and the same on devices with
  # anisotropic lookups, where voxels have materials.
  write_text(${TEXT_DIR}/${name}.vert "${defines}#define KARST_WATER 1\n#define KARST_VOXEL_MATERIALS 1\n"
             "${vertex}")
  write_text(${TEXT_DIR}/${name}.frag "${defines}#define KARST_WATER 1\n" "${fragment}")
  write_text(${TEXT_DIR}/${name}_anisotropic.frag
             "${defines}#define KARST_BLEND_MAP 1\n#define KARST_ANISOTROPY 4\n\
#define KARST_VOXEL_MATERIALS 1\n" "${fragment}")
  string(APPEND entries "    {\"${name}\",\n     R\"glsl(${defines})glsl\",\n")
  string(APPEND entries "     R\"glsl(${vertex})glsl\",\n")
  string(APPEND entries "     R\"glsl(${fragment})glsl\"},\n")
endforeach()
set(included "")
read_shader(air.glsl air)
strip_text(air)
# Whole, it is a shader of its own, for the reference compiler.
file(WRITE ${TEXT_DIR}/air.frag "#version 300 es
precision highp float;
precision highp int;
${air}
out vec4 colour;
in vec3 from_eye;
void main() {
  vec3 light = karst_light(from_eye, vec3(0.0, 1.0, 0.0), vec3(0.5));
  colour = karst_display(karst_haze(light, from_eye));
}
")
file(WRITE ${EMBEDDED} "// SPDX-License-Identifier: MIT
// Made by gles_shaders/embed_shaders.cmake.
#include \"gles_shaders/shader_texts.h\"

namespace karst::core {

const ShaderText kShaderTexts[kShaderVariants] = {
${entries}};

const char* const kAirText = R\"glsl(${air})glsl\";

}  // namespace karst::core
")
