#!/bin/bash
# SPDX-License-Identifier: MIT
# kill_edit.sh KARST KARST-BAKE COUNT [ground]: ends karst edit while it saves in place over a world, of
# voxels or of tiles, with SIGKILL, until COUNT were killed while the new file was there: the world must be
# the old one or the new one, and what is left must be gone after the next edit.
set -euo pipefail
karst=$1 bake=$2 count=$3 kind=${4:-voxels}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir worlds
if [[ $kind == ground ]]; then
  python3 -c 'import struct
samples = (x + y + x * y % 7 for y in range(900) for x in range(900))
open("dem.bil", "wb").write(b"".join(struct.pack("<h", sample) for sample in samples))'
  printf 'ncols 900\nnrows 900\nnbits 16\npixeltype signedint\nbyteorder I\n' >dem.hdr
  "$bake" dem.bil --pixel-size 10 -o old.karst --materials none --quiet
  hill="\"place_m\": [300, 0, 200], \"radius_m\": 900, \"strength_m\": 50"
  echo "{\"tool\": \"extrude\", \"shape\": \"cylinder\", $hill}" >script.json
else
  "$bake" --sample hills --no-ground --voxel 32 --levels 3 -o old.karst --materials none --quiet
  echo '{"tool": "clear", "place_m": [0, 20, 0], "radius_m": 70}' >script.json
fi
"$karst" edit old.karst --script script.json -o new.karst >/dev/null
killed=0 olds=0 news=0 torn=0
for ((n = 0; killed < count; ++n)); do
  cp old.karst worlds/w.karst
  # Waits for the new file, and then from no time to more than writing takes.
  killed=$((killed + $(python3 - "$karst" $((n * 7919 % 10007)) <<'END'
import os, signal, subprocess, sys, time
karst, part = sys.argv[1], int(sys.argv[2]) / 10007
child = subprocess.Popen([karst, "edit", "worlds/w.karst", "--script", "script.json", "-o", "worlds/w.karst"],
                         stdout=subprocess.DEVNULL)
new = f"worlds/.karst-{child.pid}-0.tmp"
while child.poll() is None and not os.path.exists(new):
    pass
end = time.perf_counter() + part * 0.03
while time.perf_counter() < end:
    pass
child.kill()
print(1 if child.wait() == -signal.SIGKILL else 0)
END
)))
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
