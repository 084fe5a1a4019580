#!/bin/sh
# SPDX-License-Identifier: MIT
# Pictures by both kinds of calls, the console in between, and an idle minute's sixth.
. /lib.sh
host shot console
karst view --list-outputs || fail "no outputs listed"

view atomic --kms atomic
host shot atomic
frames=$(statistic frames)
before=$(ticks)
sleep 10
after=$(ticks)
drawn=$(($(statistic frames) - frames))
echo "FIGURE idle for 10 s: $drawn frames drawn, $((after - before)) hundredths of a second of CPU"
[ $drawn -eq 0 ] || fail "an idle kiosk draws"
[ $((after - before)) -lt 10 ] || fail "an idle kiosk uses 1 % of the CPU or more"
end TERM
console_is_text "after SIGTERM" || fail "the console is not in text mode after SIGTERM"
host shot after_term

view legacy --kms legacy
host shot legacy
end KILL
console_is_text "after SIGKILL" || fail "the console is not in text mode after SIGKILL"
host shot after_kill

view window --rotate 180 --detail high
host shot rotated
end TERM
echo done
