#!/bin/bash
# SPDX-License-Identifier: MIT
# make.sh BUILD TOOLS FOLDER [WORLDS [NAME...]]: makes FOLDER, with which karst is tested and measured on a
# machine that has EGL and nothing of karst, and FOLDER.tar.gz. `./dev gpu` calls it.
#
#   BUILD   the build folder whose programs are taken
#   TOOLS   a build folder of this machine: BUILD, or another where BUILD is for another processor
#   WORLDS  where baked worlds are kept for the next time; a part of FOLDER where it is not given
#   NAME    of worlds that are put in; all where none is given
set -euo pipefail
(($# >= 3)) || {
  sed -n '3,9p' "$0" >&2
  exit 2
}
build=$(cd "$1" && pwd) tools=$(cd "$2" && pwd) folder=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source=$(cd "$here/../../.." && pwd)
fail() {
  printf 'make.sh: %s\n' "$*" >&2
  exit 1
}

mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
worlds=${4:-$folder/worlds} names=" ${*:5} "
mkdir -p "$folder/worlds" "$worlds"
rm -rf "${folder:?}"/{bin,pictures,plans,run,README.md,machine,needs,commit}
mkdir "$folder"/{bin,pictures,plans}

# Programs: what they need must be on every machine that has EGL.
setting() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
objdump=$(setting CMAKE_OBJDUMP) strip=$(setting CMAKE_STRIP)
for program in device/karst karst-device ../bench/karst-bench karst_gl_tests karst_library_tests \
  karst_golden_tests karst_bench_draws; do
  name=$(basename "$program")
  [[ -x $build/tests/$program ]] || fail "$build has no $name: build the target karst_device_folder"
  "$strip" -o "$folder/bin/$name" "$build/tests/$program"
  chmod 755 "$folder/bin/$name"
  while read -r library; do
    [[ $library =~ ^(libEGL|libGLESv2|libc|libm|libdl|libpthread|ld-linux.*)\.so ]] ||
      fail "$name needs $library, which a device may lack"
  done < <("$objdump" -p "$folder/bin/$name" | sed -n 's/^ *NEEDED *//p')
  if "$objdump" -p "$folder/bin/$name" | grep -E 'RPATH|RUNPATH'; then
    fail "$name looks for libraries elsewhere"
  fi
done
"$objdump" -T "$folder"/bin/* | sed -n 's/.*(\?GLIBC_\([0-9.]*\).*/\1/p' | sort -Vu | tail -n 1 |
  sed 's/^/the C library of GNU, version /; s/$/ or later/' >"$folder/needs"
case $("$objdump" -f "$folder/bin/karst" | sed -n 's/^architecture: \([^,]*\),.*/\1/p') in
  i386:x86-64) echo x86_64 ;;
  aarch64) echo aarch64 ;;
  *) fail "an unknown processor" ;;
esac >"$folder/machine"

# Worlds: those that are newer than karst-bake stay.
while read -r name words; do
  [[ $names == "  " || $names == *" $name "* ]] || continue
  world=$worlds/$name.karst
  if [[ ! $world -nt $tools/bake/karst-bake ]]; then
    if [[ $words != --sample* && ! -e ${words%% *} ]]; then
      echo "left out: $name.karst, whose elevation model is not there" >&2
      continue
    fi
    # shellcheck disable=SC2086  # several words
    "$tools/bake/karst-bake" $words --quiet -o "$world"
  fi
  [[ $worlds -ef $folder/worlds ]] || cp -p "$world" "$folder/worlds/"
done < <("$tools/tests/karst-device" worlds "$here"/*.plan)

cp "$source"/tests/golden/images/*.png "$folder/pictures/"
cp "$here"/*.plan "$folder/plans/"
cp "$here/README.md" "$folder/"
install -m 755 "$here/run.sh" "$folder/run"
commit=$(git -C "$source" rev-parse --short HEAD 2>/dev/null || echo unknown)
[[ -z $(git -C "$source" status --porcelain 2>/dev/null) ]] || commit+=" and changes"
echo "$commit" >"$folder/commit"

tar -C "$(dirname "$folder")" --sort=name --owner=0 --group=0 --numeric-owner -czf "$folder.tar.gz" \
  "$(basename "$folder")"
