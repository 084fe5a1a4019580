#!/bin/bash
# SPDX-License-Identifier: MIT
# The same cave in a ground as patches and as a field (karst-bake --carve-as): bytes, triangles, error from
# the shape both ways, time to bake; then time a frame from inside and from above, in turns.
#   cave.sh [BUILD [ROUNDS]]    (build/release 9); needs shared/data for the frames
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
case ${1:-} in
-h | --help)
  sed -n '3,5s/^# *//p' "${BASH_SOURCE[0]}"
  exit 0
  ;;
esac
build=${1:-$root/build/release}
rounds=${2:-9}
"$build/tests/karst_tiles_tests" --gtest_filter='CaveComparison.*' | sed -n 's/^FIGURE //p'
dem=$root/../shared/data/bigtujunga.tif
[[ -f $dem ]] || { echo "cave.sh: no frames: $dem is not there" >&2; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat > "$work/cave.json" <<'JSON'
[{"shape": "capsule", "op": "empty", "radius": 20, "blend": 6,
  "points": [[2550, 1664, 4420], [2550, 1668, 4330], [2530, 1672, 4270], [2560, 1676, 4200]]},
 {"shape": "sphere", "op": "empty", "center": [2570, 1682, 4170], "radius": 46, "blend": 8}]
JSON
for kind in patches field; do
  "$build/bake/karst-bake" "$dem" --carve "$work/cave.json" --carve-as $kind --materials none --quiet \
    -o "$work/$kind.karst"
done
for camera in 2550,1672,4300,180,0 2500,1800,4550,0,-25; do
  for _ in $(seq 8); do echo "${camera//,/ }"; done > "$work/path.txt"
  for _ in $(seq "$rounds"); do
    for kind in patches field; do
      LIBGL_ALWAYS_SOFTWARE=1 "$build/app/karst" render "$work/$kind.karst" --path "$work/path.txt" \
        --size 640x400 -o "$work/$kind.png" --stats "$work/$kind.json"
      sed -n '/"frame_ms"/,/}/s/.*"median": \([0-9.]*\).*/\1/p' "$work/$kind.json" >> "$work/$kind.ms"
      sed -n 's/^ *"triangles": \([0-9]*\).*/\1/p' "$work/$kind.json" | head -1 > "$work/$kind.count"
    done
  done
  for kind in patches field; do
    median=$(sort -n "$work/$kind.ms" | awk '{a[NR] = $1} END {print a[int((NR + 1) / 2)]}')
    echo "$camera $kind: $median ms a frame, $(cat "$work/$kind.count") triangles"
    rm "$work/$kind.ms"
  done
done
