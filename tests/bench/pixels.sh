#!/bin/bash
# SPDX-License-Identifier: MIT
# What a pixel costs, beside the same pictures by an older karst (commit 270a61a), in turns.
# See usage below; docs/benchmarks.md has the results.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
# shellcheck source=tests/bench/peers/scene.sh
source "$root/tests/bench/peers/scene.sh"
commit=270a61a
old=$root/build/pixels/$commit

usage() {
  cat <<'END'
usage: pixels.sh build            builds commit 270a61a in build/pixels/270a61a
       pixels.sh run KARST_BUILD [OUT] [-- OPTION...]
                                  measures it and KARST_BUILD in turns; OUT: folder for worlds, pictures and
                                  tables (build/pixels/out); options go to the newer karst alone

1280 x 720, both at their defaults. Each bakes its own worlds. `default` is the picture of the whole world,
drawn again and again; `low` is pieces of four frames of the low flight (karst-bench --suite flight) with 120
frames a lap; `drape` is pieces of three frames of the peers' flight, with one texture. A lap warms up, the
second one is measured. Printed are medians over frames, then over rounds: milliseconds of a frame by the
clock and by the CPU time of all threads, CPU nanoseconds a pixel that shows terrain, and GPU memory. `run`
leaves out the worlds whose data are absent, says why, and exits with 77 where there is nothing to compare
with.

  ROUNDS=3            rounds of all cases
  CASES               of "canyon-default canyon-low bigtujunga-default bigtujunga-low drape" (all)
  SHADOWS="0 2"       shadow maps
  PEERS=build/peers   folder of `peers.sh build`, for drape
  DATA=../shared/data folder of bigtujunga.tif
  GROUND=1            the newer karst draws elevation models as grounds of tiles, not as voxels; 0: as voxels
  PICTURES=1          the first picture of each case by both, OUT/CASE-MAPS-{old,new}.png; 0: none
END
}

say() { printf 'pixels.sh: %s\n' "$*" >&2; }
skip() { say "skipped: $*"; exit 77; }

# The suite pareto of that commit always draws without shadow maps; here it also takes --shadows N.
add_shadows() {
  local file=$old/app/bench_command.cpp
  sed -i -e 's/{{"suite"},$/{{"suite"}, {"shadows"},/' \
    -e 's/options.shadows.count = 0;.*/options.shadows.count = std::atoi(text("shadows").c_str());/' "$file"
  [[ $(grep -c '{"shadows"},\|text("shadows")' "$file") == 2 ]] ||
    { say "$commit is not as expected: no --shadows"; exit 1; }
}

build() {
  git -C "$root" cat-file -e "$commit^{commit}" 2>/dev/null || skip "no commit $commit in this clone"
  if [[ ! -d $old ]]; then
    mkdir -p "$old.part"
    git -C "$root" archive "$commit" | tar -x -C "$old.part"
    mv "$old.part" "$old"
    add_shadows
  fi
  (cd "$old" && cmake --preset release -DKARST_TESTS=OFF >/dev/null &&
    nice -n 10 cmake --build --preset release --parallel "${JOBS:-2}" --target karst karst-bake)
}

# Arguments of karst-bake and the flight of a world.
world_bake() {
  case $1 in
    canyon) printf '%s\n' --sample canyon --no-ground ;;
    bigtujunga) printf '%s\n' "$data/bigtujunga.tif" --voxel 256 --levels 4 ;;
    drape) printf '%s\n' "${scene_bake[@]}" ;;
  esac
}
prepare_world() {
  local world=$1 words old_words
  mapfile -t words < <(world_bake "$world")
  # The older one knows samples as voxels alone.
  mapfile -t old_words < <(printf '%s\n' "${words[@]}" | grep -vx -- --no-ground)
  "$old_bake" "${old_words[@]}" -o "$world-old.karst" --quiet
  if [[ $world != drape ]]; then "$new_bake" "${words[@]}" -o "$world-voxels.karst" --quiet; fi
  if [[ ${GROUND:-1} != 0 && $world != canyon ]]; then mapfile -t words < <(as_ground "${words[@]}"); fi
  "$new_bake" "${words[@]}" -o "$world-new.karst" --quiet
}
# karst-bake's arguments without those of voxels.
as_ground() {
  while [[ $# -gt 0 ]]; do
    case $1 in
      --voxel | --levels) shift 2 ;;
      *) printf '%s\n' "$1"; shift ;;
    esac
  done
  printf '%s\n' --ground
}

