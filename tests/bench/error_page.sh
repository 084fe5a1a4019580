#!/bin/bash
# SPDX-License-Identifier: MIT
# Writes docs/run-time-against-error.md, its plots and its table of peers from new measurements.
set -euo pipefail

if [[ $# != 3 ]]; then
  cat >&2 <<'END'
usage: error_page.sh PEERS KARST_BUILD DEM

PEERS: of peers.sh, which has been run. DEM: an elevation image of karst-bake's, for flights over real ground.
  FRAMES=24     of each standard flight
  SIZE=640x360  of their pictures
  NOTE          a sentence about the machine
END
  exit 2
fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
peers=$(cd "$1" && pwd)
bench=$(realpath "$2/bench/karst-bench")
bake=$(realpath "$2/bake/karst-bake")
dem=$(realpath "$3")
out=$peers/out
[[ -s $out/results.csv ]] || { echo "error_page.sh: no $out/results.csv; see peers.sh run" >&2; exit 1; }

cd "$peers/data"
awk 'NR % 8 == 1' peers.txt >every-eighth.txt
"$bench" peers.karst --suite pareto --path every-eighth.txt --drape diffuse_1024.png --drape-repeat 32 \
  --targets 1,2,2.75,4,8,16 --distances 8,16,32 \
  --elevation terrain_1025.png --pixel-size 3.90625 --z-scale 0.0030518043793392844 \
  --csv "$out/sweep.csv" --svg "$root/docs/images/error-peers.svg" --peers "$out/peers.csv"

[[ -s dem.karst ]] || "$bake" "$dem" -o dem.karst --voxel 256 --levels 4 --quiet
"$bench" dem.karst --suite pareto --frames "${FRAMES:-24}" --size "${SIZE:-640x360}" \
  --targets 1,2,4,8,16 --distances 16,32 --drape diffuse_1024.png --drape-repeat 32 \
  --csv "$out/dem.csv" --svg "$root/docs/images/error-dem.svg"
cp "$out/peers.csv" "$root/docs/images/peers.csv"

# A table's head from names with | between them.
header() {
  local names
  names=$(printf '%s' "$@")
  echo "| ${names//|/ | } |"
  echo "|${names//[!|]/}|" | sed 's/|/|---/g; s/---$//'
}

# Markdown rows of a CSV file: rows FIRST COLUMN... prints the columns by name, numbers to three digits.
rows() {
  awk -F, -v names="$2" -v keep="${3:-}" '
    function tidy(text) {
      if (text == "") return "–"
      if (text !~ /^-?[0-9.]+(e[-+]?[0-9]+)?$/) return text
      if (text >= 1000) return sprintf("%d", text + 0.5)
      if (text >= 100) return sprintf("%.0f", text)
      if (text >= 10) return sprintf("%.1f", text)
      return sprintf("%.2f", text)
    }
    NR == 1 { n = split(names, want, " "); for (i = 1; i <= NF; ++i) at[$i] = i; next }
    keep == "" || $0 ~ keep {
      line = "|"
      for (i = 1; i <= n; ++i) line = line " " tidy($at[want[i]]) " |"
      print line
    }' "$1"
}

{
  cat <<'END'
# Run time against error

How long a frame takes against how far its picture is from the truth, for karst and for what users would
choose instead. The page, its plots and its numbers are made by

    tests/bench/peers.sh build ../shared/peers PEERS
    tests/bench/peers.sh run PEERS build/release
    tests/bench/error_page.sh PEERS build/release ../shared/data/bigtujunga.tif

The error of a picture is measured from its depth (`bench/measure/picture_error.h`). Against elevation: the
distance in pixels between what is seen at a pixel and the elevation above or below it. Against a picture of
the full level: the distance of the surfaces, in pixels at most. Times are medians of frames that end with
`glFinish`; the metric is not part of them, nor of the memory. By error, `target` is `--error-px`; by
distance it is `--lod-distance`: levels of voxels are K's and pop,
nodes of a ground are split by distance over side as S splits them, and morph.

END
  echo "Measured on $(date +%F) at $(git -C "$root" rev-parse --short HEAD) with $(nproc) cores and" \
    "$(sed -n 's/.*"renderer": "\(.*\)".*/\1/p' "$out/k.json")."
  echo "${NOTE:-}"
  cat <<'END'

## Beside other engines

The scene of the peers: a heightmap of 1025² samples, one texture, 1280 × 720, a flight of 240 frames. karst
draws it baked with `--ground`, or with `KIND=voxels` with voxels of 100 m at level 4 (fit error RMS 0.078
m), with `--drape`. Programs took turns; figures are medians over the rounds. Irrlicht and OSG do not morph.
Memory is the process's peak. The geometry clipmap and CDLOD are programs of our own after A. Asirvatham and
H. Hoppe and after F. Strugar (`tests/bench/peers`), in OpenGL ES 3.0 as karst: *n* is the side of a level's
grid in vertices, *m* the range of the finest level, then the quads of a node's side.

END
  header "program|setting|frame ms|p99 ms|CPU ms, all|main thread|triangles|memory MiB|first frame ms" \
    "|error px, mean|RMS|p99|max"
  rows "$out/results.csv" "peer setting frame_median_ms frame_p99_ms all_cpu_ms main_cpu_ms triangles \
resident_mib first_frame_ms error_mean_px error_rms_px error_p99_px error_max_px"
  cat <<'END'

![Frame time, triangles and memory against RMS, p99 and maximum error](images/error-peers.svg)

The sweep, over every eighth frame of the flight:

END
  header "levels|target|frame ms|triangles|GPU MiB used|error px, mean|RMS|p99|max"
  rows "$out/sweep.csv" "mode target frame_median_ms triangles working_set_mib error_mean_px error_rms_px \
error_p99_px error_max_px"
  cat <<END

## Flights over real ground

\`$(basename "$dem")\` with voxels of 256 m at level 4, ${SIZE:-640x360}, ${FRAMES:-24} frames a flight, the
same texture; errors against pictures of the full level. *low* skims the ground, *oblique* looks down and
across, *high* sees all of the world, *teleport* is elsewhere in each frame. The maximum holds single pixels
of ground that only one of the two pictures shows, behind a ridge that moved by a pixel.

![The same, for four flights](images/error-dem.svg)

END
  header "flight|levels|target|frame ms|p99 ms|triangles|GPU MiB used|error px, mean|RMS|p99|max"
  rows "$out/dem.csv" "path mode target frame_median_ms frame_p99_ms triangles working_set_mib error_mean_px \
error_rms_px error_p99_px error_max_px"
} >"$root/docs/run-time-against-error.md"
