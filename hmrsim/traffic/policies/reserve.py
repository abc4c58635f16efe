"""A robot reserves its place and the next lane; a robot that comes later waits.

A slot has room for one robot unless the world or the settings say otherwise. Robots that would touch although they are
in different slots, as where lanes cross without a waypoint, exclude each other, too. A robot that is blocked by one
that stands for good is rerouted if there is another route. Robots that wait for each other in a cycle never go on by
themselves: as soon as the cycle closes, a ``deadlock`` is published; then one of them is rerouted, the one that set out
last first, or backs off to a free waypoint beside it; where none can, the goal of the one that set out last is aborted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Final, NamedTuple

from pydantic import Field

from hmrsim.diagnostics import listed
from hmrsim.errors import GoalAborted
from hmrsim.events.traffic import Deadlock
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.navigation.cache import LruCache, exact
from hmrsim.protocol.goal import Cause
from hmrsim.traffic.nearness import near_slots, rooms_of_waypoints, slots_around, widest
from hmrsim.traffic.policies import Policy, Settings
from hmrsim.traffic.policies._reservations import Slots
from hmrsim.traffic.policies._ways import Ways
from hmrsim.traffic.rules import by_rank
from hmrsim.world.derived import Derived

if TYPE_CHECKING:
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.nearness import Near
    from hmrsim.traffic.rules import Vehicle
    from hmrsim.world.model import World

_KEPT_POINTS = 1_024
"""Points beside the lanes for which it is kept what is around them."""

_Capacity = Annotated[int, Field(strict=True, ge=1)] | None


class ReserveSettings(Settings):
    """Default capacities, beside what every policy has.

    Attributes:
        waypoint_capacity: How many robots may be at a waypoint; None for any number.
        lane_capacity: How many robots may be on a lane, in either direction; None for any number.
        reroutes: How often a robot is rerouted on one trip before it only waits.
    """

    waypoint_capacity: _Capacity = 1
    lane_capacity: _Capacity = 1
    reroutes: Annotated[int, Field(strict=True, ge=0)] = 8


class Reserve:
    """Reservations at work in one world."""

    def __init__(self, admission: Admission, settings: ReserveSettings) -> None:
        self.admission = admission
        self.settings = settings
        self.grace = 0.0
        self._deadlocks: dict[frozenset[Vehicle], None] = {}
        self._unsolved: dict[Vehicle, None] = {}
        lanes, layouts = admission.graph.lanes, _LAYOUTS(admission.world)
        defaults = settings.waypoint_capacity, settings.lane_capacity
        if defaults not in layouts:
            layouts[defaults] = _layout(admission.world, lanes, settings)
        reach, capacities, compared = layouts[defaults]
        around: LruCache[bytes, Mapping[int, float]] = lanes.derived(
            (slots_around, compared, reach), lambda: LruCache(_KEPT_POINTS)
        )
        self.slots = Slots(
            capacities,
            len(lanes.names),
            lanes.derived((near_slots, compared, reach), lambda: _near_among(lanes, compared, reach)),
            around=lambda point: around.get(exact(*point), lambda: slots_around(lanes, point, capacities, reach)),
            reach=reach,
            freed=self.freed,
            reserved=self.is_reserved,
        )
        self.ways = Ways(admission, self.slots)
        self.held, self.inside = self.slots.held, self.slots.inside
        self.full, self.near, self.spot = self.slots.full, self.slots.holders_near, self.slots.spot

    def is_reserved(self, _slot: int) -> bool:
        """Return whether a slot is going to be needed for a vehicle that neither holds it nor waits for it."""
        return False

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, and release all others that it holds; return whether it may have them."""
        return self.slots.take(robot, leg)

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a vehicle that stands these slots, also full ones, and release all others that it holds."""
        self.slots.stand(robot, slots)

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle."""
        self.slots.leave(robot)

    def freed(self, robots: Sequence[Vehicle]) -> None:
        """Make vehicles request again the slots that have just become free."""
        self.admission.look_again(robots)

    def reset(self) -> None:
        """Forget the deadlocks that were published, and those that wait for a door."""
        self._deadlocks.clear()
        self._unsolved.clear()

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """End the wait of a vehicle for a leg, which dissolves each deadlock it is part of."""
        self.slots.forget(robot, leg)
        if self._deadlocks:
            for circle in [circle for circle in self._deadlocks if robot in circle]:
                del self._deadlocks[circle]

    def opened(self) -> None:
        """Have deadlocks looked at again that a door or a lift was in the way of resolving."""
        unsolved, self._unsolved = self._unsolved, {}
        self.admission.look_again([*unsolved])

    def blockers(self, robot: Vehicle, leg: Leg) -> Sequence[Vehicle]:
        """Return the vehicles that hold what one would need for a leg."""
        return self.slots.blockers(robot, self.slots.of(leg))

    def ahead_of(self, _robot: Vehicle) -> Iterable[Vehicle]:
        """Return no vehicle: each has the right of way where it comes first."""
        return ()

    def why_stays(self, other: Vehicle, robot: Vehicle) -> str:
        """Return why a vehicle that is in another one's way makes no room, as the end of a sentence: "it …"."""
        if other.waits or self.admission.causes.is_held_up(other):
            names = sorted(each.name for each in self.admission.causes.blockers(other))
            return f"waits for {listed(names)}" if names else "waits itself"
        if other.may_yield:
            return self._why_idle_stays(other, robot)
        if other.stays_until:
            return f"makes no room before {other.stays_until:g} s, so that its controller can send the next goal"
        return "makes no room meanwhile" if other.stands else "is on its way"

    def _why_idle_stays(self, _other: Vehicle, _robot: Vehicle) -> str:
        """Return why a vehicle that could be moved is not."""
        return f"makes no room under the policy {self.admission.world.policy!r}"

    def blocked(self, robot: Vehicle) -> None:
        """Resolve the deadlock if this closes a cycle; else reroute around vehicles that stand for good."""
        blockers = self.admission.causes.blockers(robot)
        cycle = waits_for_cycle(self.admission, robot, blockers)
        if cycle:
            self._publish(cycle)
            self.resolve(cycle)
        elif any(other.stands for other in blockers):
            self.go_around(robot)

    def halted(self, robot: Vehicle) -> None:
        """Do nothing: no other vehicle counts on its arrival."""

    def stays_aside(self, _robot: Vehicle) -> bool:
        """Return False: a vehicle that has yielded goes on when it can."""
        return False

    def resolve(self, cycle: Sequence[Vehicle]) -> None:
        """Make one vehicle of a cycle reroute, back off or give up, trying the last to set out first."""
        last_first = sorted(cycle, key=by_rank, reverse=True)
        for solve in (self._turn_off, self._back_off):
            if any(solve(robot, cycle) for robot in last_first):
                return
        if not any(robot in self._unsolved for robot in cycle):
            self.give_up(cycle)

    def give_up(self, cycle: Sequence[Vehicle]) -> None:
        """Abort the goal of the vehicle of a cycle that set out last."""
        last = max((robot for robot in cycle if robot.waits), key=by_rank)
        circle = " waits for ".join(robot.name for robot in (*cycle, cycle[0]))
        remedy = self.admission.causes.help_in_circle
        text = f"deadlock: {circle}; there is no other way; what would help: {remedy}"
        self.admission.abort(last, GoalAborted(FollowPath.Result.PATIENCE_EXCEEDED, text, Cause.BLOCKED))

    def _turn_off(self, robot: Vehicle, _cycle: Sequence[Vehicle]) -> bool:
        """Reroute a vehicle to a lane that it can have now, if there is one."""
        return robot.rerouted < self.settings.reroutes and robot.reroute([*self._not_now(robot)])

    def _back_off(self, robot: Vehicle, cycle: Sequence[Vehicle]) -> bool:
        """Make a vehicle yield to a free waypoint beside it that no other one of the cycle will need, if any."""
        if robot.rerouted >= self.settings.reroutes or not robot.may_yield:
            return False
        ahead = [leg for other in cycle if other is not robot for leg in other.legs_ahead]
        wanted = {slot for leg in ahead for slot in self.slots.of(leg)}
        wanted |= {at for slot in wanted for at in self.slots.near.get(slot, ())}
        for way in self.ways.leaving(robot):
            if way.end in wanted or self.slots.missing(robot, way.slots):
                continue
            if not self.admission.lets(robot, way.legs):
                self._unsolved[robot] = None
            elif self.slots.exchange([(robot, way.slots)]):
                by = cycle[(cycle.index(robot) - 1) % len(cycle)]
                self.admission.push(robot, way.legs, by, rerouted=True)
                return True
        return False

    def go_around(self, robot: Vehicle) -> bool:
        """Reroute a vehicle that waits around those in its way, if there is a route."""
        wait = self.admission.waits.get(robot)
        if wait is None or robot.rerouted >= self.settings.reroutes:
            return False
        return robot.reroute([*self._lanes_into(robot, wait.leg), *self._not_now(robot)])

    def _lanes_into(self, robot: Vehicle, leg: Leg) -> Iterator[Lane]:
        """Yield the lanes that lead to what a vehicle waits for."""
        for slot in self.slots.missing(robot, self.slots.of(leg)):
            for edge in () if slot in self.slots.points else self.admission.graph.lanes.leading_to(slot):
                if edge.leg.lane:
                    yield edge.leg.lane

    def _not_now(self, robot: Vehicle) -> Iterator[Lane]:
        """Yield the lanes on which a vehicle can't set out from where it stands."""
        for way in self.ways.leaving(robot):
            if self.slots.missing(robot, way.slots):
                yield from (leg.lane for leg in way.legs if leg.lane)

    def _publish(self, cycle: Sequence[Vehicle]) -> None:
        """Publish a deadlock once, whichever of its vehicles it is found by, until it is dissolved."""
        circle = frozenset(cycle)
        if circle in self._deadlocks:
            return
        self._deadlocks[circle] = None
        lanes = tuple(leg.lane for robot in cycle if (leg := robot.next_leg) and leg.lane)
        self.admission.publisher.publish(lambda: Deadlock(tuple(robot.name for robot in cycle), lanes))


