"""The policy ``priority``: reservations as under ``reserve``, but other robots yield to the one that set out first.

This is priority inheritance with backtracking (PIBT; Okumura and others, 2019) for robots that do not move in lockstep.
A robot in the way of one that set out earlier drives to a free neighboring waypoint, or makes the robot there yield in
turn. A cycle of three or more robots moves on all at once. Robots that are idle or wait yield; robots that work where
they stand do not.

If that is not enough, as in dead ends, a search over the places of all robots in the deadlock finds moves for them. So
the robot that set out first drives on, whatever the goals of the others; once it has arrived, the next one is first. If
waypoints are connected in both directions and there is room for two to pass, no robot waits forever.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Final

from pydantic import Field

from hmrsim.diagnostics import listed
from hmrsim.traffic.policies import Policy
from hmrsim.traffic.policies._deadlock import DeadlockResolver
from hmrsim.traffic.policies._resolution import AFTER, Claim, Resolutions
from hmrsim.traffic.policies._ways import Costs
from hmrsim.traffic.policies.reserve import Reserve, ReserveSettings, waits_for_cycle
from hmrsim.traffic.rules import by_rank

if TYPE_CHECKING:
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.policies._resolution import Step
    from hmrsim.traffic.policies._ways import Way
    from hmrsim.traffic.rules import Vehicle, Wait

    _Chain = list[tuple[Vehicle, Way]]
    """The vehicles that yield, each with its way."""


_PAUSE = 5.0
"""Simulated seconds between two searches for the same vehicle: a search that fails would fail again soon after.

