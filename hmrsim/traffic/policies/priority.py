"""Reservations as in `hmrsim.traffic.policies.reserve`, but other robots yield to the one that set out first.

That is priority inheritance with backtracking (PIBT; Okumura and others, 2019) where robots take their own time: a
robot that stands in the way of one that set out earlier drives to a free waypoint beside it, or has the robot there
yield in turn; a cycle of three or more moves on all at once. Robots that are idle, or wait themselves, yield; robots
that work where they stand do not.

Where that is not enough, as in dead ends, all robots of the deadlock are moved one by one, as a search over their
places finds. So the one that set out first goes on, whatever the goals of the others; when it has arrived, the next one
is the first. Where waypoints are connected in both directions and there is room for two to pass, no robot waits for
ever.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
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
    """The vehicles that yield, and by which ways."""


_PAUSE = 5.0
"""Simulated seconds between two searches for the same vehicle: one that fails would fail again soon after.

It also waits so long before longer moves are looked for, and before any while others move.
"""

_PAUSES = 4
"""Pauses that fit into the patience of a vehicle, at least."""

_FIRST_STATES = 1_000
_MORE_STATES = 4
"""Combinations of places at which the first search for a vehicle looks, and how many times as many the next one does.

Most vehicles can be helped by few moves, or go on by themselves before that is worth more.
"""


class PrioritySettings(ReserveSettings):
    """The settings of reservations, and of making room.

    Attributes:
        grace: Simulated seconds for which a robot stays where its goal has ended, if its client sends goals in real
            time and so needs time to send the next one.
        most_states: How many combinations of places a search for a way out of a deadlock looks at before it gives up.
    """

    grace: Annotated[float, Field(strict=True, ge=0, le=1e9)] = 5.0
    most_states: Annotated[int, Field(strict=True, ge=0, le=10_000_000)] = 4_000


_PAIR = 2

_ORDER: Final = itemgetter(0, 1, 2, 3)

_SHORT = 20.0
"""Simulated seconds that the moves of a resolution may take, one after the other, without a thought."""


@dataclass
class _Searched:
    """A search for a way out for a vehicle.

    Attributes:
        wait: The wait that ended.
        at: When, in simulated seconds.
        states: How many combinations of places were looked at, at most.
        again: The leg to request again when the next search is due, if any.
    """

    wait: Wait
    at: float
    states: int
    again: Wait | None = None


class Priority(Reserve):
    """Priorities at work in one world."""

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
        """End the wait of a vehicle for a leg; others may enter the slots that it claimed."""
        if robot is self.claim.holder:
            self.claim.end()
        super().forget(robot, leg)

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """As `Reserve.take`, but a vehicle that is part of a resolution moves only when that says so.

        One that is not keeps out of what a resolution needs for a vehicle that set out earlier: it would be in its way,
        and the next resolution could have it go back there, for ever.
        """
        if self.claim.holder is None and not self.resolutions.by_robot:
            return self.slots.take(robot, leg)
        held, wanted = self.slots.held(robot), self.slots.of(leg)
        if len(held) > 1 and all(slot in held for slot in wanted):
            # The second leg of a move needs nothing that the vehicle does not have.
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
        """As `Reserve.stand`; vehicles that could not be helped before ask again, as soon as a search is due."""
        self.slots.stand(robot, slots)
        if self.resolutions.by_robot:
            self.resolutions.stands(robot)
        if self._stuck:
            stuck, self._stuck = self._stuck, {}
            self.admission.look_again([other for other in stuck if not self._asks_later(other)])

    def leave(self, robot: Vehicle) -> None:
        """As `Reserve.leave`, and forget its costs."""
        self.claim.forget(robot)
        self.costs.forget(robot)
        self.slots.leave(robot)

    def blockers(self, robot: Vehicle, leg: Leg) -> Sequence[Vehicle]:
        """Return the vehicles that hold what one would need, or the one for which it is moved or has to wait."""
        found = super().blockers(robot, leg)
        resolution = None if found else self.resolutions.by_robot.get(robot) or self.resolutions.against_leg(robot, leg)
        if resolution and resolution.first is not robot:
            return [resolution.first]
        if not found and self.claim.holder and self.claim.excludes(robot, self.slots.of(leg), robot.rank):
            return [self.claim.holder]
        return found

    def ahead_of(self, robot: Vehicle) -> Iterable[Vehicle]:
        """Return the vehicles that are moved for one, and those on their way that set out earlier.

        Others are moved for these first.
        """
        resolution = self.resolutions.by_robot.get(robot)
        moved = [other for other in resolution.robots if other is not robot] if resolution else []
        return moved + [other for other in self.slots.vehicles() if not other.stands and other.rank < robot.rank]

    def why_stays(self, other: Vehicle, robot: Vehicle) -> str:
        """As `Reserve.why_stays`; vehicles that wait make room, too, if they set out later."""
        if other in self.resolutions.by_robot:
            first = self.resolutions.by_robot[other].first
            return f"makes room for {first.name}" if first is not other else "is about to go on"
        if other.may_yield and other.rank > robot.rank:
            return self._why_idle_stays(other, robot)
        return super().why_stays(other, robot)

    def _why_idle_stays(self, other: Vehicle, robot: Vehicle) -> str:
        names, slots = self.admission.graph.lanes.names, self.slots
        ways = self.ways.leaving(other)
        if not ways:
            return "has nowhere to go: no open lane leads away"
        missing = [slots.missing(other, way.slots) for way in ways]
        if not all(missing):
            return f"can't make room: no moves were found that let {robot.name} pass"
        ends = list(dict.fromkeys(names[way.end] for way in ways if way.end < len(names)))
        holders = dict.fromkeys(who.name for at in chain.from_iterable(missing) for who in slots.in_the_way(other, at))
        holders.pop(other.name, None)
        if [*holders] == [robot.name]:
            return f"can't get out past {robot.name}"
        return (
            f"has nowhere to go: {' and '.join(ends)} {'is' if len(ends) == 1 else 'are'} taken by {listed([*holders])}"
        )

    def opened(self) -> None:
        """Go on with moves that waited for a door or a lift; vehicles that could not be helped before ask again."""
        super().opened()
        self.resolutions.opened()
        stuck, self._stuck = {**self._stuck, **self._opening}, {}
        self._opening.clear()
        self.admission.look_again([*stuck])

    def reset(self) -> None:
        """Forget which vehicles could not be helped, and when."""
        super().reset()
        self.claim.end()
        self._stuck.clear()
        self.resolutions.reset()
        self._opening.clear()
        self._searched.clear()
        self.costs.reset()

    def halted(self, robot: Vehicle) -> None:
        """Give up the resolution of which a vehicle is a part."""
        self.resolutions.halted(robot)

    def stays_aside(self, robot: Vehicle) -> bool:
        """Return whether a vehicle has yielded as a part of a resolution; the next step begins, or all ask again."""
        return self.resolutions.stays_aside(robot)

    def blocked(self, robot: Vehicle) -> None:
        """Make blocking vehicles yield if they set out later, unless this is part of a resolution."""
        if self.resolutions.see_to(robot):
            return
        blockers = self.admission.causes.blockers(robot)
        cycle = waits_for_cycle(self.admission, robot, blockers)
        if cycle:
            self._publish(cycle)
            # A vehicle in the queue of a dock waits for no lane, so no other can make room for it.
            robot = min((each for each in cycle if each in self.admission.waits), key=by_rank)
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
        # Else one of them is on its way, or is to go on first.
        if self.admission.now - wait.since > AFTER:
            self._claim_for(robot, wait, seen)
        if self.admission.waits.get(robot) is wait and robot not in self.resolutions.by_robot:
            self.slots.watch(robot, seen)

    def _claim_for(self, robot: Vehicle, wait: Wait, seen: Iterable[int]) -> None:
        """Make the waiting vehicle that set out first claim the slots it needs, until it goes on."""
        if self.admission.waits.get(robot) is not wait or robot in self.resolutions.by_robot:
            return
        if robot is self.claim.holder or not any(other.rank < robot.rank for other in self.admission.waits):
            self.claim.extend(robot, [*self.slots.of(wait.leg), *seen])

    def _move_others(self, robot: Vehicle) -> None:
        """Search for a way out for a vehicle that can't go on, and have others move accordingly."""
        self._stuck[robot] = None
        self._resolve(robot)

    def _may_go_on_soon(self, wait: Wait, seen: dict[int, None]) -> bool:
        """Return whether a vehicle moves in one of the slots *seen* to be in the way: it asks again when that stands.

        A search moves only vehicles that stand, so that it would be in vain in most cases. It is put off for some
        seconds only, as others may pass by all the time.
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
        """Return whether it is too early for another search for a vehicle; then it asks again when it is not."""
        wait, before = self.admission.waits.get(robot), self._searched.get(robot)
        if wait is None or before is None or self.admission.now >= before.at + self._pause:
            return False
        if before.again is not wait:
            before.again = wait
            self.admission.look_again_at(robot, before.at + self._pause)
        return True

    def _is_due(self, robot: Vehicle) -> bool:
        """Return whether there is going to be another search for a vehicle by itself."""
        wait, before = self.admission.waits.get(robot), self._searched.get(robot)
        if wait is None or before is None or before.again is not wait:
            return False
        return self.admission.now < before.at + self._pause

    def _push(self, robot: Vehicle, seen: dict[int, None]) -> bool:
        """Make the vehicles that block another yield, and resume it; return whether they can.

        The slots are added to those *seen* on which that depends.
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
        """Make a whole chain yield to a vehicle at once; the vehicle may move, too.

        Returns:
            Whether there is room; None if there will be, once doors and lifts on the way have opened.
        """
        # Each is asked, so that each begins to open.
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
        """Return which vehicles drive where so that there is room in a slot; None if they can't make any.

        Args:
            slot: The slot.
            first: The vehicle to which all yield.
            pusher: The vehicle that needs the slot; no other can go where it is.
            pushed: The vehicles that have been asked already.
            seen: The slots on which the answer depends.
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
                there = slots.holders[end]
                if len(there) == 1 and not near and (there[0] in pushed or not self._gives_way(there[0], first)):
                    # Most often one vehicle is there that stays.
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
        """Return the ways by which a vehicle can yield a slot, and whether someone is at their ends.

        The free ones come first, the best for its own goal.
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
        """Move the vehicles around one that can't go on so that it can, if that is possible."""
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
                # No vehicle moves, and none ever will, but for one that is about to ask, or asks later.
                if any(other.rank < robot.rank for other in self.admission.asking):
                    del self._searched[robot]
                    self.admission.look_again([robot])
                elif any(self._is_due(other) for other in self.admission.waits if other is not robot):
                    self._asks_later(robot)
                else:
                    self.give_up(cycle)
            return
        if not patient and _duration(steps) > _SHORT:
            # By then, others may have moved to where they block no vehicle.
            self._asks_later(robot)
            return
        self.resolutions.begin(robot, steps)

    def _goes_nowhere(self, robot: Vehicle) -> bool:
        """Return whether a vehicle that stands or waits will do so until another one moves."""
        if robot in self._opening or self.admission.waits_for_barrier(robot):
            return False
        return self.admission.causes.is_held_up(robot) or not robot.busy

    def _movable(self, other: Vehicle, robot: Vehicle, *, soon: bool) -> bool:
        """Return whether a vehicle may be moved for another now, or *soon*: when it stands, or has done its work."""
        if other in self.resolutions.by_robot or other.rank <= robot.rank:
            return False
        if soon:
            # One that lingers makes room by itself, nearer to where it is than a search would have it go.
            return other.will_yield and not other.stays_until
        return other.may_yield

    def _publish(self, cycle: Sequence[Vehicle]) -> None:
        """Publish a deadlock once, and not each time that it is looked at."""
        if not any(robot in self.resolutions.by_robot for robot in cycle):
            super()._publish(cycle)


def _duration(steps: Sequence[Step]) -> float:
    """Return how long steps take if they are made one after the other, in seconds."""
    return sum(leg.seconds(move.robot.speed) for step in steps for move in step for leg in move.way.legs)


POLICY = Policy(name="priority", settings=PrioritySettings, rule=Priority)
