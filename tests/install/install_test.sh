#!/bin/bash
# SPDX-License-Identifier: MIT
# What a stranger does with karst: installs it, finds it, builds the examples with it and runs them, all in a
# folder outside of karst's tree. Run by CTest (tests/install/install.cmake), one STEP a test:
#
#   install_test.sh STEP SOURCE BUILD CMAKE CXX [LAUNCHER]
#
#   headers     each public header alone, and beside other headers of OpenGL
#   cmake       find_package() in a tree that was moved: static and shared, versions, without exceptions
#   pkgconfig   the same with pkg-config and the compiler alone
#   subproject  karst's sources as a part of another project, in a system that has little else
#   readme      README's commands as they are typed, but those that build and install karst itself
#   packages    the Debian packages and what is in them
#
# LAUNCHER: ccache, where karst was built with it. Exit code 77: skipped, with the reason.
# shellcheck disable=SC2086  # flags are several words
set -euo pipefail
step=$1 source=$2 build=$3 cmake=$4 cxx=$5 launcher=${6:-}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
warnings="-Wall -Wextra -Wpedantic -Werror"
plain="-fno-exceptions -fno-rtti"

say() { printf -- '-- %s\n' "$*"; }
fail() {
  printf 'install_test: %s\n' "$*" >&2
  exit 1
}
# quiet COMMAND...: shows what it printed only where it fails.
quiet() {
  "$@" >"$work/log" 2>&1 || {
    cat "$work/log"
    fail "failed: $*"
  }
}
refused() {
  if "$@" >"$work/log" 2>&1; then fail "should have failed: $*"; fi
}
version=$(sed -n 's/^#define KARST_VERSION_[A-Z]* //p' "$source/include/karst/version.h" | paste -sd .)

# install PREFIX: the library, as a user installs it, into a folder that is moved afterwards.
install_library() {
  local component
  for component in library dev; do
    quiet "$cmake" --install "$build" --prefix "$work/first" --component $component
  done
  mkdir -p "$(dirname "$1")"
  mv "$work/first" "$1"
  cp -r "$source/examples" "$work/examples"
}

# Builds that draw the same world must draw the same picture, to the bit.
run_examples() {  # NAME HELLO SIMULATOR
  local world=$work/canyon.karst
  [[ -e $world ]] || quiet "$build/bake/karst-bake" --sample canyon --no-ground -o "$world"
  quiet "$2" "$world" "$work/$1.ppm"
  local colours
  colours=$(tail -c +17 "$work/$1.ppm" | od -An -v -w3 -tx1 | sort -u | wc -l)
  ((colours > 500)) || fail "$1: hello drew only $colours colours"
  [[ -e $work/reference.ppm ]] || cp "$work/$1.ppm" "$work/reference.ppm"
  cmp "$work/$1.ppm" "$work/reference.ppm" || fail "$1: hello drew another picture than before"
  quiet "$3" "$world" "$work/$1-simulator.ppm" 20
  grep -q ' 0 answers coarse' "$work/log" || fail "$1: $(cat "$work/log")"
  say "$1: $colours colours; $(tail -n 1 "$work/log")"
}

