#!/bin/bash
# SPDX-License-Identifier: MIT
# sysroot.sh DIR: fetches the Debian packages for 64-bit ARM that karst is built with and run on, and unpacks
# them below DIR/tree. Nothing is installed. Uses the apt sources of this machine.
set -euo pipefail
[[ $# == 1 ]] || {
  sed -n '3,4p' "$0" >&2
  exit 2
}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
packages=(
  libc6-dev libstdc++-12-dev libglm-dev libpng-dev libzstd-dev zlib1g-dev libgtest-dev nlohmann-json3-dev
  libegl-dev libgles-dev libgbm-dev libdrm-dev libinput-dev libseat-dev libudev-dev
  libegl1 libegl-mesa0 libgles2 libgl1-mesa-dri
)
"$here/../../tests/kms/fetch_guest.sh" arm64 "$1" "${packages[@]}" >"$1.log" 2>&1 || {
  tail -n 3 "$1.log" >&2
  exit 1
}
# Links to the machine's own paths would lead out of the tree.
tree=$(cd "$1/tree" && pwd)
find "$tree" -type l -lname '/*' -print0 | while IFS= read -r -d '' link; do
  ln -sfnr "$tree$(readlink "$link")" "$link"
done
echo "$tree"
