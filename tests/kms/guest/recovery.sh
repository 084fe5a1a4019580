#!/bin/sh
# SPDX-License-Identifier: MIT
# recovery.sh CYCLES SEED: unplugs and replugs the monitor, and takes the screen away and gives it back (by
# the terminal, with another DRM master in between), at random. After each the picture is back in a second.
. /lib.sh
cycles=$1
random=$2
log=/run/recovery.log
view recovery
# QEMU takes a first size of 0 x 0 for no change.
host resize 0 320 240
sleep 1
host shot before
unplugged=0
switched=0
cycle=0
while [ $cycle -lt "$cycles" ]; do
  cycle=$((cycle + 1))
  random=$(((random * 1103515245 + 12345) % 2147483648))
  if [ $((random / 65536 % 2)) -eq 0 ]; then
    unplugged=$((unplugged + 1))
    host resize 0 0 0
    await $log "the monitor is gone" $unplugged 30 || fail "cycle $cycle: unplugging is not noticed"
    host resize 0 320 240
  else
    switched=$((switched + 1))
    chvt 2
    await $log "the terminal is switched away" $switched 30 || fail "cycle $cycle: no release of the terminal"
    # Another program is the master for a moment.
    karst view --list-outputs >/dev/null 2>&1
    chvt 1
  fi
  await $log "the picture is back" $cycle 30 || fail "cycle $cycle: no picture (random $random)"
  [ -d /proc/$view ] || fail "cycle $cycle: the program is gone"
  [ $((cycle % 20)) -ne 0 ] || host shot cycle$cycle
done
host shot after
longest=$(sed -n 's/.*the picture is back after \([0-9]*\) ms/\1/p' $log | sort -n | tail -n 1)
echo "FIGURE $cycles cycles ($unplugged unplugged, $switched switched away): 0 hangs"
echo "FIGURE the picture is back after $longest ms at most"
[ "$longest" -le 1000 ] || fail "a recovery took $longest ms"

# Another preferred mode is another picture.
host resize 0 400 300
await $log "Virtual-1 400x300" 1 100 || fail "another mode is not followed"
await $log "showing on" 2 300 || fail "no picture in the other mode"
sleep 0.2
host shot other_mode
end TERM
