#!/bin/sh
# SPDX-License-Identifier: MIT
# Keys move the camera; a card that appears late; libseat without root; a lost screen while a key is held.
. /lib.sh
know_inputs
view input --navigate orbit
host shot still
frames=$(statistic frames)
host key a
host key home
sleep 1
settle $((frames + 1))
frames=$(statistic frames)
host key left 2000
settle $((frames + 1))
host shot turned
end TERM
# poses from another program
name=poses
mkfifo /run/poses
karst view /canyon.karst --seat direct --precision high --navigate none \
  --poses - --stats /run/poses.json </run/poses \
  >/run/poses.log 2>&1 &
super=$!
exec 4>/run/poses
await /run/poses.log "showing on" 1 1200 || fail "poses: no picture"
view=$(cat /proc/$super/task/$super/children)
view=${view% }
echo "nonsense" >&4
echo "60 70 60 85 5" >&4
await /run/poses.log "a line is X Y Z YAW PITCH" 1 50 || fail "poses: nonsense is not reported"
settle 2
host shot posed
exec 4>&-
end TERM

# seatd, and a user who is nobody
seatd -u kiosk -l silent >/run/seatd.log 2>&1 &
await_socket() { i=0; while [ ! -S /run/seatd.sock ] && [ $i -lt 50 ]; do i=$((i + 1)); sleep 0.1; done; }
await_socket
chmod 666 /run/seatd.sock
mkdir -p /run/kiosk
chmod 777 /run/kiosk
command='HOME=/run/kiosk exec karst view /canyon.karst --seat libseat --precision high --navigate none'
su kiosk -c "$command" >/run/libseat.log 2>&1 &
super=$!
await /run/libseat.log "showing on" 1 1200 || fail "libseat: no picture"
sleep 0.2
host shot libseat
echo "FIGURE libseat: shown by uid $(stat -c %u /proc/$super)"
kill $super
wait $super
