"""A robot holds what it occupies and what comes next; whoever comes later waits.

A slot that nobody says anything else of takes one robot. A robot that is blocked by one that stands for good takes
another way if there is one. Robots that wait for each other in a circle never go on by themselves: as soon as the
circle is closed it is told as a ``deadlock``; then one of them takes another way, the one that set out last first, or
backs off to a free waypoint beside it; where none can, the goal of that one is aborted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import Field

from hmrsim.errors import GoalAborted
from hmrsim.events.traffic import Deadlock
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.traffic.policies import Policy, Settings
from hmrsim.traffic.policies._clearance import rooms_of_waypoints
from hmrsim.traffic.policies._reservations import Slots
from hmrsim.traffic.policies._waits_for import circle_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.navigation.route import Leg
    from hmrsim.robots.vehicle import Mobile
    from hmrsim.traffic.admission import Passage
    from hmrsim.world.model import World

_Capacity = Annotated[int, Field(strict=True, ge=1)] | None


class ReserveSettings(Settings):
    """How many robots go where nothing is said of it, beside what every policy has.

    Attributes:
        waypoint_capacity: How many may be at a waypoint; None for any number.
        lane_capacity: How many may be on a lane, whatever their direction; None for any number.
        reroutes: How often a robot takes another way on one trip before it only waits.
    """

    waypoint_capacity: _Capacity = 1
    lane_capacity: _Capacity = 1
    reroutes: Annotated[int, Field(strict=True, ge=0)] = 8


class Reserve:
    """Reservations at work in one world.

    Args:
        passage: The ways of the world.
        settings: How many robots go where.
    """

    def __init__(self, passage: Passage, settings: ReserveSettings) -> None:
        self.passage = passage
        self.settings = settings
        self._told: tuple[float, frozenset[Mobile]] | None = None
        self.slots = Slots(_capacities(passage.world, passage.graph.lanes, settings), passage.look_again)
        self.take, self.leave = self.slots.take, self.slots.leave
        self.forget, self.full = self.slots.forget, self.slots.full
        self.stand, self.inside = self.slots.stand, self.slots.inside

    def begin_anew(self) -> None:
        """Forget what has been told."""
        self._told = None

    def blockers(self, robot: Mobile, leg: Leg) -> Sequence[Mobile]:
        """Return who occupies what a robot would need for a leg."""
        slots = self.slots
        found: dict[Mobile, None] = {}
        for slot in slots.missing(robot, leg.slots):
            found.update(dict.fromkeys(slots.inside(slot)))
        if not leg.slots:
            found.update(dict.fromkeys(slots.on_spot(robot, leg.end)))
        found.pop(robot, None)
        return [*found]

    def blocked(self, robot: Mobile) -> None:
        """Look whether this closes a circle, and whether another way leads around those who stand for good."""
        circle = circle_of(self.passage, robot)
        if circle:
            self._tell(circle)
            self.untie(circle)
        elif any(other.stands for other in self.passage.blockers(robot)):
            self.go_around(robot)

    def halted(self, robot: Mobile) -> None:
        """Do nothing: nobody counts on its arrival."""

    def keeps_aside(self, _robot: Mobile) -> bool:
        """Return False: who has made room goes on when it can."""
        return False

    def untie(self, circle: Sequence[Mobile]) -> None:
        """Have one robot of a circle take another way, or make room, or give up; the one that set out last first."""
        last_first = sorted(circle, key=rank, reverse=True)
        for solve in (self._turn_off, self._back_off):
            if any(solve(robot, circle) for robot in last_first):
                return
        self.give_up(circle)

    def give_up(self, circle: Sequence[Mobile]) -> None:
        """End the goal of the robot of a circle that set out last."""
        text = f"deadlock: {' waits for '.join(robot.name for robot in (*circle, circle[0]))}; there is no other way"
        last = max((robot for robot in circle if robot.waits), key=rank)
        last.give_up(GoalAborted(FollowPath.Result.PATIENCE_EXCEEDED, text))

    def _turn_off(self, robot: Mobile, _circle: Sequence[Mobile]) -> bool:
        """Have a robot take a way that begins with a lane that it can have now, if there is one."""
        return robot.rerouted < self.settings.reroutes and robot.reroute([*self._not_now(robot)])

    def _back_off(self, robot: Mobile, circle: Sequence[Mobile]) -> bool:
        """Have a robot drive to a free waypoint beside it that nobody else of the circle will need, if any."""
        if robot.rerouted >= self.settings.reroutes or not robot.may_make_room:
            return False
        wanted = {slot for other in circle if other is not robot for leg in other.legs_ahead for slot in leg.slots}
        for way in exits(self.passage, robot):
            if way.end not in wanted and self.slots.exchange([(robot, way.leg)]):
                robot.rerouted += 1
                self.passage.push(robot, way.leg, circle[(circle.index(robot) - 1) % len(circle)])
                return True
        return False

    def go_around(self, robot: Mobile) -> bool:
        """Have a robot that waits take a way around those who are in its way, if there is one."""
        wait = self.passage.waits.get(robot)
        if wait is None or robot.rerouted >= self.settings.reroutes:
            return False
        return robot.reroute([*self._lanes_into(robot, wait.leg), *self._not_now(robot)])

    def _lanes_into(self, robot: Mobile, leg: Leg) -> Iterator[Lane]:
        """Yield the lanes that lead to what a robot waits for."""
        for slot in self.slots.missing(robot, leg.slots):
            for edge in self.passage.graph.lanes.leading_to(slot):
                if edge.leg.lane:
                    yield edge.leg.lane

    def _not_now(self, robot: Mobile) -> Iterator[Lane]:
        """Yield the lanes on which a robot can't set out from where it stands."""
        for leg, _ in exits(self.passage, robot):
            if leg.lane and next(self.slots.missing(robot, leg.slots), None) is not None:
                yield leg.lane

    def _tell(self, circle: Sequence[Mobile]) -> None:
        """Tell of a deadlock, once, whichever of its robots it is found by."""
        instant = (self.passage.now, frozenset(circle))
        if instant == self._told:
            return
        self._told = instant
        lanes = tuple(leg.lane for robot in circle if (leg := robot.next_leg) and leg.lane)
        self.passage.happened.publish(lambda: Deadlock(tuple(robot.name for robot in circle), lanes))


