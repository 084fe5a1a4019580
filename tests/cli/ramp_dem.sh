#!/bin/bash
# SPDX-License-Identifier: MIT
# ramp_dem SIDE: writes dem.bil and dem.hdr, SIDE x SIDE samples of a rough slope, into this folder. To be
# sourced.
ramp_dem() {
  python3 -c 'import struct, sys
side = range(int(sys.argv[1]))
samples = (x + y + x * y % 7 for y in side for x in side)
open("dem.bil", "wb").write(b"".join(struct.pack("<h", sample) for sample in samples))' "$1"
  printf 'ncols %d\nnrows %d\nnbits 16\npixeltype signedint\nbyteorder I\n' "$1" "$1" >dem.hdr
}
