#!/bin/bash
# SPDX-License-Identifier: MIT
# Five layers of ground with normal maps: karst's materials beside OGRE's own terrain material, in turns.
# See usage below; docs/benchmarks.md has the results.
set -euo pipefail
# shellcheck source=tests/bench/peers/scene.sh
source "$(dirname "${BASH_SOURCE[0]}")/peers/scene.sh"

usage() {
  cat <<'END'
usage: layers.sh PEERS KARST_BUILD [OUT] [-- OPTION...]

PEERS: folder of `peers.sh build`; OUT: folder for worlds, pictures and tables (PEERS/layers); options go to
karst alone. The peers' scene and flight, 1280 x 720, no shadow maps. Both draw the same five images of
albedo, normals and height, as often a metre; where they lie follows the same limits of slope and height,
from blend maps of 1024 x 1024 texels in OGRE, from rules in karst. OGRE's material is the one that it has by
default (diffuse and specular, normals, parallax), and the same without parallax, which karst has not; karst
maps on three planes, at two scales. karst's error target is the largest of TARGETS whose p99 error is at
most OGRE's. Pictures: OUT/{ogre_gl3plus,karst}_{far,near}.png. Exits with 77 where OGRE is absent.

  ROUNDS=3               rounds of all programs; figures are medians over frames, then over rounds
  PIECE=30               of each 30 frames of the flight so many are drawn
  TARGETS="4 16 64"      error targets of karst, pixels
  SIDE=256               texels a side of the images
  REPEAT=100             metres that an image of OGRE's covers: what karst's nearer scale covers
END
}

say() { printf 'layers.sh: %s\n' "$*" >&2; }
skip() { say "skipped: $*"; exit 77; }

# Name, and arguments of peer_ogre_layers.
programs=(
  "OGRE GL3+ error 8|gl3plus 8 1"
  "OGRE GL3+ error 8 no parallax|gl3plus 8 0"
  "OGRE GL3+ error 1|gl3plus 1 1"
  "OGRE GL3+ error 1 no parallax|gl3plus 1 0"
)
# Light travels along (-0.5, -0.7, -0.5).
look=(--sun "135,44.710" --shadows 0)

ogre() {
  PEER_DATA=$PWD xvfb-run -a -s "-screen 0 1280x720x24" "$peers/build/peer_ogre_layers" "$@" 2>/dev/null
}
# Prints "frame cpu" of a program, medians.
ogre_times() {
  # shellcheck disable=SC2086
  ogre $1 "${REPEAT:-100}" "${PIECE:-30}" | awk '/^MEDIANS/ { print $3, $5 }'
}
# Prints the p99 error.
ogre_error() {
  # shellcheck disable=SC2086
  ogre $1 "${REPEAT:-100}" 1 dump >dump.txt
  [[ $(grep -c '^TEXTURE.*_normal_height' dump.txt) == 5 ]] ||
    { say "OGRE draws fewer than five layers"; exit 1; }
  awk '/^ERROR/ { for (i = 1; i < NF; ++i) if ($i == "p99") print $(i + 1) }' dump.txt
}
karst() {
  "$bench" layers.karst --suite pareto --distances none "${look[@]}" "${options[@]}" --csv k.csv \
    "$@" >/dev/null
}
karst_times() {
  karst --path piece.txt --targets "$1" --no-errors
  csv_values k.csv frame_median_ms all_cpu_ms
}
karst_error() {
  karst --path errors.txt --targets "$1" --elevation terrain_1025.png --pixel-size "$pixel_size" \
    --z-scale "$z_scale"
  csv_value k.csv error_p99_px
}
# The same places as peer_ogre_layers has them.
karst_pictures() {
  local far near="700,~12,400,63.4349,-15.0198"
  far=$(head -n 1 errors.txt | tr ' ' ,)
  "$render" render layers.karst "${look[@]}" "${options[@]}" --camera "$far" -o karst_far.png
  "$render" render layers.karst "${look[@]}" "${options[@]}" --camera "$near" -o karst_near.png
}

prepare() {
  scene_inputs "$peers"
  PEER_DATA=$PWD "$peers/build/gen_layers" "${SIDE:-256}" >shares.txt
  "$bake" "${scene_bake[@]}" --materials layers.json -o layers.karst --quiet
  scene_path | awk -v piece="${PIECE:-30}" '(NR - 1) % 30 < piece' >piece.txt
  scene_path | awk '(NR - 1) % 40 == 0' >errors.txt
}