# The flight of a case, CASE.txt, over what voxels make of the world. Its pixels of terrain are counted in
# pictures of a sixteenth of the size.
prepare_flight() {
  local world=${1%-*}-voxels kind=${1#*-} count=(--suite flight --size 320x180 --shadows 0)
  case $kind in
    default) "$new_bench" "$world.karst" "${count[@]}" --frames 12 >"$1.txt" ;;
    low)
      "$new_bench" "$world.karst" "${count[@]}" --flight low --frames 120 |
        awk '/^#/ { print; next } n++ % 40 < 4' >"$1.txt"
      ;;
    drape) scene_path | awk 'n++ % 60 < 3' >"$1.txt" ;;
  esac
}
# What README.md of the peers says of their scene: 62 % of the picture.
terrain_pixels() {
  awk '$6 == "#" { sum += $7; ++n } END { printf "%.0f\n", n ? 16 * sum / n : 575000 }' "$1.txt"
}

case_words() { if [[ $1 == drape ]]; then printf '%s\n' "${scene_drape[@]}"; fi; }
# Prints "frame_ms cpu_ms" of a program, medians over frames. time_of CASE old|new MAPS
time_of() {
  local name=$1 side=$2 words program=("$old_karst" bench)
  mapfile -t words < <(case_words "$name")
  if [[ $side == new ]]; then
    program=("$new_bench")
    words+=("${options[@]}")
  fi
  if [[ $name != drape ]]; then words+=(--shadows "$3"); fi
  "${program[@]}" "${name%-*}-$side.karst" --suite pareto --path "$name.txt" --targets 4 --distances none \
    --no-errors "${words[@]}" --csv frames.csv >/dev/null 2>frames.err || { cat frames.err >&2; return 1; }
  csv_values frames.csv frame_median_ms all_cpu_ms
}
# Prints GPU MiB of karst render; leaves its picture too. memory_of CASE old|new MAPS
memory_of() {
  local name=$1 side=$2 words karst=$old_karst
  mapfile -t words < <(case_words "$name")
  if [[ $side == new ]]; then
    karst=$new_karst
    words+=("${options[@]}")
  fi
  if [[ $name != drape ]]; then words+=(--shadows "$3"); fi
  if [[ ${PICTURES:-1} != 0 ]]; then words+=(-o "$name-$3-$side.png"); fi
  words+=(--camera "$(awk -v OFS=, '!/^#/ { print $1, $2, $3, $4, $5; exit }' "$name.txt")")
  "$karst" render "${name%-*}-$side.karst" "${words[@]}" --stats - 2>/dev/null |
    sed -n 's/.*"gpu_used": \([0-9]*\).*/\1/p' | awk '{ printf "%.2f", $1 / 1048576 }'
}

