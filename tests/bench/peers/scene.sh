#!/bin/bash
# SPDX-License-Identifier: MIT
# The peers' scene as karst's programs take it (../shared/peers/peer_common.h): heights of 16 bits up to
# 200 m, samples 4000 / 1024 m apart, a flight of 240 frames. Sourced by peers.sh, layers.sh and pixels.sh.
# shellcheck disable=SC2034
pixel_size=3.90625
z_scale=0.0030518043793392844
scene_bake=(terrain_1025.png --pixel-size "$pixel_size" --z-scale "$z_scale" --voxel 100 --levels 4)
# The same as a ground.
scene_ground=(terrain_1025.png --pixel-size "$pixel_size" --z-scale "$z_scale" --ground --materials none)
scene_drape=(--drape diffuse_1024.png --drape-repeat 32)

# The flight as a path file.
scene_path() {
  awk 'BEGIN {
    pi = atan2(0, -1)
    for (k = 0; k < 240; ++k) {
      a = 2 * pi * k / 240
      x = 1200 * cos(a); y = 260; z = 1200 * sin(a)
      dx = 600 * cos(a + 1) - x; dy = 60 - y; dz = 600 * sin(a + 1) - z
      printf "%.9f %.9f %.9f %.12f %.12f\n", x, y, z, atan2(-dx, -dz) * 180 / pi,
        atan2(dy, sqrt(dx * dx + dz * dz)) * 180 / pi
    }
  }'
}
# Inputs of all programs, in the folder of the peers' data, once.
scene_inputs() { [[ -s terrain_1025.png && -s diffuse_1024.png ]] || "$1/build/gen_terrain" >&2; }

# Of the first line of figures.
csv_value() {
  awk -F, -v want="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == want) n = i } NR == 2 { print $n }' "$1"
}
# Several of them.
csv_values() {
  local name
  for name in "${@:2}"; do printf '%s ' "$(csv_value "$1" "$name")"; done
}
