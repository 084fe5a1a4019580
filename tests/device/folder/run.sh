#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs karst's GL tests, golden pictures and benchmarks on this machine: ./run --help tells more.
folder=$(cd "$(dirname "$0")" && pwd) || exit 1
program=$folder/bin/karst-device
for_machine=$(cat "$folder/machine")
if [ "$(uname -m)" != "$for_machine" ]; then
  echo "run: these programs are for $for_machine, and this machine is $(uname -m)" >&2
  exit 1
fi
if ! trouble=$("$program" --help 2>&1 >/dev/null); then
  echo "run: the programs do not start: $trouble" >&2
  echo "run: they need $(cat "$folder/needs"), and libEGL.so.1 and libGLESv2.so.2, which a driver brings" >&2
  exit 1
fi
exec "$program" "$@"