A vehicle also waits that long before a search for longer moves, and before any search while other vehicles move.
"""

_PAUSES = 4
"""The minimum number of pauses within the patience of a vehicle."""

_FIRST_STATES = 1_000
"""The number of combinations of places that the first search for a vehicle visits: most vehicles need few moves."""

_MORE_STATES = 4
"""The factor by which each further search visits more combinations."""


class PrioritySettings(ReserveSettings):
    """The settings of reservations, and of making room.

    Attributes:
        grace: Simulated seconds for which a robot is not moved after a goal, if its client needs time to send the next
            goal because time follows the wall clock.
        most_states: Maximum number of combinations of places that a search for a way out of a deadlock visits.
    """

    grace: Annotated[float, Field(strict=True, ge=0, le=1e9)] = 5.0
    most_states: Annotated[int, Field(strict=True, ge=0, le=10_000_000)] = 4_000


_PAIR = 2

_ORDER: Final = itemgetter(0, 1, 2, 3)

_SHORT = 20.0
"""Simulated seconds that the moves of a resolution may take in sequence without being postponed."""


@dataclass
class _Searched:
    """The last search for a way out for a vehicle.

    Attributes:
        wait: The wait that it should end.
        at: The time of the search, in simulated seconds.
        states: The maximum number of combinations of places that it visited.
        again: The wait that will request again when the next search is due; None if that is not scheduled.
    """

    wait: Wait
    at: float
    states: int
    again: Wait | None = None


class Priority(Reserve):
    """The rules of the policy ``priority`` in one world."""

    def __init__(self, admission: Admission, settings: PrioritySettings) -> None:
        super().__init__(admission, settings)
        self.grace = settings.grace
        self.costs = Costs(admission)
        self._max_states = settings.most_states
        self._pause = min(_PAUSE, math.inf if settings.patience is None else settings.patience / _PAUSES)
        self.claim = Claim(self.slots, self.freed)
        self.resolutions = Resolutions(admission, self.slots, self.ways, self.claim)
        self._resolver = DeadlockResolver(admission, self.slots, self.ways, self.resolutions, self._movable)
        self._stuck: dict[Vehicle, None] = {}
        self._opening: dict[Vehicle, None] = {}
        self._searched: dict[Vehicle, _Searched] = {}

    def is_reserved(self, slot: int) -> bool:
        """Return whether a resolution needs a slot."""
        return self.resolutions.need(slot)

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """End the wait of a vehicle for a leg, and its claim to slots."""
        if robot is self.claim.holder:
            self.claim.end()
        super().forget(robot, leg)

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, as `Reserve.take`, unless a claim or a resolution keeps it out.

        A vehicle that takes part in a resolution moves only when the resolution says so. Other vehicles keep out of the
        slots that a resolution needs for a vehicle which set out earlier. Otherwise they would block it, and the next
        resolution might move them back there, forever.
        """
        if self.claim.holder is None and not self.resolutions.by_robot:
            return self.slots.take(robot, leg)
        held, wanted = self.slots.held(robot), self.slots.of(leg)
        if len(held) > 1 and all(slot in held for slot in wanted):
            # The vehicle already holds the slots of the second leg of a move.
            return self.slots.take(robot, leg)
        if self.claim.keeps_out(robot, wanted):
            return False
        if robot in self.resolutions.by_robot:
            return False
        resolution = self.resolutions.against_leg(robot, leg)
        if resolution is not None:
            resolution.held_back[robot] = None
            return False
        return self.slots.take(robot, leg)

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a standing vehicle these slots, as `Reserve.stand`, and try again to help stuck vehicles."""
        self.slots.stand(robot, slots)
        if self.resolutions.by_robot:
            self.resolutions.stands(robot)
        if self._stuck:
            stuck, self._stuck = self._stuck, {}
            self.admission.look_again([other for other in stuck if not self._asks_later(other)])

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle, as `Reserve.leave`, and forget its costs."""
        self.claim.forget(robot)
        self.costs.forget(robot)
        self.slots.leave(robot)

    def blockers(self, robot: Vehicle, leg: Leg) -> Sequence[Vehicle]:
        """Return the vehicles that hold slots which a vehicle needs, or else the one for which it has to wait."""
        if holders := super().blockers(robot, leg):
            return holders
        resolution = self.resolutions.by_robot.get(robot) or self.resolutions.against_leg(robot, leg)
        if resolution and resolution.first is not robot:
            return [resolution.first]
        if self.claim.holder and self.claim.excludes(robot, self.slots.of(leg), robot.rank):
            return [self.claim.holder]
        return ()

    def ahead_of(self, robot: Vehicle) -> Iterable[Vehicle]:
        """Return the vehicles that are moved for a vehicle, and those with a destination that set out earlier.

        Room is made for these vehicles first.
        """
        resolution = self.resolutions.by_robot.get(robot)
        moved = [other for other in resolution.robots if other is not robot] if resolution else []
        return moved + [other for other in self.slots.vehicles() if not other.stands and other.rank < robot.rank]

    def why_stays(self, other: Vehicle, robot: Vehicle) -> str:
        """Return why *other* does not make room for *robot*; a waiting vehicle also makes room if it set out later."""
        if other in self.resolutions.by_robot:
            first = self.resolutions.by_robot[other].first
            return f"makes room for {first.name}" if first is not other else "is about to go on"
        if other.may_yield and other.rank > robot.rank:
            return self._why_idle_stays(other, robot)
        return super().why_stays(other, robot)

    def _why_idle_stays(self, other: Vehicle, robot: Vehicle) -> str:
        names = self.admission.graph.lanes.names
        ways = self.ways.leaving(other)
        if not ways:
            return "has nowhere to go: no open lane leads away"
        holders = [each.name for each in self.shut_in_by(other)]
        if not holders:
            return f"can't make room: no moves were found that let {robot.name} pass"
        if holders == [robot.name]:
            return f"can't get out past {robot.name}"
        ends = list(dict.fromkeys(names[way.end] for way in ways if way.end < len(names)))
        return f"has nowhere to go: {' and '.join(ends)} {'is' if len(ends) == 1 else 'are'} taken by {listed(holders)}"

    def opened(self) -> None:
        """Continue moves that waited for a door or a lift, and make stuck vehicles request again."""
        super().opened()
        self.resolutions.opened()
        stuck, self._stuck = {**self._stuck, **self._opening}, {}
        self._opening.clear()
        self.admission.look_again([*stuck])

    def reset(self) -> None:
        """Forget which vehicles are stuck, and the searches for them."""
        super().reset()
        self.claim.end()
        self._stuck.clear()
        self.resolutions.reset()
        self._opening.clear()
        self._searched.clear()
        self.costs.reset()

    def halted(self, robot: Vehicle) -> None:
        """Give up the resolution of a vehicle, if it has one."""
        self.resolutions.halted(robot)

    def stays_aside(self, robot: Vehicle) -> bool:
        """Continue the resolution of a vehicle that has yielded; return False if it has none."""
        return self.resolutions.stays_aside(robot)

    def blocked(self, robot: Vehicle) -> None:
        """Make vehicles yield that block a waiting one and set out later, unless a resolution takes care of that."""
        if self.resolutions.see_to(robot):
            return
        blockers = self.admission.causes.blockers(robot)
        cycle = waits_for_cycle(self.admission, robot, blockers)
        if cycle:
            self._publish(cycle)
            # A vehicle in the queue of a dock waits for no lane, so no other can make room for it.
            robot = min((vehicle for vehicle in cycle if vehicle in self.admission.waits), key=by_rank)
            if self.resolutions.see_to(robot):
                return
            blockers = self.admission.causes.blockers(robot)
        wait = self.admission.waits[robot]
        seen = dict.fromkeys(self.slots.missing(robot, self.slots.of(wait.leg)))
        if all(other.stands or other.waits for other in blockers):
            helping = next(
                (self.resolutions.by_robot[other] for other in blockers if other in self.resolutions.by_robot), None
            )
            if helping is not None:
                helping.held_back[robot] = None
            elif not (
                any(other.waits and other.rank < robot.rank for other in blockers)
                or self._push(robot, seen)
                or self._may_go_on_soon(wait, seen)
            ):
                self._move_others(robot)
        # Otherwise one of the blockers is driving or comes first, and will leave by itself.
        if self.admission.now - wait.since > AFTER:
            self._claim_for(robot, wait, seen)
        if self.admission.waits.get(robot) is wait and robot not in self.resolutions.by_robot:
            self.slots.watch(robot, seen)

    def _claim_for(self, robot: Vehicle, wait: Wait, seen: Iterable[int]) -> None:
        """Claim the slots that a waiting vehicle needs, if it set out before all others that wait."""
        if self.admission.waits.get(robot) is not wait or robot in self.resolutions.by_robot:
            return
        if robot is self.claim.holder or not any(other.rank < robot.rank for other in self.admission.waits):
            self.claim.extend(robot, [*self.slots.of(wait.leg), *seen])

    def _move_others(self, robot: Vehicle) -> None:
        """Search for moves of other vehicles that let a stuck vehicle drive on, and begin them."""
        self._stuck[robot] = None
        self._resolve(robot)

    def _may_go_on_soon(self, wait: Wait, seen: dict[int, None]) -> bool:
        """Return whether a vehicle moves in one of the slots *seen*, so that the search can wait until it has stopped.

        A search moves only standing vehicles, so it would usually fail now. It is postponed only for some seconds,
        since other vehicles may pass all the time.
        """
        due = wait.since + self._pause
        if self.admission.now >= due or not any(
            not (other.stands or other.waits) for slot in seen for other in self.slots.holders[slot]
        ):
            return False
        if not wait.asks:
            wait.asks = True
            self.admission.look_again_at(wait.robot, due)
        return True

    def _asks_later(self, robot: Vehicle) -> bool:
        """Return whether it is too early for another search for a vehicle; if so, it requests again when it is time."""
        wait, before = self.admission.waits.get(robot), self._searched.get(robot)
        if wait is None or before is None or self.admission.now >= before.at + self._pause:
            return False
        if before.again is not wait:
            before.again = wait
            self.admission.look_again_at(robot, before.at + self._pause)
        return True

    def _is_due(self, robot: Vehicle) -> bool:
        """Return whether a further search for a vehicle is scheduled."""
        wait, before = self.admission.waits.get(robot), self._searched.get(robot)
        if wait is None or before is None or before.again is not wait:
            return False
        return self.admission.now < before.at + self._pause

    def _push(self, robot: Vehicle, seen: dict[int, None]) -> bool:
        """Make the vehicles that block another yield, and resume it; return whether that is possible.

        The slots on which the result depends are added to *seen*.
        """
        wait = self.admission.waits.get(robot)
        if wait is None:
            return False
        slots = self.slots.of(wait.leg)
        slot = next(iter(self.slots.missing(robot, slots)), None)
        # A vehicle that stands on the lane, or beside the way, has to leave before another one enters.
        goes = slot == slots[-1] and self.slots.full(slot)
        chain = None if slot is None else self._chain(slot, robot, robot, {robot: None}, seen, goes=goes)
        if chain is None:
            return False
        moves = self._yield(chain, robot, [(robot, slots)] if goes else [])
        if not moves:
            seen.update(dict.fromkeys(at for _, way in chain for at in way.slots))
        elif goes:
            self.admission.release(robot)
        return moves is not False

    def _yield(self, chain: _Chain, robot: Vehicle, own: Sequence[tuple[Vehicle, Sequence[int]]] = ()) -> bool | None:
        """Make all vehicles of a chain yield to a vehicle at once.

        Returns:
            Whether there is room; None if there will be room once doors and lifts have opened.
        """
        # No short circuit: every door and lift on the ways has to begin to open.
        let = [self.admission.lets(other, way.legs) for other, way in chain]
        if not all(let):
            self._opening[robot] = None
            return None
        if not self.slots.exchange([*own, *((other, way.slots) for other, way in chain)]):
            return False
        for other, way in chain:
            self.admission.push(other, way.legs, robot)
        return True

    def _chain(
        self,
        slot: int,
        first: Vehicle,
        pusher: Vehicle,
        pushed: dict[Vehicle, None],
        seen: dict[int, None],
        *,
        goes: bool,
    ) -> _Chain | None:
        """Return the vehicles that have to drive, and their ways, so that a slot has room; None if there are none.

        Args:
            slot: The slot.
            first: The vehicle to which all others yield.
            pusher: The vehicle that needs the slot; no other vehicle can take its place.
            pushed: The vehicles that were considered so far; further ones are added.
            seen: The slots on which the result depends are added here.
            goes: Whether the first vehicle leaves its own place at the same time.
        """
        seen[slot] = None
        slots, near = self.slots, self.slots.near
        others: Sequence[Vehicle] = slots.holders[slot]
        if len(others) > 1 or near:
            others = sorted({*others, *slots.beside(pusher, slot)}, key=by_rank, reverse=True)
        for other in others:
            if other in pushed or not self._gives_way(other, first):
                continue
            pushed[other] = None
            for way, occupied in self._refuges(other, first, pusher, slot, seen):
                end = way.end
                if not occupied or (goes and first in slots.in_the_way(other, end)):
                    return [(other, way)]
                holders = slots.holders[end]
                if len(holders) == 1 and not near and (holders[0] in pushed or not self._gives_way(holders[0], first)):
                    # Usually the end has one vehicle that stays, which needs no recursion.
                    seen[end] = None
                    continue
                further = self._chain(end, first, other, pushed, seen, goes=goes)
                if further is not None:
                    return [(other, way), *further]
        return None

    def _gives_way(self, other: Vehicle, robot: Vehicle) -> bool:
        return other.rank > robot.rank and other.may_yield and other not in self.resolutions.by_robot

    def _refuges(
        self, robot: Vehicle, first: Vehicle, pusher: Vehicle, slot: int, seen: dict[int, None]
    ) -> list[tuple[Way, bool]]:
        """Return the ways by which a vehicle can leave a slot, each with whether its end is occupied.

        Ways to free places come first; among these, the best one for the vehicle's own goal.
        """
        slots, near, free = self.slots, self.slots.near, self.slots.free
        wait, taken = self.admission.waits.get(robot), slots.held(pusher)
        costs, takes, speed = self.costs.of(robot)
        found = []
        for way in self.ways.leaving(robot):
            legs, needed, end, number = way
            if end in taken or end == slot or (near and slots.touch(robot, (end,), pusher, slot)):
                continue
            # Most ways are one lane, and that is free.
            if near or free[needed[0]] < 1 or len(needed) > _PAIR:
                missing = slots.missing(robot, needed[:-1])
                if missing:
                    seen[missing[0]] = None
                    continue
            resolution = self.resolutions.against(robot, needed, first)
            if resolution is not None:
                resolution.held_back[first] = None
                continue
            occupied = free[end] < 1 or (end in near and any(slots.beside(robot, end)))
            if costs is None:
                aside = wait is None or end != slots.of(wait.leg)[-1]
                found.append((occupied, aside, way.length, end, way))
            else:
                seconds = takes[number] if number >= 0 else sum([leg.seconds(speed) for leg in legs])
                found.append((occupied, False, seconds + costs[end], end, way))
        found.sort(key=_ORDER)
        return [(way, occupied) for occupied, *_, way in found]

    def _resolve(self, robot: Vehicle) -> None:
        """Search for moves that let a vehicle drive on, and begin them; give up if none can ever be found."""
        wait = self.admission.waits.get(robot)
        if wait is None or self._asks_later(robot):
            return
        before = self._searched.get(robot)
        states = before.states * _MORE_STATES if before and before.wait is wait else _FIRST_STATES
        states = min(states, self._max_states)
        self._searched[robot] = _Searched(wait, self.admission.now, states)
        patient = self.admission.now >= wait.since + self._pause or self.slots.at_rest(self._goes_nowhere)
        steps, sure = self._resolver.find_steps(robot, self.slots.destination(wait.leg), states, patient=patient)
        if steps is None:
            around = any(other.stands for other in self.admission.causes.blockers(robot)) and self.go_around(robot)
            if not around and not sure and (states < self._max_states or not patient):
                self._asks_later(robot)
                return
            cycle = [] if around else waits_for_cycle(self.admission, robot, self.admission.causes.blockers(robot))
            if cycle and not self.resolutions.by_robot and self.slots.at_rest(self._goes_nowhere):
                # No vehicle will ever move again, except for one that is about to request, or requests later.
                if any(other.rank < robot.rank for other in self.admission.asking):
                    del self._searched[robot]
                    self.admission.look_again([robot])
                elif any(self._is_due(other) for other in self.admission.waits if other is not robot):
                    self._asks_later(robot)
                else:
                    self.give_up(cycle)
            return
        if not patient and _duration(steps) > _SHORT:
            # Until the next search, other vehicles may have moved out of the way.
            self._asks_later(robot)
            return
        self.resolutions.begin(robot, steps)

    def _goes_nowhere(self, robot: Vehicle) -> bool:
        """Return whether a vehicle that stands or waits will not move before another one does."""
        if robot in self._opening or self.admission.waits_for_barrier(robot):
            return False
        return self.admission.causes.is_held_up(robot) or not robot.busy

    def _movable(self, other: Vehicle, robot: Vehicle, *, soon: bool) -> bool:
        """Return whether a vehicle may be moved for another now or, if *soon*, once it stands or has ended its work."""
        if other in self.resolutions.by_robot or other.rank <= robot.rank:
            return False
        if soon:
            # A lingering vehicle will make room by itself, over a shorter distance than a search would move it.
            return other.will_yield and not other.stays_until
        return other.may_yield

    def _publish(self, cycle: Sequence[Vehicle]) -> None:
        """Publish a deadlock, unless it is being resolved already."""
        if not any(robot in self.resolutions.by_robot for robot in cycle):
            super()._publish(cycle)


def _duration(steps: Sequence[Step]) -> float:
    """Return the seconds that steps take if they are made one after the other."""
    return sum(leg.seconds(move.robot.speed) for step in steps for move in step for leg in move.way.legs)


POLICY = Policy(name="priority", settings=PrioritySettings, rule=Priority)
