"""The policy ``planned`` for dense fleets: a robot turns off to a free lane, or those that set out later make room.

This is priority inheritance with backtracking (PIBT; Okumura and others, 2019, and 2021 for robots that do not move in
lockstep), over the same reservations as in `hmrsim.traffic.policies.reserve`. The distance to each robot's goal is
known from every waypoint. A robot whose next lane is taken turns off to another lane that leads nearer to its goal. If
all of these are taken, the robots there make room if they set out later, each by the lane that suits its own goal best.
A cycle of three or more robots moves on all at once.

A robot for which no room can be made requests again when a robot in the way has left or stopped. If no robot moves and
that is not enough, as in dead ends, the robots are moved as under ``priority``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Final

from pydantic import Field

from hmrsim.errors import NoRoute
from hmrsim.traffic.policies import Policy
from hmrsim.traffic.policies._resolution import AFTER
from hmrsim.traffic.policies._streets import against
from hmrsim.traffic.policies._ways import Way
from hmrsim.traffic.policies.priority import Priority, PrioritySettings
from hmrsim.traffic.policies.reserve import waits_for_cycle
from hmrsim.traffic.rules import by_rank

if TYPE_CHECKING:
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.rules import Vehicle

_MAX_PUSHED = 24
"""The maximum number of vehicles that make room for one at once; more would take time, and move distant vehicles."""

_ORDER: Final = itemgetter(0, 1, 2)

_Chain = list[tuple["Vehicle", Way]]
"""The vehicles that make room, each with its way."""


class PlannedSettings(PrioritySettings):
    """The settings of priorities, and of streets.

    Attributes:
        one_way: The additional cost of a lane against the direction of its street, as a share of its travel time; 0
            for streets without a direction.
    """

    one_way: Annotated[float, Field(ge=0, le=10)] = 1.0


@dataclass(slots=True)
class _Search:
    """A search for vehicles that can make room for one.

    Attributes:
        first: The vehicle that needs room.
        order: The rank of that vehicle.
        goes: Whether that vehicle leaves its own place at the same time.
        pushed: The vehicles that were considered so far.
        seen: The slots of vehicles that can't make room now.
        moving: Whether one of those will move by itself: it moves, works, or comes before the first vehicle.
        most: The maximum number of vehicles to consider.
        cut: Whether the search has stopped because of *most*.
    """

    first: Vehicle
    order: tuple[float, str]
    goes: bool
    pushed: dict[Vehicle, None]
    seen: dict[int, None] = field(default_factory=dict)
    moving: bool = False
    most: float = _MAX_PUSHED
    cut: bool = False


class Planned(Priority):
    """The rules of the policy ``planned`` in one world."""

    def __init__(self, admission: Admission, settings: PlannedSettings) -> None:
        super().__init__(admission, settings)
        if settings.one_way:
            lanes = admission.graph.lanes
            ways = lanes.derived(against, lambda: against(lanes.ways))
            admission.graph.avoid(ways, 1.0 + settings.one_way)
        self._turned_off: dict[Vehicle, None] = {}

    def freed(self, robots: Sequence[Vehicle]) -> None:
        """Make vehicles request again, in the order in which they set out."""
        super().freed(sorted(robots, key=by_rank) if len(robots) > 1 else robots)

    def reset(self) -> None:
        """Reset the policy to the start of a run."""
        super().reset()
        self._turned_off.clear()

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, as `Priority.take`; a vehicle that gets them may turn off again later."""
        if not super().take(robot, leg):
            return False
        if self._turned_off:
            self._turned_off.pop(robot, None)
        return True

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle, as `Priority.leave`, and forget that it has turned off."""
        self._turned_off.pop(robot, None)
        super().leave(robot)

    def blocked(self, robot: Vehicle) -> None:
        """Make a waiting vehicle turn off, or make others give it room, unless a resolution takes care of that."""
        wait = self.admission.waits.get(robot)
        if wait is None or self.resolutions.see_to(robot):
            return
        leg, slots = wait.leg, self.slots.of(wait.leg)
        missing = self.slots.missing(robot, slots)
        seen = dict.fromkeys(missing)
        if self._take_free_lane(robot, leg, seen):
            return
        long = self.admission.now - wait.since > AFTER
        if not self._goes_on(robot, slots, missing, seen, math.inf if long else _MAX_PUSHED) and long:
            self._claim_for(robot, wait, seen)
        if self.admission.waits.get(robot) is wait and robot not in self.resolutions.by_robot:
            self.slots.watch(robot, seen)

    def _goes_on(
        self, robot: Vehicle, slots: tuple[int, ...], missing: Sequence[int], seen: dict[int, None], most: float
    ) -> bool:
        """Make others give a vehicle room, or resolve its deadlock; return whether the vehicle drives on.

        Args:
            robot: The vehicle.
            slots: The slots that it needs.
            missing: Those of the slots that it can't have now.
            seen: The slots on which the result depends are added here.
            most: The maximum number of vehicles that make room.
        """
        if self._is_behind(robot, missing):
            return False
        search = self._make_room(robot, slots, missing, most)
        if search is not None and search.cut and not search.moving:
            search = self._make_room(robot, slots, missing, math.inf)
        if search is None:
            return True
        if not search.moving:
            self._untie(robot)
        seen.update(search.seen)
        return False

    def _is_behind(self, robot: Vehicle, missing: Sequence[int]) -> bool:
        """Return whether a single vehicle that comes first is in the way, as in half of all waits."""
        inside = self.slots.holders[missing[0]] if missing and not self.slots.near else ()
        return len(inside) == 1 and inside[0].rank < robot.rank

    def _take_free_lane(self, robot: Vehicle, leg: Leg, seen: dict[int, None]) -> bool:
        """Make a vehicle take another free lane that leads nearer to its goal, if there is one.

        The slots that it can't have now are added to *seen*.
        """
        if leg.lane is None or robot in self._turned_off:
            return False
        held = self.slots.held(robot)
        costs, takes, speed = self.costs.of(robot)
        if costs is None or len(held) != 1 or held[0] >= len(costs):
            return False
        node = held[0]
        here = costs[node]
        most, options = here + leg.seconds(speed), []
        for way in self.ways.from_waypoint(node):
            legs, slots, end, number = way
            left = costs[end]
            if left >= here or takes[number] + left > most or (end == leg.slots[-1] and legs[0] == leg):
                continue
            missing = self.slots.missing(robot, slots)
            if missing:
                seen[missing[0]] = None
            elif self.ways.is_open(robot, way):
                options.append((takes[number] + left, end, legs[0]))
        if not options:
            return False
        _, _, best = min(options, key=lambda option: option[:2])
        goal = robot.goal
        if (
            goal is None
            or self.resolutions.against_leg(robot, best)
            or self.claim.excludes(robot, best.slots, robot.rank)
        ):
            return False
        try:
            rest = self.admission.plan(robot, best.end, goal)
        except NoRoute:
            return False
        self._turned_off[robot] = None
        robot.take_route(self.admission.graph.lanes.route([best, *rest.legs], goal))
        return True

    def _make_room(self, robot: Vehicle, slots: tuple[int, ...], missing: Sequence[int], most: float) -> _Search | None:
        """Make others give a vehicle room, and let it drive on; return None, or the search if it has failed."""
        # A vehicle that stands on the lane, or beside the way, has to leave before another one enters.
        goes = missing[:1] == [*slots[-1:]] and self.slots.full(slots[-1])
        search = _Search(robot, robot.rank, goes, {robot: None}, most=most)
        if not missing:
            # A claim or a resolution keeps the vehicle out.
            search.moving = True
            return search
        slot = missing[0]
        if not self._may_clear(slot, search):
            return search
        chain = self._find_chain(slot, robot, search)
        if chain is None:
            return search
        on_their_way: list[tuple[Vehicle, Sequence[int]]] = []
        pushed: _Chain = []
        for other, way in chain:
            wait = self.admission.waits.get(other)
            if wait is not None and not wait.why and wait.leg == way.legs[0]:
                on_their_way.append((other, self.slots.of(wait.leg)))
            else:
                pushed.append((other, way))
        if goes:
            on_their_way.append((robot, slots))
        room = self._yield(pushed, robot, on_their_way)
        if not room:
            search.moving = search.moving or room is None
            search.seen.update(dict.fromkeys(at for _, way in chain for at in way.slots))
            return search
        for other, _ in on_their_way:
            self._turned_off.pop(other, None)
            self.admission.release(other)
        return None

    def _find_chain(self, slot: int, robot: Vehicle, search: _Search) -> _Chain | None:
        """Return the vehicles that have to drive, and their ways, so that a slot has room; None if there are none.

        The search is depth first: each vehicle takes the place of the next one in the chain.
        """
        chain: _Chain = []
        todo = [self._options(slot, robot, search)]
        while todo:
            option = next(todo[-1], None)
            if option is None:
                todo.pop()
                if todo:
                    chain.pop()
                continue
            chain.append(option)
            other, way = option
            in_the_way = self.slots.in_the_way(other, way.end)
            if not in_the_way or (search.goes and search.first in in_the_way):
                return chain
            todo.append(self._options(way.end, other, search))
        return None

    def _options(self, slot: int, pusher: Vehicle, search: _Search) -> Iterator[tuple[Vehicle, Way]]:
        """Yield the vehicles that could leave a slot for *pusher*, each with a way that it could take."""
        slots = self.slots
        inside = slots.holders[slot]
        if len(inside) > 1 or slots.near:
            inside = sorted({*inside, *slots.beside(pusher, slot)}, key=by_rank, reverse=True)
        for other in inside:
            if other in search.pushed:
                continue
            if not self._may_push(other, search):
                self._note(other, slot, search)
            elif len(search.pushed) > search.most:
                search.cut = True
            else:
                search.pushed[other] = None
                for way in self._ways_aside(other, pusher, slot, search):
                    yield other, way

    def _note(self, other: Vehicle, slot: int, search: _Search) -> None:
        """Record that a vehicle in a slot can't make room now."""
        search.seen[slot] = None
        if not search.moving:
            search.moving = other.busy or (
                not other.stands and (other.rank < search.order or other not in self.admission.waits)
            )

    def _may_push(self, robot: Vehicle, search: _Search) -> bool:
        """Return whether a vehicle may be moved: it set out later or is idle, and it waits or stands.

        A vehicle that has just made room first turns towards its goal.
        """
        return (
            robot.rank > search.order
            and (robot in self.admission.waits or robot.may_yield)
            and robot not in self.resolutions.by_robot
        )

    def _ways_aside(self, robot: Vehicle, pusher: Vehicle, slot: int, search: _Search) -> list[Way]:
        """Return the ways by which a vehicle can make room in a slot, the best one for its own goal first."""
        slots, near, taken = self.slots, self.slots.near, self.slots.held(pusher)
        costs, takes, speed = self.costs.of(robot)
        found: list[tuple[bool, float, int, Way]] = []
        place, free = slots.held(robot)[-1], slots.free
        wait = None if robot.may_yield else self.admission.waits.get(robot)
        if wait is not None:
            # A vehicle that waits can make room only along its own route.
            leg, needed = wait.leg, slots.of(wait.leg)
            ways = [] if wait.why or leg.lane is None else [(Way((leg,), needed, needed[-1]), 0.0)]
        elif place < len(self.admission.graph.lanes.names):
            ways = [(way, takes[way.number]) for way in self.ways.from_waypoint(place)]
        else:
            ways = [(way, sum(leg.seconds(speed) for leg in way.legs)) for way in self.ways.leaving(robot)]
        for way, seconds in ways:
            _, needed, end, _ = way
            if end in taken or end == slot or (near and slots.touch(robot, (end,), pusher, slot)):
                continue
            lane = needed[0]
            if free[lane] < 1 and lane != end and lane != place:  # noqa: PLR1714 - a tuple would be made for each
                for other in slots.holders[lane]:
                    self._note(other, lane, search)
            elif near and self._is_beside(robot, way, search):
                continue
            elif (free[end] >= 1 or self._may_clear(end, search)) and not self._is_kept_out(robot, way, search):
                occupied = costs is None and free[end] < 1
                found.append((occupied, seconds + (costs[end] if costs else 0.0), end, way))
        if len(found) > 1:
            found.sort(key=_ORDER)
        return [way for *_, way in found]

    def _is_kept_out(self, robot: Vehicle, way: Way, search: _Search) -> bool:
        """Return whether something other than a vehicle prevents another from making room by a way."""
        return (
            not self.ways.is_open(robot, way)
            or self.resolutions.against(robot, way.slots, search.first) is not None
            or self.claim.excludes(robot, way.slots, search.order)
        )

    def _is_beside(self, robot: Vehicle, way: Way, search: _Search) -> bool:
        """Return whether a vehicle would touch others before the end of a way, and note these."""
        beside = [(at, other) for at in way.slots[:-1] for other in self.slots.beside(robot, at)]
        for at, other in beside:
            self._note(other, at, search)
        return bool(beside)

    def _may_clear(self, slot: int, search: _Search) -> bool:
        """Return whether a slot may become free; a cheap test for the usual case of a single vehicle that stays."""
        inside = self.slots.holders[slot]
        if len(inside) != 1 or self.slots.free[slot] >= 1 or self.slots.near:
            return True
        other = inside[0]
        if other is search.first:
            return search.goes
        if other in search.pushed:
            return False
        if self._may_push(other, search):
            return True
        self._note(other, slot, search)
        return False

    def _untie(self, robot: Vehicle) -> None:
        """Resolve a deadlock of vehicles that stand or wait, if that is possible."""
        cycle = waits_for_cycle(self.admission, robot, self.admission.causes.blockers(robot))
        if cycle:
            self._publish(cycle)
            robot = min(cycle, key=by_rank)
            if self.resolutions.see_to(robot):
                return
        self._move_others(robot)


POLICY = Policy(name="planned", settings=PlannedSettings, rule=Planned)