# errors.csv: "name|p99" of all. Prints karst's largest target whose error is at most so large.
target_for() {
  awk -F'|' -v most="$1" '
    $1 ~ /^karst / && $2 <= most {
      sub("karst ", "", $1)
      if ($1 + 0 > best) best = $1 + 0
    }
    END { print best }' errors.csv
}

# Lines "name|frame cpu" of all rounds, in rounds.txt, to a table; ratios are medians over rounds.
summarise() {
  awk -F'|' '
    function median(key, n,   i, j, t) {
      for (i = 1; i <= n; ++i) list[i] = value[key, i]
      for (i = 2; i <= n; ++i) {
        t = list[i]
        for (j = i - 1; j > 0 && list[j] > t; --j) list[j + 1] = list[j]
        list[j + 1] = t
      }
      return n % 2 ? list[(n + 1) / 2] : (list[n / 2] + list[n / 2 + 1]) / 2
    }
    FILENAME == "errors.csv" { error[$1] = $2; next }
    FILENAME == "rounds.txt" {
      if (!($1 in count)) order[++names] = $1
      split($2, f, " "); n = ++count[$1]
      value[$1 "frame", n] = f[1]; value[$1 "cpu", n] = f[2]
      next
    }
    { pair[$1] = $2 }
    END {
      print "program,p99_error_px,frame_ms,cpu_ms,karst_at_equal_error,cpu_ratio,karst_by_default," \
        "cpu_ratio_by_default"
      for (k = 1; k <= names; ++k) {
        name = order[k]; n = count[name]
        line = sprintf("%s,%.2f,%.1f,%.1f", name, error[name], median(name "frame", n), median(name "cpu", n))
        if (!(name in pair)) { print line ",,,,"; continue }
        split("karst " pair[name] "|karst " first, others, "|")
        for (o = 1; o <= 2; ++o) {
          for (i = 1; i <= n; ++i) value["ratio", i] = value[others[o] "cpu", i] / value[name "cpu", i]
          line = line sprintf(",%s,%.3f", others[o], median("ratio", n))
        }
        print line
      }
    }' first="${TARGETS%% *}" errors.csv rounds.txt pairs.txt
}

run() {
  local out entry name target round wanted=()
  peers=$(cd "$1" 2>/dev/null && pwd) || skip "no folder $1; see peers.sh build"
  bench=$(realpath "$2/bench/karst-bench")
  bake=$(realpath "$2/bake/karst-bake")
  render=$(realpath "$2/app/karst")
  out=$peers/layers
  shift 2
  if [[ $# -gt 0 && $1 != -- ]]; then out=$1; shift; fi
  if [[ $# -gt 0 ]]; then shift; fi
  options=("$@")
  TARGETS=${TARGETS:-4 16 64}
  for name in gen_terrain gen_layers peer_ogre_layers; do
    [[ -x $peers/build/$name ]] || skip "no $peers/build/$name; see peers.sh build"
  done
  [[ -x $bench && -x $bake && -x $render ]] || skip "no karst, karst-bench and karst-bake in $2"
  command -v xvfb-run >/dev/null || skip "no xvfb-run, which OGRE needs"
  mkdir -p "$out"
  cd "$out"
  prepare
  say "errors and pictures"
  : >errors.csv
  for target in $TARGETS; do echo "karst $target|$(karst_error "$target")" >>errors.csv; done
  for entry in "${programs[@]}"; do echo "${entry%%|*}|$(ogre_error "${entry#*|}")" >>errors.csv; done
  karst_pictures
  : >pairs.txt
  for entry in "${programs[@]}"; do
    target=$(target_for "$(awk -F'|' -v name="${entry%%|*}" '$1 == name { print $2 }' errors.csv)")
    echo "${entry%%|*}|$target" >>pairs.txt
    [[ " ${wanted[*]} " == *" $target "* ]] || wanted+=("$target")
  done
  [[ " ${wanted[*]} " == *" ${TARGETS%% *} "* ]] || wanted+=("${TARGETS%% *}")
  : >rounds.txt
  for ((round = 1; round <= ${ROUNDS:-3}; ++round)); do
    say "round $round of ${ROUNDS:-3}"
    for target in "${wanted[@]}"; do echo "karst $target|$(karst_times "$target")" >>rounds.txt; done
    for entry in "${programs[@]}"; do echo "${entry%%|*}|$(ogre_times "${entry#*|}")" >>rounds.txt; done
  done
  summarise >results.csv
  column -s, -t results.csv 2>/dev/null || cat results.csv
}

case ${1:-} in
  -h | --help) usage ;;
  *) [[ $# -ge 2 ]] || { usage >&2; exit 2; }; run "$@" ;;
esac