def waits_for_cycle(admission: Admission, robot: Vehicle, blockers: Sequence[Vehicle]) -> list[Vehicle]:
    """Return the vehicles of a cycle in which each waits for the next, *robot* first; none if it is in no such cycle.

    A slot with room for several vehicles becomes free when any of them leaves. So there is a cycle only where all
    vehicles for which *robot* waits, directly or not, have to wait themselves. *blockers* are those for which it waits
    directly.
    """
    waits_for: dict[Vehicle, Vehicle] = {}
    todo = [robot]
    for waiting in todo:
        if waiting is not robot:
            blockers = admission.causes.blockers(waiting)
        if not blockers or not all(admission.causes.is_held_up(other) for other in blockers):
            return []
        for other in blockers:
            if other not in waits_for:
                waits_for[other] = waiting
                todo.append(other)
    if robot not in waits_for:
        return []
    cycle = [waits_for[robot]]
    while cycle[-1] is not robot:
        cycle.append(waits_for[cycle[-1]])
    return cycle[::-1]


class _Layout(NamedTuple):
    """The room that vehicles have.

    Attributes:
        reach: The greatest sum of two vehicles' radii, in the world's unit.
        capacities: How many vehicles may hold each slot.
        compared: The slots with room for so many; of those with room for any number, no vehicle has a place.
    """

    reach: float
    capacities: Sequence[float]
    compared: tuple[int, ...]