headers() {
  install_library "$work/prefix"
  local compiler header other
  for compiler in g++ clang++; do
    command -v $compiler >/dev/null || continue
    for header in "$work"/prefix/include/karst/*.h; do
      echo "#include <karst/$(basename "$header")>" >"$work/alone.cpp"
      quiet $compiler -std=c++20 $warnings -Wconversion -pedantic-errors $plain -I"$work/prefix/include" \
        -fsyntax-only "$work/alone.cpp"
    done
    for other in epoxy/gl.h GL/glew.h GLES3/gl32.h EGL/egl.h; do
      printf '#include <karst/karst.h>\n#include <%s>\n' $other >"$work/before.cpp"
      printf '#include <%s>\n#include <karst/karst.h>\n' $other >"$work/after.cpp"
      quiet $compiler -std=c++20 $warnings -I"$work/prefix/include" -fsyntax-only "$work/before.cpp"
      quiet $compiler -std=c++20 $warnings -I"$work/prefix/include" -fsyntax-only "$work/after.cpp"
    done
    say "$compiler: the headers stand alone and beside others"
  done
}

# configure FOLDER ARGUMENT...: FOLDER is made from the examples.
configure() {
  local folder=$1
  shift
  quiet "$cmake" -S "$work/examples" -B "$folder" -G Ninja -DCMAKE_CXX_COMPILER="$cxx" \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/moved/here" "$@"
}

finds() {  # ARGUMENTS of find_package
  "$cmake" -S "$source/tests/install/finds" -B "$work/finds" --fresh -G Ninja -DCMAKE_CXX_COMPILER="$cxx" \
    -DCMAKE_PREFIX_PATH="$work/moved/here" -DARGUMENTS="$1"
}

by_cmake() {
  install_library "$work/moved/here"
  local kind flags name needed
  for kind in static shared; do
    flags=$warnings
    [[ $kind == static ]] || flags+=" $plain"
    name=find_package-$kind
    configure "$work/$name" -DCMAKE_CXX_FLAGS="$flags" \
      -DBUILD_SHARED_LIBS="$([[ $kind == shared ]] && echo ON || echo OFF)"
    quiet "$cmake" --build "$work/$name" --parallel 2
    run_examples "$name" "$work/$name/hello" "$work/$name/simulator"
  done
  needed=$(readelf -d "$work/find_package-static/hello")
  [[ $needed != *libkarst* ]] || fail "static: libkarst.so is needed"
  needed=$(readelf -d "$work/find_package-shared/hello")
  [[ $needed == *"[libkarst.so.${version%.*}]"* ]] || fail "shared: libkarst.so is not needed"

  local minor=${version%.*}
  quiet finds "$minor" && grep -q SHARED "$work/log" || fail "not the shared library where both are installed"
  quiet finds "$minor;COMPONENTS;static" && grep -q STATIC "$work/log" || fail "not the static library"
  refused finds "$minor;COMPONENTS;nonsense"
  refused finds "${minor%.*}.$((${minor#*.} + 1))"
  refused finds "${minor%.*}.$((${minor#*.} - 1))"

  # What the shared library shows and needs.
  local library=$work/moved/here/lib/libkarst.so
  nm -DC --defined-only "$library" >"$work/symbols"
  grep -q ' T karst::api_version()$' "$work/symbols" || fail "libkarst.so shows no api_version()"
  if grep -v ' [TVWR] karst::' "$work/symbols" || grep 'karst::core' "$work/symbols"; then
    fail "libkarst.so shows what is not its interface"
  fi
  if readelf -d "$library" | grep NEEDED | grep -vE '\[(libstdc\+\+|libm|libgcc_s|libc|ld-linux.*)\.so'; then
    fail "libkarst.so needs more than the C++ library"
  fi
}

by_pkgconfig() {
  install_library "$work/moved/here"
  export PKG_CONFIG_PATH=$work/moved/here/lib/pkgconfig
  [[ $(pkg-config --modversion karst) == "$version" ]] || fail "pkg-config tells another version"
  local simulator=("$work"/examples/simulator/*.cpp) flags libraries name kind
  for kind in shared static; do
    flags="-std=c++20 -O2 $warnings $(pkg-config --cflags karst egl glesv2)"
    libraries="$(pkg-config --libs karst egl glesv2) -Wl,-rpath,$work/moved/here/lib"
    if [[ $kind == static ]]; then
      flags+=" $plain"
      rm "$work"/moved/here/lib/libkarst.so*
      libraries=$(pkg-config --static --libs karst)\ $(pkg-config --libs egl glesv2)
    fi
    name=pkgconfig-$kind
    quiet "$cxx" $flags "$work/examples/hello.cpp" -o "$work/hello-$kind" $libraries
    quiet "$cxx" $flags -pthread "${simulator[@]}" -o "$work/simulator-$kind" $libraries
    run_examples "$name" "$work/hello-$kind" "$work/simulator-$kind"
  done
}

# A system without the packages that only karst's programs and tests need: pkg-config knows EGL and GLES.
little_system() {
  local pc
  mkdir -p "$work/pkgconfig"
  for pc in egl glesv2; do cp "$(pkg-config --variable=pcfiledir $pc)/$pc.pc" "$work/pkgconfig"; done
  export PKG_CONFIG_LIBDIR=$work/pkgconfig PKG_CONFIG_PATH=
  without=()
  local package
  for package in PNG GDAL OpenImageIO SDL2 GTest nlohmann_json Python3; do
    without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
  done
}

as_subproject() {
  little_system
  quiet "$cmake" -S "$source" -B "$work/alone" -G Ninja -DCMAKE_CXX_COMPILER="$cxx" "${without[@]}" \
    -DKARST_PROGRAMS=OFF -DKARST_BAKE=OFF -DKARST_BENCH=OFF -DKARST_TESTS=OFF
  say "the library alone is configured without the programs' packages"
  mkdir "$work/host"
  cp "$source/tests/install/host/CMakeLists.txt" "$work/host"
  quiet "$cmake" -S "$work/host" -B "$work/sub" -G Ninja -DCMAKE_CXX_COMPILER="$cxx" "${without[@]}" \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG" \
    -DCMAKE_CXX_FLAGS="-Wall -Wextra" -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" \
    -DKARST_SOURCE="$source"
  quiet "$cmake" --build "$work/sub" --parallel 2
  if grep -E 'warning:' "$work/log"; then fail "warnings in somebody else's build"; fi
  unset PKG_CONFIG_LIBDIR
  run_examples subproject "$work/sub/examples/hello" "$work/sub/examples/simulator"
}

# little_endian BYTES NUMBER...
little_endian() {
  local bytes=$1 number i
  shift
  for number in "$@"; do
    for ((i = 0; i < bytes; ++i)); do printf '\\x%02x' $((number >> 8 * i & 255)); done
  done
}

# An elevation model as GeoTIFF: 64 x 64 samples of 16 bits, 100 m apart.
make_dem() {
  local file=$1 text tag number
  text='II*\x00'$(little_endian 4 8200)
  text+=$(awk 'BEGIN { for (i = 0; i < 4096; ++i) {
    h = 2000 + (i % 64 - 20) * (int(i / 64) - 30); printf "\\x%02x\\x%02x", h % 256, h / 256 } }')
  text+=$(little_endian 2 11)
  # Tag, type (3: 16 bits, 4: 32 bits, 12: double), count, value or where it is.
  for tag in "256 3 1 64" "257 3 1 64" "258 3 1 16" "259 3 1 1" "262 3 1 1" "273 4 1 8" "277 3 1 1" \
    "278 3 1 64" "279 4 1 8192" "339 3 1 1" "33550 12 3 8338"; do
    set -- $tag
    text+=$(little_endian 2 $1 $2)$(little_endian 4 $3 $4)
  done
  text+=$(little_endian 4 0)
  for number in 0x4059000000000000 0x4059000000000000 0; do text+=$(little_endian 8 $number); done
  # shellcheck disable=SC2059  # the text is a format: bytes
  printf "$text" >"$file"
}

readme() {
  install_library "$work/prefix"
  local component line count=0
  for component in karst karst-bake; do
    quiet "$cmake" --install "$build" --prefix "$work/prefix" --component $component
  done
  export PATH=$work/prefix/bin:$PATH PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig
  export LD_LIBRARY_PATH=$work/prefix/lib
  cd "$work"
  make_dem dem.tif
  echo '[{"shape": "sphere", "op": "empty", "center": [0, 2020, 0], "radius": 200}]' >caves.json
  while read -r line; do
    quiet bash -c "$line"
    count=$((count + 1))
  done < <(sed -nE 's/^    ((karst-bake|karst render|g\+\+|\.\/hello) .*)/\1/p' "$source/README.md")
  ((count >= 5)) || fail "README has only $count such commands"
  grep -q "find_package(karst ${version%.*} " "$source/README.md" || fail "README asks for another version"
  for line in canyon.png world.karst hello.ppm; do
    [[ -s $line ]] || fail "README's commands made no $line"
  done
  say "$count commands"
}

# field PACKAGE FIELD; lists PACKAGE PATTERN: fails where no file of the package matches.
field() { dpkg-deb -f "$work"/debs/"$1"_*.deb "$2"; }
lists() {
  dpkg-deb -c "$work"/debs/"$1"_*.deb | grep -E "$2" >/dev/null || fail "$1 has no file like $2"
}

packages() {
  command -v dpkg-deb >/dev/null && command -v dpkg-shlibdeps >/dev/null || {
    echo "skipped: no dpkg-deb and dpkg-shlibdeps"
    exit 77
  }
  quiet "$(dirname "$cmake")/cpack" --config "$build/CPackConfig.cmake" -B "$work/debs"
  local names package
  names=$(cd "$work/debs" && echo *.deb)
  for package in libkarst libkarst-dev karst karst-ig karst-bake; do
    [[ $(field $package Version) == "$version-1" ]] || fail "$package is not of version $version-1"
    [[ $(field $package Package) == "$package" ]] || fail "$package has another name inside"
    (($(field $package Description | sed -n 1p | wc -m) < 70)) || fail "$package: the summary is long"
    (($(field $package Description | wc -l) > 3)) || fail "$package: has no description"
    lists $package "^-rw-r--r-- root/root .* \./usr/share/doc/$package/copyright$"
    lists $package "^-rw-r--r-- root/root .* \./usr/share/doc/$package/changelog\.gz$"
    if dpkg-deb -c "$work"/debs/"$package"_*.deb |
      grep -vE '^(drwxr-xr-x|-rw-r--r--|-rwxr-xr-x|lrwxrwxrwx) root/root .* \./(usr/.*)?$'; then
      fail "$package: odd files"
    fi
  done
  (($(wc -w <<<"$names") == 5)) || fail "other packages than expected: $names"
  lists libkarst '/libkarst\.so\.[0-9.]+$'
  lists libkarst-dev '/usr/include/karst/karst\.h$'
  lists libkarst-dev '/libkarst\.a$'
  lists libkarst-dev '^l.*/libkarst\.so -> libkarst\.so\.'
  lists libkarst-dev '/cmake/karst/karstConfig\.cmake$'
  lists libkarst-dev '/pkgconfig/karst\.pc$'
  lists libkarst-dev '/examples/hello\.cpp$'
  [[ $(field libkarst-dev Depends) == "libkarst (= $version-1), libzstd-dev" ]] ||
    fail "libkarst-dev: $(field libkarst-dev Depends)"
  [[ $(field libkarst Depends) != *libegl* ]] || fail "libkarst depends on EGL: $(field libkarst Depends)"
  for package in karst karst-ig karst-bake; do
    lists $package "^-rwxr-xr-x .* \./usr/bin/$package$"
    lists $package "/usr/share/man/man1/$package\.1\.gz$"
    lists $package "/usr/share/bash-completion/completions/$package$"
  done
  for package in view render info edit budget; do lists karst "/man1/karst-$package\.1\.gz$"; done
  (($(dpkg-deb -c "$work"/debs/karst_*.deb | grep -c /man1/karst) == 6)) || fail "karst has other manuals too"
  [[ $(field karst Depends) == *libegl1* && $(field karst Depends) == *libdrm2* ]] || fail "karst: no libegl1"
  [[ $(field karst Depends) != *libopenimageio* ]] || fail "karst depends on OpenImageIO"
  [[ $(field karst Depends) != *libgdal* ]] || fail "karst depends on GDAL"
  lists karst-ig '/usr/share/doc/karst-ig/examples/karst-ig\.service$'
  (($(dpkg-deb -c "$work"/debs/karst-ig_*.deb | grep -c /man1/karst) == 1)) ||
    fail "karst-ig has other manuals"
  [[ $(field karst-ig Depends) == *libegl1* && $(field karst-ig Depends) == *libdrm2* ]] ||
    fail "karst-ig: no libegl1"
  [[ $(field karst-ig Depends) != *libgdal* ]] || fail "karst-ig depends on GDAL"
  [[ $(field karst-bake Depends) == *libopenimageio* ]] || fail "karst-bake: no OpenImageIO"
  [[ $(field karst-bake Depends) == *libgdal* ]] || fail "karst-bake: no GDAL"

  # What is in them runs, from a folder that stands for /.
  for package in libkarst libkarst-dev karst karst-ig karst-bake; do
    dpkg-deb -x "$work"/debs/"$package"_*.deb "$work/root"
  done
  quiet "$work/root/usr/bin/karst-bake" --sample canyon -o "$work/canyon.karst"
  quiet "$work/root/usr/bin/karst" info "$work/canyon.karst"
  [[ $("$work/root/usr/bin/karst" --version) == "karst $version" ]] || fail "karst tells another version"
  [[ $("$work/root/usr/bin/karst-ig" --version) == "karst-ig $version" ]] ||
    fail "karst-ig tells another version"
  say "$names"
}

case $step in
  headers) headers ;;
  cmake) by_cmake ;;
  pkgconfig) by_pkgconfig ;;
  subproject) as_subproject ;;
  readme) readme ;;
  packages) packages ;;
  *) fail "no such step: $step" ;;
esac
