#!/bin/sh
# Brings the parcel to the ward. With --bug, what has failed is not looked at, and the script ends with 0.
. "$(dirname "$0")/lockstep.sh"

now=0
join
if [ "$1" = --bug ]; then
  go 6
  goal pickup '{target_name: parcel}'
  go 18
  goal place '{attached_object_name: parcel}'
  code=0
else
  insist
  code=$?
fi
leave
exit "$code"
