#!/bin/sh
# SPDX-License-Identifier: MIT
# The world is edited by keys and the tablet on the bare screen; the program is killed, and goes on.
. /lib.sh
know_inputs
world=/run/w.karst
cp /small.karst $world
# What has been asked for is seen when frames come to rest.
press() {
  frames=$(statistic frames)
  host "$@"
  settle $((frames + 1))
}
view edit --edit --navigate fly --camera 60,120,160,0,-35
settle 1
host shot still
press key spc
host shot dug
echo "FIGURE journal after a key: $(grep -c clear $world.journal) edits"
press key z
host shot undone
press key y
host shot redone
kill -9 $view
wait $super
cmp -s $world /small.karst || fail "the world was changed without being saved"
view again --edit --navigate fly --camera 60,120,160,0,-35
await /run/again.log "1 edit that was not saved: done again" 1 10 || fail "again: not told"
settle 1
host shot again
press key f5
cmp -s $world /small.karst && fail "F5 does not save"
[ "$(count $world.journal tool)" = 0 ] || fail "the journal is not begun anew"
end TERM
[ ! -e $world.journal ] || fail "the journal is left"
# The pointer of a tablet, on the old world.
cp /small.karst $world
view click --edit --navigate fly --camera 60,120,160,0,-35
settle 1
press key bracket_right
host shot bigger
press key bracket_left
press click 9000 18000
host shot clicked
press key z
host shot aimed
end TERM
[ ! -e $world.journal ] || fail "all was taken back, and the journal is left"
