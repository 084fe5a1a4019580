#!/bin/sh
# SPDX-License-Identifier: MIT
# kill.sh TIMES: kill -9 while a picture is shown; the console is usable each time.
. /lib.sh
i=0
while [ $i -lt "$1" ]; do
  i=$((i + 1))
  view kill$i --level 1
  kill -9 $view
  wait $super
  code=$?
  [ $code -eq 137 ] || fail "kill $i: the supervisor ends with $code"
  console_is_text "kill $i" || fail "kill $i: the console is not in text mode"
  rm -f /run/kill$i.*
  [ $((i % 25)) -ne 0 ] || host shot kill$i
done
host shot last
echo "FIGURE $i x kill -9: the console was usable each time"
