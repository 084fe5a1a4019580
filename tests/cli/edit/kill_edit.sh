#!/bin/bash
# SPDX-License-Identifier: MIT
# kill_edit.sh KARST KARST-BAKE COUNT [ground]: ends karst edit while it saves in place over a world, of
# voxels or of tiles, with SIGKILL, until COUNT were killed while the new file was there: the world must be
# the old one or the new one, and what is left must be gone after the next edit.
set -euo pipefail
# shellcheck source=tests/cli/ramp_dem.sh
source "$(dirname "${BASH_SOURCE[0]}")/../ramp_dem.sh"
karst=$1 bake=$2 count=$3 kind=${4:-voxels}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir worlds
if [[ $kind == ground ]]; then
  ramp_dem 900
  "$bake" dem.bil --pixel-size 10 -o old.karst --materials none --quiet
  hill="\"place_m\": [300, 0, 200], \"radius_m\": 900, \"strength_m\": 50"
  echo "{\"tool\": \"extrude\", \"shape\": \"cylinder\", $hill}" >script.json
else
  "$bake" --sample hills --no-ground --voxel 32 --levels 3 -o old.karst --materials none --quiet
  echo '{"tool": "clear", "place_m": [0, 20, 0], "radius_m": 70}' >script.json
fi
"$karst" edit old.karst --script script.json -o new.karst >/dev/null
# run SECONDS: kills it so long after the new file is there; prints how long the file was there, and 1 where
# it was killed.
run() {
  cp old.karst worlds/w.karst
  python3 - "$karst" "$1" <<'END'
import os, signal, subprocess, sys, time
child = subprocess.Popen([sys.argv[1], "edit", "worlds/w.karst", "--script", "script.json", "-o",
                          "worlds/w.karst"], stdout=subprocess.DEVNULL)
new = f"worlds/.karst-{child.pid}-0.tmp"
while child.poll() is None and not os.path.exists(new):
    pass
begin = time.perf_counter()
while child.poll() is None and time.perf_counter() < begin + float(sys.argv[2]):
    pass
child.kill()
print(time.perf_counter() - begin, 1 if child.wait() == -signal.SIGKILL else 0)
END
}
# From no time to somewhat more than writing takes.
span=100
for _ in 1 2 3; do
  read -r one _ < <(run 100)
  span=$(python3 -c "print(min($span, $one))")
done
killed=0 olds=0 news=0 torn=0
for ((n = 0; killed < count; ++n)); do
  read -r _ one < <(run "$(python3 -c "print(1.2 * $span * ($n * 7919 % 10007) / 10007)")")
  killed=$((killed + one))
  if cmp -s worlds/w.karst old.karst; then
    olds=$((olds + 1))
  elif cmp -s worlds/w.karst new.karst; then
    news=$((news + 1))
  else
    torn=$((torn + 1))
  fi
done
cp old.karst worlds/w.karst
"$karst" edit worlds/w.karst --script script.json -o worlds/w.karst >/dev/null
cmp worlds/w.karst new.karst
rest=$(find worlds -mindepth 1 ! -name w.karst | wc -l)
printf '%d killed while they saved: %d old, %d new (%d were done), %d torn, %d left over\n' \
  "$killed" "$olds" "$news" $((n - killed)) "$torn" "$rest"
((torn == 0 && rest == 0 && olds > 0))
