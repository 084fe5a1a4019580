#!/bin/bash
# SPDX-License-Identifier: MIT
# systemd.sh KILLS: run by karst-test.service in a Debian whose systemd has started karst-kiosk.service at
# boot.
unit=karst-kiosk
stats=/run/karst/view.json
world=/srv/karst/canyon.karst
exec 3<>/dev/vport*p1
echo "BOOT $(cut -d' ' -f1 /proc/uptime)" >&3

journal() { journalctl -u $unit -o cat --no-pager "$@"; }
property() { systemctl show $unit -p "$1" --value; }
finish() {
  echo "EXIT $1" >&3
  read -r -t 2 _ <&3
  systemctl poweroff -ff
  exit
}
fail() {
  echo "FAILED: $*"
  systemctl status --no-pager -l $unit
  journalctl -b --no-pager | tail -n 90
  finish 1
}
host() {
  local reply
  echo "$*" >&3
  read -r reply <&3
  [[ $reply == ok ]] || fail "host $*: $reply"
}
# await SECONDS COMMAND...: until the command is true.
await() {
  local end=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < end)) || return 1
    sleep 0.3
  done
}
pictures() { journal | grep -c "showing on"; }
shown() { (($(pictures) >= $1)); }
# The program under the supervisor.
child() {
  local main
  main=$(property MainPID)
  cat "/proc/$main/task/$main/children" 2>/dev/null
}
has_child() { [[ -n $(child) ]]; }
milliseconds() { echo $(($(date +%s%N) / 1000000)); }
shows() { grep -q '"frames"' $stats 2>/dev/null; }
frames() { sed -n 's/^ *"frames": \([0-9]*\).*/\1/p' $stats | head -n 1; }

# 1. Started at boot, without root, within the unit's limits.
await 240 shown 1 || fail "no picture"
echo "FIGURE a picture $(cut -d' ' -f1 /proc/uptime) s after the kernel's start"
viewer=$(child)
viewer=${viewer% }
[[ $(stat -c %U "/proc/$viewer") == karst ]] || fail "runs as $(stat -c %U "/proc/$viewer")"
systemctl -q is-active getty@tty1 && fail "the login prompt runs beside it"
grep -q "/$unit.service$" "/proc/$viewer/cgroup" || fail "limits are another's: $(cat "/proc/$viewer/cgroup")"

# 2. Statistics by reload.
systemctl reload $unit || fail "reload"
await 60 shows || fail "no statistics in $stats"
(($(frames) > 0)) || fail "no frames"
host shot unit
echo "FIGURE $(frames) frames when first asked"

# 3. What it may do.
systemd-analyze --no-pager security $unit --threshold=20 >/run/exposure || fail "$(cat /run/exposure)"
echo "FIGURE $(grep Overall /run/exposure)"
grep -E '^(NoNewPrivs|Seccomp|CapEff|CapBnd):' "/proc/$viewer/status" | tr -s '\t\n' ' ' >/run/status
[[ $(cat /run/status) == "CapEff: 0000000000000000 CapBnd: 0000000000000000 NoNewPrivs: 1 Seccomp: 2 " ]] ||
  fail "sandbox: $(cat /run/status)"
inside() {
  nsenter -t "$viewer" -m setpriv --reuid karst --regid karst --groups karst,video,render,input "$@"
}
inside find / \( -path /proc -o -path /sys -o -path /dev \) -prune -o \
  \( -type d -o -type f \) -writable -print 2>/dev/null | sort >/run/writable
echo "FIGURE folders and files it may write: $(grep -v '^/var/cache/karst/' /run/writable | tr '\n' ' ')"
grep -vE '^(/run/karst|/var/cache/karst|(/var)?/t[m]p)(/|$)' /run/writable && fail "may write more"
inside touch /run/karst/new || fail "may not write to /run/karst"
inside ls /hom[e] 2>/dev/null | grep . && fail "sees home folders"

# 4. Killed, the supervisor and the program in turn.
for ((kill = 1; kill <= $1; ++kill)); do
  victim=$(property MainPID)
  ((kill % 2 == 0)) || victim=$(child)
  kill -9 $victim
  restarted() { (($(property NRestarts) == kill)) && [[ $(property ActiveState) == active ]] && has_child; }
  await 60 restarted || fail "kill $kill: $(property NRestarts) restarts"
done
before=$(pictures)
kill -9 $(child)
await 180 shown $((before + 1)) || fail "no picture after $1 kills"
echo "FIGURE started again after $(property NRestarts) x kill -9"

# 5. Stopped: at once, and the console is one again.
from=$(milliseconds)
systemctl stop $unit
took=$(($(milliseconds) - from))
echo "FIGURE systemctl stop: $took ms, $(property Result)"
[[ $(property Result) == success ]] || fail "stop: $(property Result)"
((took < 3000)) || fail "systemctl stop took $took ms"
console_mode /dev/tty1 || fail "the console is not in text mode"
systemctl start getty@tty1
await 60 systemctl -q is-active getty@tty1 || fail "no login prompt"
await 60 grep -q login: /dev/vcs1 || fail "no login prompt on the console: $(cat /dev/vcs1)"
for key in r o o t ret; do host key $key; done
await 60 grep -q '# ' /dev/vcs1 || fail "cannot log in on the console: $(cat /dev/vcs1)"
host shot console

# 6. A world that is not there: one line, and a picture when it comes.
mv $world /srv/karst/away
before=$(pictures)
since=$(date '+%F %T')
sleep 1.1
systemctl start $unit || fail "start without a world"
named() { journal --since "$since" | grep -q "$world: cannot read"; }
await 30 named || fail "nothing is said about the missing world"
sleep 10
journal --since "$since" >/run/said
(($(grep -c 'cannot read' /run/said) == 1)) || fail "said more than once: $(cat /run/said)"
(($(property NRestarts) == 0)) || fail "is started again and again without a world"
echo "FIGURE without a world: $(wc -l </run/said) lines in ten seconds; $(grep 'cannot read' /run/said)"
mv /srv/karst/away $world
await 180 shown $((before + 1)) || fail "no picture when the world came"

# 7. Where nobody keeps the seat (logind is not asked outside of a session), devices are opened directly.
sed -i 's/ --seat direct//' /etc/systemd/system/$unit.service
systemctl daemon-reload
before=$(pictures)
systemctl restart $unit
await 180 shown $((before + 1)) || fail "no picture without --seat"

# 8. Wrong options: said, and not tried again.
systemctl stop $unit
echo 'KARST_OPTIONS="--nonsense"' >>/etc/karst/kiosk.conf
systemctl start $unit
failed() { [[ $(property ActiveState) == failed ]]; }
await 60 failed || fail "wrong options: $(property ActiveState)"
journal | grep -q nonsense || fail "wrong options are not said"
finish 0
