#!/bin/sh
# Brings the parcel to the ward. With --bug, each step is tried until it works, at once and without a limit.
. "$(dirname "$0")/lockstep.sh"

now=0
join
if [ "$1" = --bug ]; then
  until go 6; do :; done
  until goal pickup '{target_name: parcel}'; do :; done
  until go 18; do :; done
  until goal place '{attached_object_name: parcel}'; do :; done
  code=0
else
  insist
  code=$?
fi
leave
exit "$code"