def rank(robot: Mobile) -> tuple[float, str]:
    """Return what orders robots: whoever has set out earlier comes first, and whoever wants to go nowhere last."""
    return (math.inf if robot.stands else robot.set_out, robot.name)


class Exit(NamedTuple):
    """A way to leave where a robot stands.

    Attributes:
        leg: To be driven.
        end: The slot of the waypoint at its end.
    """

    leg: Leg
    end: int


def exits(passage: Passage, robot: Mobile) -> list[Exit]:
    """Return the open lanes that begin where a robot stands, or what is left of the one on which it stands."""
    lanes = passage.graph.lanes
    found = []
    for slot in robot.slots:
        if slot < len(lanes.out):
            found += [Exit(edge.leg, edge.end) for edge in lanes.out[slot]]
        else:
            here = robot.pose().point
            found += [Exit(lanes.part(edge, here, edge.leg.end), edge.end) for edge in lanes.leading_to(slot)]
    return [way for way in found if way.leg.lane and passage.is_open(way.leg.lane)]


def _capacities(world: World, lanes: Lanes, settings: ReserveSettings) -> list[float]:
    """Return how many robots may be in each slot."""
    rooms = rooms_of_waypoints(world, settings.waypoint_capacity)
    of_lanes = {frozenset((lane.from_, lane.to)): lane.capacity for lane in world.lanes}
    # A lift lets in whom it can take.
    rides = {edge.leg.slots[0] for edge in lanes.edges if edge.ride}
    capacities = [rooms[name] for name in lanes.names]
    for slot, track in enumerate(lanes.tracks, start=len(lanes.names)):
        room = of_lanes.get(frozenset(track)) or settings.lane_capacity
        capacities.append(math.inf if slot in rides else room or math.inf)
    return capacities


POLICY = Policy(name="reserve", settings=ReserveSettings, rule=Reserve)