def _layout(world: World, lanes: Lanes, settings: ReserveSettings) -> _Layout:
    capacities = _capacities(world, lanes, settings)
    compared = tuple(slot for slot, room in enumerate(capacities) if room < math.inf)
    return _Layout(widest(world), capacities, compared)


def _no_layouts(_world: World) -> dict[tuple[int | None, int | None], _Layout]:
    return {}


_LAYOUTS: Final = Derived(_no_layouts, "waypoints", "lanes", "lifts", "docks", "places", "robots", "robot_types")
"""The layouts of a world, by the capacities of waypoints and lanes that state none."""


def _capacities(world: World, lanes: Lanes, settings: ReserveSettings) -> list[float]:
    """Return how many vehicles may hold each slot."""
    rooms = rooms_of_waypoints(world, settings.waypoint_capacity)
    of_lanes = {frozenset((lane.from_, lane.to)): lane.capacity for lane in world.lanes}
    # A lift counts its riders itself.
    rides = {lanes.edges[number].leg.slots[0] for number in lanes.ways.rides}
    capacities = [rooms[name] for name in lanes.names]
    for slot, track in enumerate(lanes.tracks, start=len(lanes.names)):
        room = of_lanes.get(frozenset(track)) or settings.lane_capacity
        capacities.append(math.inf if slot in rides else room or math.inf)
    return capacities


def _near_among(lanes: Lanes, compared: Sequence[int], reach: float) -> Near:
    """Return which of these slots are too near each other."""
    at = {name: slot for slot, name in enumerate(lanes.names)}
    ends = [*((slot, slot) for slot in at.values()), *((at[a], at[b]) for a, b in lanes.tracks)]
    return near_slots(lanes.points, {slot: ends[slot] for slot in compared}, reach)


POLICY = Policy(name="reserve", settings=ReserveSettings, rule=Reserve)
