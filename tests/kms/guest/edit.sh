#!/bin/sh
# SPDX-License-Identifier: MIT
# The world is edited by keys and the tablet on the bare screen; the program is killed, and goes on.
. /lib.sh
know_inputs
pause=2
world=/run/w.karst
cp /small.karst $world
edit="--edit --navigate fly --camera 260,330,240,45,-38"
# What has been asked for is seen when frames come to rest.
press() {
  frames=$(statistic frames)
  host "$@"
  settle $((frames + 1))
}
view edit $edit
settle 1
host shot still
press key spc
host shot dug
press key z
host shot undone
press click 20480 17749
host shot clicked
echo "FIGURE journal: $(grep -c tool $world.journal) steps"
kill -9 $view
wait $super
cmp -s $world /small.karst || fail "the world was changed without being saved"
view again $edit
await /run/again.log "1 edit that was not saved: done again" 1 10 || fail "again: not told"
settle 1
host shot again
press key f5
cmp -s $world /small.karst && fail "F5 does not save"
end TERM
[ ! -e $world.journal ] || fail "all is saved, and the journal is left"