# From lines "case maps side frame_ms cpu_ms" of all rounds, "case maps pixels mib_old mib_new" of memory.txt.
summarise() {
  awk '
    function median(key, n,   i, j, t) {
      for (i = 1; i <= n; ++i) list[i] = value[key, i]
      for (i = 2; i <= n; ++i) {
        t = list[i]
        for (j = i - 1; j > 0 && list[j] > t; --j) list[j + 1] = list[j]
        list[j + 1] = t
      }
      return n % 2 ? list[(n + 1) / 2] : (list[n / 2] + list[n / 2 + 1]) / 2
    }
    function add(key, v) { value[key, ++count[key]] = v }
    BEGIN {
      print "case,shadow_maps,old_frame_ms,new_frame_ms,old_cpu_ms,new_cpu_ms,cpu_ratio,most_ratio," \
        "new_cpu_ns_a_pixel,old_gpu_mib,new_gpu_mib,rounds"
    }
    FILENAME == ARGV[1] {
      key = $1 "," $2
      add(key "," $3 "frame", $4); add(key "," $3 "cpu", $5)
      if ($3 == "old") before[key] = $5
      else add(key ",ratio", $5 / before[key])
      next
    }
    {
      key = $1 "," $2
      n = count[key ",ratio"]
      if (n == 0) next
      cpu = median(key ",newcpu", n)
      printf "%s,%.1f,%.1f,%.1f,%.1f,%.3f,%s,%.0f,%s,%s,%d\n", key, median(key ",oldframe", n),
        median(key ",newframe", n), median(key ",oldcpu", n), cpu, median(key ",ratio", n),
        $1 == "drape" ? "0.75" : $2 == 0 ? "0.20" : "0.26", cpu * 1e6 / $3, $4, $5, n
    }' rounds.txt memory.txt
}

run() {
  local build out=$root/build/pixels/out name world worlds=" " maps round side figures
  build=$(realpath "$1"); shift
  if [[ $# -gt 0 && $1 != -- ]]; then out=$1; shift; fi
  if [[ $# -gt 0 ]]; then shift; fi
  options=("$@")
  old_karst=$old/build/release/app/karst old_bake=$old/build/release/app/bake/karst-bake
  new_karst=$build/app/karst new_bake=$build/bake/karst-bake new_bench=$build/bench/karst-bench
  [[ -x $old_karst && -x $old_bake ]] || skip "no $old_karst; see pixels.sh build"
  for name in "$new_karst" "$new_bake" "$new_bench"; do [[ -x $name ]] || skip "no $name"; done
  data=$(realpath -m "${DATA:-$root/../shared/data}")
  peers=$(realpath -m "${PEERS:-$root/build/peers}")
  mkdir -p "$out"
  cd "$out"
  local cases=() all="${CASES:-canyon-default canyon-low bigtujunga-default bigtujunga-low drape}"
  for name in $all; do
    if [[ $name == bigtujunga* && ! -s $data/bigtujunga.tif ]]; then
      say "no $data/bigtujunga.tif: $name is left out"
    elif [[ $name == drape && ! -x $peers/build/gen_terrain ]]; then
      say "no $peers/build/gen_terrain: drape is left out"
    else
      cases+=("$name")
    fi
  done
  [[ ${#cases[@]} -gt 0 ]] || skip "no data"
  for name in "${cases[@]}"; do
    world=${name%-*}
    if [[ $world == drape ]]; then scene_inputs "$peers"; fi
    if [[ $worlds != *" $world "* ]]; then
      prepare_world "$world"
      worlds+="$world "
    fi
    prepare_flight "$name"
  done
  : >rounds.txt
  : >memory.txt
  for ((round = 1; round <= ${ROUNDS:-3}; ++round)); do
    say "round $round of ${ROUNDS:-3}"
    for name in "${cases[@]}"; do
      for maps in ${SHADOWS:-0 2}; do
        if [[ $name == drape && $maps != 0 ]]; then continue; fi
        for side in old new; do
          figures=$(time_of "$name" $side "$maps")
          echo "$name $maps $side $figures" >>rounds.txt
        done
        if [[ $round == 1 ]]; then
          echo "$name $maps $(terrain_pixels "$name") $(memory_of "$name" old "$maps")" \
            "$(memory_of "$name" new "$maps")" >>memory.txt
        fi
      done
    done
  done
  summarise >results.csv
  column -s, -t results.csv 2>/dev/null || cat results.csv
}

case ${1:-} in
  build) [[ $# == 1 ]] || { usage >&2; exit 2; }; build ;;
  run) [[ $# -ge 2 ]] || { usage >&2; exit 2; }; run "${@:2}" ;;
  -h | --help) usage ;;
  *) usage >&2; exit 2 ;;
esac
