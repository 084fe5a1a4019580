#!/bin/bash
# SPDX-License-Identifier: MIT
# kill_bake.sh KARST KARST-BAKE COUNT [ground]: ends bakes that overwrite a world, of voxels or of tiles,
# until COUNT of them were killed, at times all over their run and, every second one, while the new file is
# there, with SIGINT, SIGTERM and SIGKILL in turn. Each time the old world or the new one must be there,
# whole; after SIGINT and SIGTERM nothing else; what SIGKILL leaves must be gone after the next whole bake.
set -euo pipefail
# shellcheck source=tests/cli/ramp_dem.sh
source "$(dirname "${BASH_SOURCE[0]}")/ramp_dem.sh"
karst=$1 bake=$2 count=$3 kind=${4:-voxels}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir worlds
# Without textures the bake is short, and its write a large part of it. words N: of the Nth of two.
if [[ $kind == ground ]]; then
  ramp_dem 500
  words() { input=(dem.bil --ground --pixel-size "1$1"); }
else
  words() { input=(--sample hills --no-ground --voxel "$1" --levels 3); }
fi
bake_world() {
  words "$1"
  "$bake" "${input[@]}" -o worlds/w.karst --materials none --quiet
}

bake_world 80
old=$(sha256sum <worlds/w.karst)
start=$(date +%s%N)
bake_world 79
span_us=$((($(date +%s%N) - start) / 1000))
new=$(sha256sum <worlds/w.karst)
torn=0 leftovers=0 killed=0 replaced=0 writing=0
for ((n = 0; killed < count; ++n)); do
  signals=(INT TERM KILL)
  signal=${signals[n % 3]}
  words $((79 + n % 2))
  # A shell's background commands ignore SIGINT.
  env --default-signal=INT "$bake" "${input[@]}" -o worlds/w.karst \
    --materials none --quiet &
  child=$!
  # From the start to about the end, by a step that shares no divisor with the range.
  wait_us=$(((n * 7919) % span_us))
  sleep "$(printf '%d.%06d' $((wait_us / 1000000)) $((wait_us % 1000000)))"
  if ((n % 2 == 1)); then
    until [[ -e worlds/.karst-$child-0.tmp || ! -e /proc/$child/exe ]]; do :; done
    if [[ -e worlds/.karst-$child-0.tmp ]]; then writing=$((writing + 1)); fi
  fi
  kill -s "$signal" "$child" 2>/dev/null || true
  code=0
  wait "$child" 2>/dev/null || code=$?
  if ((code > 128)); then killed=$((killed + 1)); fi
  now=$(sha256sum <worlds/w.karst)
  if [[ $now != "$old" && $now != "$new" ]]; then torn=$((torn + 1)); fi
  if ((code == 0)); then replaced=$((replaced + 1)); fi
  if [[ $signal != KILL ]]; then
    # Files of others are what an earlier SIGKILL left, where this bake ended before it swept.
    leftovers=$((leftovers + $(find worlds -name ".karst-$child-*" | wc -l)))
  fi
done
bake_world 79
rest=$(find worlds -mindepth 1 ! -name w.karst | wc -l)
"$karst" info worlds/w.karst >/dev/null
text='%d killed, %d of them while the new file was there, %d done: %d torn, '
text+='%d leftovers after SIGINT and SIGTERM, %d after the next bake\n'
# shellcheck disable=SC2059  # it is the format
printf "$text" \
  "$killed" "$writing" "$replaced" "$torn" "$leftovers" "$rest"
((torn == 0 && leftovers == 0 && rest == 0 && killed > 0))
