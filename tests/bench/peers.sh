#!/bin/bash
# SPDX-License-Identifier: MIT
# karst beside what users would choose instead and beside published schemes: same scene, camera path and
# machine, in turns.
# See usage below, and layers.sh; docs/run-time-against-error.md has the results.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=tests/bench/peers/scene.sh
source "$here/peers/scene.sh"

usage() {
  cat <<'END'
usage: peers.sh build SOURCES PEERS          builds the peers into folder PEERS; SOURCES: ../shared/peers
       peers.sh run PEERS KARST_BUILD [OUT]  measures them and karst, in turns; OUT: folder for the tables
                                             (PEERS/out)

`build` needs the Debian packages that SOURCES/README.md names; `run` also xvfb, and for the main thread's
time by library linux-perf. Both leave the repository alone. `run` says why and exits with 77 where the peers
are absent.

  ROUNDS=3      rounds of all programs; figures are medians over them; 0: tables of the last measurements
  ERRORS=1      measures the errors of pictures too; karst: only ours, the peers' are kept; 0: none
  KIND=ground   what karst bakes the scene as: ground or voxels
  TARGETS       karst's error targets: that of the default settings, and one whose p99 error is at most 1.3 px
                ("4 2.6"; of voxels "4 2.75")
END
}

say() { printf 'peers.sh: %s\n' "$*" >&2; }
skip() { say "skipped: $*"; exit 77; }

# The peers report no RMS of their errors; karst does.
add_rms() {
  sed -i -e 's/double s = 0; for (float e : st.px) s += e;/&\n  double s2 = 0;/' \
    -e 's/  auto q = \[&\](double p) { return double(st.px/  for (float e : st.px) s2 += double(e) * e;\n&/' \
    -e 's/p99.9 %.3f  max %.2f\\n"/p99.9 %.3f  max %.2f  rms %.3f\\n"/' \
    -e 's/q(.999), st.px.back());/q(.999), st.px.back(), std::sqrt(s2 \/ st.px.size()));/' "$1/peer_common.h"
  grep -q 'rms %.3f' "$1/peer_common.h" || say "the peers' sources are not as expected: no RMS"
}

