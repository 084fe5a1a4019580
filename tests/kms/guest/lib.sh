#!/bin/sh
# SPDX-License-Identifier: MIT
# What the guest's scripts share. Logs lie in /run/NAME.log, statistics in /run/NAME.json.

fail() { echo "FAILED: $*"; tail -n 20 /run/*.log; exit 1; }

# count FILE TEXT: lines with the text; 0 where there is no file yet.
count() { cat "$1" 2>/dev/null | grep -c "$2" || true; }

# await FILE TEXT N TENTHS: until N lines have it.
await() {
  i=0
  while [ "$(count "$1" "$2")" -lt "$3" ]; do
    i=$((i + 1))
    [ $i -le "$4" ] || return 1
    sleep 0.1
  done
}

# view NAME [OPTION...]: starts karst view of $world (canyon) in the background and waits for its first
# picture. Sets $super, the supervisor's process, and $view, the program's. Without --navigate it shows all of
# the world, as karst render does.
view() {
  name=$1
  shift
  case " $* " in
    *" --navigate "*) ;;
    *) set -- "$@" --navigate none ;;
  esac
  karst view ${world:-/canyon.karst} --seat direct --precision high --stats /run/$name.json "$@" \
    >/run/$name.log 2>&1 &
  super=$!
  await /run/$name.log "showing on" 1 1200 || fail "$name: no picture"
  view=$(cat /proc/$super/task/$super/children)
  view=${view% }
  # The line is written when the kernel has the frame.
  sleep 0.2
}

# end SIGNAL: ends karst view and waits for the supervisor.
end() {
  kill -"$1" $view
  wait $super
  echo "ended by $1: exit $?"
}

# The number behind "NAME": in a statistics file, written anew. A frame may take seconds before it answers.
statistic() {
  rm -f /run/$name.json
  kill -HUP $view
  i=0
  while [ ! -s /run/$name.json ] && [ $i -lt 300 ]; do
    i=$((i + 1))
    sleep 0.1
  done
  sed -n "s/^ *\"$1\": \([0-9.]*\).*/\1/p" /run/$name.json | head -n 1
}

# settle LEAST: until no more frames are drawn, and so many at least. Pictures are drawn coarsely first, and
# again until they are complete; an emulated machine takes seconds for each.
settle() {
  before=-1
  frames=0
  while [ "$frames" != "$before" ] || [ "$frames" -lt "$1" ]; do
    before=$frames
    sleep ${pause:-6}
    frames=$(statistic frames)
  done
}

# Hundredths of a second of processor time that the program has used.
ticks() { cut -d' ' -f14,15 /proc/$view/stat | { read -r user system; echo $((user + system)); }; }

# console_is_text TEXT: whether the text console can be used; TEXT is written there.
console_is_text() {
  console_mode /dev/tty1 || return 1
  printf 'karst test %s\n' "$1" >/dev/tty1
}

# What udevd would say about keyboard and tablet, which does not run here.
know_inputs() {
  mkdir -p /run/udev/data
  for event in /sys/class/input/event*; do
    number=$(cat $event/dev)
    kind=KEY=1\\nE:ID_INPUT_KEYBOARD
    grep -qi tablet $event/device/name && kind=MOUSE
    printf 'I:1\nE:ID_INPUT=1\nE:ID_INPUT_%b=1\nG:seat\n' $kind >/run/udev/data/c$number
  done
}
