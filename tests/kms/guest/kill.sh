#!/bin/sh
# SPDX-License-Identifier: MIT
# kill.sh TIMES: kill -9 while a picture is shown; the console is usable each time.
. /lib.sh
# Fills Mesa's cache of compiled shaders, which takes seconds a start otherwise.
world=/small.karst
view warm --navigate none
sleep 3
end TERM
times=0
while [ $times -lt "$1" ]; do
  times=$((times + 1))
  view kill$times --navigate none
  kill -9 $view
  wait $super
  code=$?
  [ $code -eq 137 ] || fail "kill $times: the supervisor ends with $code"
  console_is_text "kill $times" || fail "kill $times: the console is not in text mode"
  rm -f /run/kill$times.*
  [ $((times % 25)) -ne 0 ] || host shot kill$times
done
host shot last
echo "FIGURE $times x kill -9: the console was usable each time"
