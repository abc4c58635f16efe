# What the shell scripts have in common: a participant of lockstep, which speaks by the command line alone.
# $HMRSIM_CONNECT says where the simulator is.

epoch=0

call() {
  hmrsim service call "/_world/$1" "$2"
}

join() {
  epoch=$(call time/join '{name: porter}' | awk '$1 == "epoch:" {print $2}')
}

leave() {
  call time/leave '{participant: porter}' > /dev/null
}

# advance UNTIL COMMANDS: sets $answer, $epoch and $now; an answer that is lost is asked for again, by the same epoch
advance() {
  for try in 1 2 3; do
    answer=$(call time/advance "{participant: porter, epoch: $epoch, until: $1, wake: [result], commands: [$2]}") && break
  done
  epoch=$(printf '%s\n' "$answer" | awk '$1 == "epoch:" {print $2}')
  now=$(printf '%s\n' "$answer" | awk '$1 == "now:" {print $2}')
}

# rest SECONDS: lets simulated time pass
rest() {
  advance "$(awk -v now="$now" -v more="$1" 'BEGIN {print now + more}')" ''
}

# goal ACTION GOAL: succeeds if the goal does
goal() {
  advance null "{robot: wall_e, action: $1, goal: $2}"
  printf '%s\n' "$answer" | grep -q '^- accepted: true' || return 1
  while ! printf '%s\n' "$answer" | grep -q '^  kind: result'; do
    advance null ''
  done
  printf '%s\n' "$answer" | grep -q '^  status: 4'
}

go() {
  goal navigate_to_pose "{pose: {pose: {position: {x: $1}}}}"
}

# Where the parcel is by now
parcel() {
  call get_entity_state '{entity: parcel}' | awk '$1 == "x:" {print $2; exit}'
}

# attempt X: tries the errand with the parcel at X; a claw that has it already refuses to pick it up.
attempt() {
  go "$1" || return 1
  goal pickup '{target_name: parcel}'
  go 18 && goal place '{attached_object_name: parcel}'
}

insist() {
  attempt 6 && return 0
  for number in 2 3 4 5 6 7 8 9 10; do
    rest 20
    attempt "$(parcel)" && return 0
  done
  return 1
}
