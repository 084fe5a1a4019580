#!/bin/bash
# SPDX-License-Identifier: MIT
# Download and unpack Debian packages for a test guest, without installing them
# and without touching this machine's package database.
#
#   fetch_guest.sh ARCH DIR [PACKAGE ...]
#
# ARCH is amd64 or arm64. DIR/tree gets the files. Default packages: the stock
# kernel, static busybox and Mesa. Uses the apt sources of this machine.
set -euo pipefail
[ $# -ge 2 ] || { sed -n '3,10p' "$0" >&2; exit 2; }
arch=$1; mkdir -p "$2"; dir=$(cd "$2" && pwd); shift 2
[ $# -gt 0 ] || set -- "linux-image-$arch" busybox-static libgles2 libegl1 libgbm1 libgl1-mesa-dri libstdc++6
mkdir -p "$dir"/state/lists/partial "$dir"/cache/archives/partial "$dir"/tree
: > "$dir/state/status"
cat > "$dir/apt.conf" <<CONF
Dir::State "$dir/state";
Dir::State::status "$dir/state/status";
Dir::Cache "$dir/cache";
APT::Architecture "$arch";
APT::Architectures { "$arch"; };
APT::Install-Recommends "false";
APT::Sandbox::User "$(id -un)";
Debug::NoLocking "true";
CONF
export APT_CONFIG=$dir/apt.conf
apt-get -q update
# Kept even where the machine's apt hooks delete downloads after an install.
apt-get -q -y -o APT::Keep-Downloaded-Packages=true --download-only install "$@"
for deb in "$dir"/cache/archives/*.deb; do dpkg-deb -x "$deb" "$dir/tree"; done
echo "kernel:  $(ls "$dir"/tree/boot/vmlinuz-* 2>/dev/null | head -n1)"
echo "modules: $(ls -d "$dir"/tree/lib/modules/* 2>/dev/null | head -n1)"
