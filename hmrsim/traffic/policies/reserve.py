"""The policy ``reserve``: a robot reserves its place and the next lane, and robots that come later wait.

A slot has room for one robot unless the world or the settings say otherwise. Robots in different slots also exclude
each other if they would touch, for example where lanes cross without a waypoint. A robot that is blocked by one that
stands for good is rerouted if there is another route.

Robots that wait for each other in a cycle are deadlocked. As soon as the cycle closes, the event ``deadlock`` is
published. Then one of the robots is rerouted, or backs off to a free neighboring waypoint; the robot that set out last
tries first. If none can, the goal of the robot that set out last is aborted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Final, NamedTuple

from pydantic import Field

from hmrsim.caches import LruCache, exact
from hmrsim.diagnostics import listed
from hmrsim.errors import GoalAborted
from hmrsim.events.traffic import Deadlock
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.protocol.goal import Cause
from hmrsim.traffic.nearness import near_slots, rooms_of_waypoints, slots_around, widest
from hmrsim.traffic.policies import Policy, Settings
from hmrsim.traffic.policies._deadlock import find_pass
from hmrsim.traffic.policies._reservations import Slots
from hmrsim.traffic.policies._ways import Ways
from hmrsim.traffic.rules import by_rank
from hmrsim.world.model import Derived

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.nearness import Near
    from hmrsim.traffic.rules import Vehicle
    from hmrsim.world.model import World

_KEPT_POINTS = 1_024
"""The number of points beside the lanes whose surroundings are cached."""

_KEPT_PASSES = 64
"""The number of waiting vehicles whose moves are kept until a vehicle moves, as causes are often read again."""

_Capacity = Annotated[int, Field(strict=True, ge=1)] | None


class ReserveSettings(Settings):
    """The settings of reservations: default capacities, and the number of reroutes.

    Attributes:
        waypoint_capacity: Maximum number of robots at a waypoint; None for no limit.
        lane_capacity: Maximum number of robots on a lane, in either direction; None for no limit.
        reroutes: Maximum number of reroutes on one trip of a robot, after which it only waits.
    """

    waypoint_capacity: _Capacity = 1
    lane_capacity: _Capacity = 1
    reroutes: Annotated[int, Field(strict=True, ge=0)] = 8


class Reserve:
    """The rules of the policy ``reserve`` in one world."""

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
        self._moves_past: LruCache[object, Sequence[tuple[Vehicle, Point]]] = LruCache(_KEPT_PASSES)
        self.held, self.inside = self.slots.held, self.slots.inside
        self.full, self.near, self.spot = self.slots.full, self.slots.holders_near, self.slots.spot

    def is_reserved(self, _slot: int) -> bool:
        """Return whether a vehicle will need a slot that it neither holds nor waits for; here never."""
        return False

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, and release all others that it holds; return False if they are taken."""
        return self.slots.take(robot, leg)

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a standing vehicle these slots, even if they are full, and release all others that it holds."""
        self.slots.stand(robot, slots)

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle."""
        self.slots.leave(robot)

    def freed(self, robots: Sequence[Vehicle]) -> None:
        """Make vehicles request slots that have just become free."""
        self.admission.look_again(robots)

    def reset(self) -> None:
        """Forget the published deadlocks, those that a door or a lift kept from being resolved, and moves past."""
        self._deadlocks.clear()
        self._unsolved.clear()
        self._moves_past.clear()

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """End the wait of a vehicle for a leg, which dissolves each deadlock it is part of."""
        self.slots.forget(robot, leg)
        if self._deadlocks:
            for circle in [circle for circle in self._deadlocks if robot in circle]:
                del self._deadlocks[circle]

    def opened(self) -> None:
        """Try again to resolve deadlocks that a door or a lift kept from being resolved."""
        unsolved, self._unsolved = self._unsolved, {}
        self.admission.look_again([*unsolved])

    def blockers(self, robot: Vehicle, leg: Leg) -> Sequence[Vehicle]:
        """Return the vehicles that hold slots which a vehicle needs for a leg."""
        return self.slots.blockers(robot, self.slots.of(leg))

    def ahead_of(self, _robot: Vehicle) -> Iterable[Vehicle]:
        """Return no vehicle: under this policy, vehicles have no order."""
        return ()

    def why_stays(self, other: Vehicle, robot: Vehicle) -> str:
        """Return why *other* does not make room for *robot*, as the end of a sentence: "it …"."""
        if other.waits or self.admission.causes.is_held_up(other):
            names = sorted(vehicle.name for vehicle in self.admission.causes.blockers(other))
            return f"waits for {listed(names)}" if names else "waits itself"
        if other.may_yield:
            return self._why_idle_stays(other, robot)
        if other.stays_until:
            return f"makes no room before {other.stays_until:g} s, so that its controller can send the next goal"
        return "makes no room meanwhile" if other.stands else "is on its way"

    def _why_idle_stays(self, _other: Vehicle, _robot: Vehicle) -> str:
        """Return why an idle vehicle that could be moved is not moved."""
        return f"makes no room under the policy {self.admission.world.policy!r}"

    def waiting_for(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles that wait for a slot which a vehicle holds."""
        return self.slots.waiting_for(robot)

    def shut_in_by(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles that occupy all ways out of where a vehicle stands; none if a way is free."""
        slots = self.slots
        missing = [slots.missing(robot, way.slots) for way in self.ways.leaving(robot)]
        if not all(missing):
            return ()
        found = dict.fromkeys(other for at in chain.from_iterable(missing) for other in slots.in_the_way(robot, at))
        return [other for other in found if other is not robot]

    def moves_past(self, robots: Sequence[Vehicle]) -> Sequence[tuple[Vehicle, Point]]:
        """Return moves of vehicles, in order, that bring the first one, which waits, to its goal or ahead.

        All other vehicles stay; the result is empty if no moves are found.
        """
        wait = self.admission.waits.get(robots[0])
        if wait is None:
            return ()
        key = self.slots.changes, self.admission.graph.closed, wait.leg, robots[0].goal, *robots
        return self._moves_past.get(key, lambda: self._find_moves_past(robots, wait.leg))

    def _find_moves_past(self, robots: Sequence[Vehicle], leg: Leg) -> Sequence[tuple[Vehicle, Point]]:
        goal = robots[0].goal
        at = None if goal is None else self.admission.graph.lanes.at.get(goal)
        # The way to its goal may be too long for the search.
        for target in (*([] if at is None else [at]), self.slots.destination(leg)):
            steps = find_pass(self.admission, self.slots, self.ways, robots, target)
            if steps:
                return [(move.robot, move.way.legs[-1].end) for step in steps for move in step]
        return ()

    def blocked(self, robot: Vehicle) -> None:
        """Resolve the deadlock if the wait closes a cycle; otherwise reroute around vehicles that stand for good."""
        blockers = self.admission.causes.blockers(robot)
        cycle = waits_for_cycle(self.admission, robot, blockers)
        if cycle:
            self._publish(cycle)
            self.resolve(cycle)
        elif any(other.stands for other in blockers):
            self.go_around(robot)

    def halted(self, robot: Vehicle) -> None:
        """Do nothing: no other vehicle depends on the arrival."""

    def stays_aside(self, _robot: Vehicle) -> bool:
        """Return False: a vehicle that has yielded continues as soon as it can."""
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
        """Make a vehicle yield to a free neighboring waypoint that no other vehicle of the cycle needs."""
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
        """Reroute a waiting vehicle around the vehicles in its way, if there is a route."""
        wait = self.admission.waits.get(robot)
        if wait is None or robot.rerouted >= self.settings.reroutes:
            return False
        return robot.reroute([*self._lanes_into(robot, wait.leg), *self._not_now(robot)])

    def _lanes_into(self, robot: Vehicle, leg: Leg) -> Iterator[Lane]:
        """Yield the lanes that lead to the slots for which a vehicle waits."""
        for slot in self.slots.missing(robot, self.slots.of(leg)):
            for edge in () if slot in self.slots.points else self.admission.graph.lanes.leading_to(slot):
                if edge.leg.lane:
                    yield edge.leg.lane

    def _not_now(self, robot: Vehicle) -> Iterator[Lane]:
        """Yield the lanes on which a vehicle can't set out now."""
        for way in self.ways.leaving(robot):
            if self.slots.missing(robot, way.slots):
                yield from (leg.lane for leg in way.legs if leg.lane)

    def _publish(self, cycle: Sequence[Vehicle]) -> None:
        """Publish a deadlock once, no matter which vehicle discovers it, until it dissolves."""
        circle = frozenset(cycle)
        if circle in self._deadlocks:
            return
        self._deadlocks[circle] = None
        lanes = tuple(leg.lane for robot in cycle if (leg := robot.next_leg) and leg.lane)
        self.admission.publisher.publish(lambda: Deadlock(tuple(robot.name for robot in cycle), lanes))


def waits_for_cycle(admission: Admission, robot: Vehicle, blockers: Sequence[Vehicle]) -> list[Vehicle]:
    """Return the vehicles of a cycle, beginning with *robot*, in which each waits for the next; empty if there is none.

    A slot with room for several vehicles becomes free when any of them leaves. So there is a cycle only if all vehicles
    for which *robot* waits, directly or through others, have to wait themselves. *blockers* are those for which it
    waits directly.
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
    """The capacities of a world's slots.

    Attributes:
        reach: The greatest sum of two vehicles' radii, in the world's unit.
        capacities: The number of vehicles that may hold each slot.
        compared: The slots with a limited capacity; in the others, the positions of vehicles do not matter.
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
"""The layouts of a world, by the default capacities of waypoints and lanes."""


def _capacities(world: World, lanes: Lanes, settings: ReserveSettings) -> list[float]:
    """Return the number of vehicles that may hold each slot."""
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
    """Return which of these slots are so near each other that vehicles in them may touch."""
    at = {name: slot for slot, name in enumerate(lanes.names)}
    ends = [*((slot, slot) for slot in at.values()), *((at[a], at[b]) for a, b in lanes.tracks)]
    return near_slots(lanes.points, {slot: ends[slot] for slot in compared}, reach)


POLICY = Policy(name="reserve", settings=ReserveSettings, rule=Reserve)
