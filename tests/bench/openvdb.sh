#!/bin/bash
# SPDX-License-Identifier: MIT
# Isosurfaces of one field by OpenVDB's volumeToMesh and by karst, in turns: CPU time a vertex and the ratio.
#   openvdb.sh [ROUNDS]    (21); needs the Debian packages libopenvdb-dev, libtbb-dev, libimath-dev
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
case ${1:-} in
-h | --help)
  sed -n '3,4s/^# *//p' "${BASH_SOURCE[0]}"
  exit 0
  ;;
esac
[[ -f /usr/include/openvdb/openvdb.h ]] || { echo "openvdb.sh: skipped: no libopenvdb-dev" >&2; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${CXX:-c++}" -std=c++20 -O2 -ffp-contract=off -I"$root" -I"$root/include" -I/usr/include/Imath \
  "$root"/tests/bench/peers/volume_to_mesh.cpp "$root"/terrain/isosurface/*.cpp \
  -lopenvdb -ltbb -lImath-3_1 -o "$work/volume_to_mesh"
"$work/volume_to_mesh" "${1:-21}"