build() {
  local sources=$1 peers=$2
  [[ -f $sources/peer_common.h ]] || skip "no peers' sources in $sources"
  mkdir -p "$peers/src" "$peers/data"
  cp -f "$sources"/* "$peers/src/"
  chmod -R u+w "$peers/src"
  echo "include($here/peers/layers.cmake)" >>"$peers/src/CMakeLists.txt"
  add_rms "$peers/src"
  cmake -S "$peers/src" -B "$peers/build" -G Ninja -DKARST_ROOT="$(realpath "$here/../..")" >/dev/null
  nice -n 10 cmake --build "$peers/build" --parallel "${JOBS:-2}" --target gen_terrain gen_layers \
    peer_ogre peer_ogre_layers peer_irrlicht peer_osg peer_clipmap peer_cdlod
}

# name, program and arguments. The first word of a name is the peer, the rest its setting.
programs=(
  "Irrlicht,patch 33 x1|peer_irrlicht 1 33"
  "Irrlicht,patch 17 x3|peer_irrlicht 3 17"
  "OSG,ratio 2|peer_osg 2"
  "OGRE Terrain,GLES2 error 8|peer_ogre gles2 8"
  "OGRE Terrain,GL3+ error 8|peer_ogre gl3plus 8"
  "OGRE Terrain,GL3+ error 1|peer_ogre gl3plus 1"
  "geometry clipmap,n 127|peer_clipmap 127"
  "geometry clipmap,n 255|peer_clipmap 255"
  "CDLOD,200 m of 32|peer_cdlod 200 32"
  "CDLOD,300 m of 16|peer_cdlod 300 16"
)
# Only seen once, for the plot.
more_programs=(
  "Irrlicht,patch 17 x1|peer_irrlicht 1 17"
  "Irrlicht,patch 17 x2|peer_irrlicht 2 17"
  "Irrlicht,patch 65 x1|peer_irrlicht 1 65"
  "OSG,ratio 4|peer_osg 4"
  "OSG,ratio 7|peer_osg 7"
  "OGRE Terrain,GL3+ error 4|peer_ogre gl3plus 4"
  "OGRE Terrain,GL3+ error 2|peer_ogre gl3plus 2"
  "geometry clipmap,n 63|peer_clipmap 63"
  "CDLOD,150 m of 16|peer_cdlod 150 16"
)

make_scene() {
  scene_inputs "$peers"
  local bake_as=("${scene_ground[@]}")
  if [[ $kind == voxels ]]; then bake_as=("${scene_bake[@]}"); fi
  "$bake" "${bake_as[@]}" -o peers.karst >"$out/bake.txt"
  scene_path >peers.txt
}

scene=(peers.karst --suite pareto --path peers.txt --distances none "${scene_drape[@]}")

# Prints "median p99 cpu_all cpu_main triangles draws rss_mib load_ms" of a peer.
peer_times() {
  PEER_DATA=$PWD xvfb-run -a -s "-screen 0 1280x720x24" "$peers/build/$1" "${@:2}" 2>/dev/null |
    awk '/^RESULT / {
      for (i = 1; i < NF; ++i) v[$i] = $(i + 1)
      print v["median"], v["p99"], v["threads)"], v["cpu(main)"], v["tris"], v["draws"], v["rss"], v["load"]
    }'
}
# Prints "mean rms p95 p99 max".
peer_errors() {
  PEER_DATA=$PWD xvfb-run -a -s "-screen 0 1280x720x24" "$peers/build/$1" "${@:2}" dump 2>/dev/null |
    awk '/^ERROR / {
      for (i = 1; i < NF; ++i) v[$i] = $(i + 1)
      if (v["mean"] != "") print v["mean"], v["rms"] ? v["rms"] : "-", v["p95"], v["p99"], v["max"]
    }'
}
json_number() { sed -n "s/.*\"$2\": \([0-9.]*\).*/\1/p" "$1" | head -n 1; }
karst_times() {
  "$bench" "${scene[@]}" --targets "$1" --no-errors --csv "$out/k.csv" --json "$out/k.json" >/dev/null
  csv_values "$out/k.csv" frame_median_ms frame_p99_ms all_cpu_ms main_cpu_ms triangles draw_calls
  echo "$(json_number "$out/k.json" peak_resident_mib) $(json_number "$out/k.json" first_frame_ms)"
}
karst_errors() {
  "$bench" "${scene[@]}" --targets "$1" --elevation terrain_1025.png --pixel-size $pixel_size \
    --z-scale $z_scale --csv "$out/k.csv" >/dev/null
  csv_values "$out/k.csv" error_mean_px error_rms_px error_p95_px error_p99_px error_max_px
}

# Appends "name|figures" to a file where the program gave any.
note() {
  local file=$1 name=$2 figures
  figures=$("${@:3}") || figures=
  if [[ -n $figures ]]; then echo "$name|$figures" >>"$file"; else say "no result of $name"; fi
}

# The main thread's CPU by shared object, of a karst at the default target, after it has loaded.
main_thread_by_library() {
  command -v perf >/dev/null || { say "no perf: the main thread's time by library is left out"; return; }
  perf record -q -e cpu-clock -F 4000 -D 1000 -o "$out/perf.data" \
    "$bench" "${scene[@]}" --targets "$1" --no-errors --csv "$out/k.csv" >/dev/null 2>&1 ||
    { say "perf does not work here"; return; }
  local main
  main=$(csv_value "$out/k.csv" main_cpu_ms)
  perf report -i "$out/perf.data" --sort comm,dso 2>/dev/null |
    awk -v main="$main" '$1 ~ /%$/ && $2 == "karst" { share[$3] += $1; sum += $1 }
      END {
        if (sum == 0) exit
        common = share["libc.so.6"] + share["libstdc++.so.6.0.30"] + share["libgcc_s.so.1"]
        printf "main thread %.2f ms a frame: karst %.3f,", main, main * share["karst"] / sum
        printf " libraries that the driver uses too %.3f,", main * common / sum
        printf " kernel %.3f ms\n", main * share["[kernel.kallsyms]"] / sum
      }'
}

# Medians over rounds by name, as CSV lines.
summarise() {
  sort -s -t'|' -k1,1 "$out/times.txt" | awk -F'|' -v date="$(date +%F)" -v errors="$out/errors.txt" '
    function median(list, n,   i, j, t) {
      for (i = 2; i <= n; ++i) {
        t = list[i]
        for (j = i - 1; j > 0 && list[j] > t; --j) list[j + 1] = list[j]
        list[j + 1] = t
      }
      return n % 2 ? list[(n + 1) / 2] : (list[n / 2] + list[n / 2 + 1]) / 2
    }
    function flush_name(   i, k, line) {
      if (name == "") return
      line = name
      for (k = 1; k <= 8; ++k) {
        for (i = 1; i <= n; ++i) { split(rows[i], f, " "); list[i] = f[k] + 0 }
        line = line "," median(list, n)
      }
      split(err[name], e, " ")
      for (k = 1; k <= 5; ++k) line = line "," (e[k] == "-" ? "" : e[k])
      print line "," n "," date
    }
    BEGIN {
      print "peer,setting,frame_median_ms,frame_p99_ms,all_cpu_ms,main_cpu_ms,triangles,draws,resident_mib," \
        "first_frame_ms,error_mean_px,error_rms_px,error_p95_px,error_p99_px,error_max_px,rounds,date"
      while ((getline line < errors) > 0) { split(line, p, "|"); err[p[1]] = p[2] }
    }
    $1 != name { flush_name(); name = $1; n = 0 }
    { rows[++n] = $2 }
    END { flush_name() }'
}

# Ratios of medians, each with what it must be.
judge() {
  awk -F, -v default_px="$1" -v fine_px="$2" '
    NR > 1 {
      key = $1 " " $2
      ms[key] = $3; rss[key] = $9; first[key] = $10; mean[key] = $11; p99[key] = $14; max[key] = $15
      if ($1 !~ /^(karst|geometry clipmap|CDLOD)$/ && (lean == 0 || $9 < lean)) lean = $9
    }
    function ratio(what, a, b, most) { if (b > 0) printf "%-62s %6.2f  (at most %s)\n", what, a / b, most }
    END {
      d = "karst error " default_px; f = "karst error " fine_px
      ratio("frame at " fine_px " px / Irrlicht patch 17 x3", ms[f], ms["Irrlicht patch 17 x3"], "0.6")
      ratio("frame at " fine_px " px / OSG ratio 2", ms[f], ms["OSG ratio 2"], "0.6")
      ratio("frame at " default_px " px / Irrlicht patch 33 x1", ms[d], ms["Irrlicht patch 33 x1"], "1")
      ratio("peak memory / the leanest peer", rss[d], lean, "0.5")
      printf "%-62s %6.0f  (at most 400)\n", "start of the process to first frame, ms", first[d]
      if (p99[f] != "") {
        printf "%-62s %6.2f  (at most 1.3)\n", "p99 error at " fine_px " px", p99[f]
        printf "%-62s %6.2f  (at most 0.5)\n", "mean error at " default_px " px", mean[d]
        printf "%-62s %6.2f  (at most 3.6)\n", "p99 error at " default_px " px", p99[d]
        printf "%-62s %6.2f\n", "largest error at " default_px " px", max[d]
      }
    }' "$out/results.csv"
}

# Depends on the peers alone, so that once is enough; and one lap of those that are in no ratio.
measure_peers_errors() {
  local entry
  : >"$out/errors.txt"
  for entry in "${programs[@]}" "${more_programs[@]}"; do
    # shellcheck disable=SC2086
    note "$out/errors.txt" "${entry%%|*}" peer_errors ${entry#*|}
  done
  for entry in "${more_programs[@]}"; do
    # shellcheck disable=SC2086
    note "$out/times.txt" "${entry%%|*}" peer_times ${entry#*|}
  done
}

run() {
  peers=$(cd "$1" 2>/dev/null && pwd) || skip "no folder $1; see peers.sh build"
  bench=$(realpath "$2/bench/karst-bench")
  bake=$(realpath "$2/bake/karst-bake")
  for program in gen_terrain peer_irrlicht peer_osg peer_ogre peer_clipmap peer_cdlod; do
    [[ -x $peers/build/$program ]] || skip "no $peers/build/$program; see peers.sh build"
  done
  [[ -x $bench && -x $bake ]] || skip "no karst-bench in $2"
  command -v xvfb-run >/dev/null || skip "no xvfb-run, which the peers need"
  mkdir -p "$peers/data" "${3:-$peers/out}"
  out=$(cd "${3:-$peers/out}" && pwd)
  cd "$peers/data"
  kind=${KIND:-ground}
  case $kind in
    ground) read -ra targets <<<"${TARGETS:-4 2.6}" ;;
    voxels) read -ra targets <<<"${TARGETS:-4 2.75}" ;;
    *) say "KIND=$kind: is ground or voxels"; exit 2 ;;
  esac
  make_scene
  if [[ ${ROUNDS:-3} != 0 ]]; then : >"$out/times.txt"; fi
  touch "$out/errors.txt"
  local round entry name target
  for ((round = 1; round <= ${ROUNDS:-3}; ++round)); do
    say "round $round of ${ROUNDS:-3}"
    for target in "${targets[@]}"; do note "$out/times.txt" "karst,error $target" karst_times "$target"; done
    for entry in "${programs[@]}"; do
      name=${entry%%|*}
      # shellcheck disable=SC2086
      note "$out/times.txt" "$name" peer_times ${entry#*|}
    done
  done
  case ${ERRORS:-1} in
    1) measure_peers_errors ;;
    karst) sed -i '/^karst,/d' "$out/errors.txt" ;;
  esac
  if [[ ${ERRORS:-1} != 0 ]]; then
    for target in "${targets[@]}"; do
      note "$out/errors.txt" "karst,error $target" karst_errors "$target"
    done
  fi
  summarise >"$out/results.csv"
  grep -v '^karst,' "$out/results.csv" >"$out/peers.csv"
  column -s, -t <"$out/results.csv" 2>/dev/null || cat "$out/results.csv"
  judge "${targets[0]}" "${targets[-1]}"
  if [[ ${ROUNDS:-3} != 0 ]]; then main_thread_by_library "${targets[0]}"; fi
}

case ${1:-} in
  build) [[ $# == 3 ]] || { usage >&2; exit 2; }; build "$2" "$3" ;;
  run) [[ $# == 3 || $# == 4 ]] || { usage >&2; exit 2; }; run "${@:2}" ;;
  -h | --help) usage ;;
  *) usage >&2; exit 2 ;;
esac
