#!/bin/bash
# SPDX-License-Identifier: MIT
# programs.sh KARST KARST-BAKE: every command of the programs once, on the smallest inputs that there are and
# on coarse samples. Built with sanitizers, which end a program with a code that no command has.
set -euo pipefail
karst=$1 bake=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
# Drivers keep what they have until the process ends, and free with the C library what karst's counting
# operator new gave them.
export ASAN_OPTIONS=detect_leaks=0:alloc_dealloc_mismatch=0:exitcode=99
export UBSAN_OPTIONS=print_stacktrace=1:exitcode=99

# run CODE COMMAND...: it must end with this exit code.
run() {
  local wanted=$1 code=0
  shift
  "$@" >out.txt 2>err.txt || code=$?
  if ((code != wanted)); then
    printf 'programs.sh: exit code %s instead of %s: %s\n' "$code" "$wanted" "$*" >&2
    cat err.txt >&2
    exit 1
  fi
}

# raw NAME COLUMNS ROWS OCTAL...: 16-bit heights, as ENVI has them; OCTAL is repeated.
raw() {
  local name=$1 columns=$2 rows=$3
  shift 3
  local samples=() n
  for ((n = 0; n < columns * rows; ++n)); do samples+=("${@:n % $# + 1:1}"); done
  # shellcheck disable=SC2059  # the octal numbers are the format
  printf "$(printf '\\%s\\000' "${samples[@]}")" >"$name.bil"
  printf 'ENVI\nsamples = %s\nlines = %s\nbands = 1\ndata type = 2\nbyte order = 0\ninterleave = bsq\n' \
    "$columns" "$rows" >"$name.hdr"
}

# The least there is: 2 x 2 samples, a world of two voxels, whose inside has no length.
raw two 2 2 001 002 001 003
run 0 "$bake" two.bil -o two.karst --materials none --pixel-size 1 --levels 2 --voxel 1
# One level alone has no level above the first to measure.
raw nine 9 9 001 010 003 020 002 005 011
run 0 "$bake" nine.bil -o nine.karst --materials none --pixel-size 1 --levels 1 --voxel 4
run 0 "$bake" nine.bil -o holes.karst --materials none --pixel-size 1 --voxel 4 --nodata 3,hole --water 2

run 0 "$bake" nine.bil -o tiles.karst --ground --pixel-size 1 --material-side 16 --nodata 3 --water 2
run 0 "$bake" two.bil -o least.karst --ground --pixel-size 1 --materials none

for sample in arches canyon caves hills; do
  run 0 "$bake" --sample "$sample" --no-ground -o "$sample.karst" --voxel 100 --levels 2 --material-side 16
done
for world in two nine holes caves tiles least; do
  run 0 "$karst" info "$world.karst"
  run 0 "$karst" budget "$world.karst" --json
  run 0 "$karst" render "$world.karst" -o "$world.png" --size 48x32 --stats -
done
# Next to the ground and with it behind the eye.
run 0 "$karst" view hills.karst --headless --size 48x32 --frames 4 --camera 0,~36,0,0,0 --stats -
run 0 "$karst" view hills.karst --headless --size 48x32 --frames 4 --camera 0,~1.7,0,90,80 --shading forward
run 0 "$karst" view tiles.karst --headless --size 48x32 --frames 4 --camera 0,~1.7,0,90,-10 --stats -
run 0 "$karst" render hills.karst -o drape.png --size 48x32 --drape two.png --lod full
run 0 "$karst" budget
for command in "" view render info budget; do run 0 "$karst" $command --help; done
run 0 "$bake" --help

# Refusals.
run 1 "$karst" info two.bil
run 1 "$karst" render two.karst -o two.karst
run 1 "$bake" nine.bil -o nine.bil --pixel-size 1
run 2 "$karst" render
run 2 "$bake"
echo "programs.sh: all commands end as they should"
