"""Reservations as in `hmrsim.traffic.policies.reserve`, but whoever set out first has others make room for it.

That is priority inheritance with backtracking (PIBT; Okumura and others, 2019) where robots take their own time: one
that stands in the way of another that set out earlier drives to a free waypoint beside it, or has whoever is there
make room in turn; a circle of three or more moves on all at once. Robots that have nothing to do, or wait themselves,
make room; those that are at work where they stand do not.

Where that is not enough, as in dead ends, all robots of the knot are moved one by one as a search over where each of
them is says. The one that set out first gets on its way so, whatever the others want; when it has arrived the next one
is the first. So where waypoints are connected in both directions and there is room for two to pass, nobody waits for
ever.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from hmrsim.traffic.policies import Policy
from hmrsim.traffic.policies._deadlock import Move, Untying, find_moves
from hmrsim.traffic.policies._waits_for import circle_of
from hmrsim.traffic.policies.reserve import Exit, Reserve, ReserveSettings, exits, rank

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.navigation.route import Leg
    from hmrsim.robots.vehicle import Mobile
    from hmrsim.traffic.admission import Passage

    _Chain = list[tuple[Mobile, Exit]]
    """Who makes room, and by which way."""


_BETWEEN_SEARCHES = 5.0
"""Simulated seconds from one search for a robot to the next: what was in vain is so for a while."""


class PrioritySettings(ReserveSettings):
    """What every reservation has, and how far a knot is searched.

    Attributes:
        most_states: How many situations of robots a search for a way out looks at before it gives up.
    """

    most_states: Annotated[int, Field(strict=True, ge=0, le=10_000_000)] = 20_000


class Priority(Reserve):
    """Priorities at work in one world.

    Args:
        passage: The ways of the world.
        settings: How many robots go where.
    """

    def __init__(self, passage: Passage, settings: PrioritySettings) -> None:
        super().__init__(passage, settings)
        self._most_states = settings.most_states
        self._untyings: dict[Mobile, Untying] = {}
        self._stuck: dict[Mobile, None] = {}
        self._searched: dict[Mobile, float] = {}
        self.take, self.stand = self._take, self._stand

    def _take(self, robot: Mobile, leg: Leg) -> bool:
        """As `Reserve.take`, but who is part of a knot moves as the knot is untied, and not by itself."""
        return robot not in self._untyings and self.slots.take(robot, leg)

    def _stand(self, robot: Mobile, slots: tuple[int, ...]) -> None:
        """As `Reserve.stand`; whoever could not be helped before may be now."""
        self.slots.stand(robot, slots)
        if self._stuck:
            stuck, self._stuck = self._stuck, {}
            self.passage.look_again([*stuck])

    def blockers(self, robot: Mobile, leg: Leg) -> Sequence[Mobile]:
        """Return who occupies what a robot would need, or for whose sake it is moved."""
        untying = self._untyings.get(robot)
        return super().blockers(robot, leg) or ([untying.first] if untying and untying.first is not robot else [])

    def begin_anew(self) -> None:
        """Forget who could not be helped, and when."""
        super().begin_anew()
        self._stuck.clear()
        self._searched.clear()

    def halted(self, robot: Mobile) -> None:
        """Give up the knot of which a robot is a part: the next move would wait for it."""
        if robot in self._untyings:
            self._drop(self._untyings[robot])

    def blocked(self, robot: Mobile) -> None:
        """Have those in the way make room if they set out later, and this is not part of a knot being untied."""
        if robot in self._untyings:
            return
        circle = circle_of(self.passage, robot)
        if circle:
            self._tell(circle)
            robot = min(circle, key=rank)
        blockers = self.passage.blockers(robot)
        self._stuck[robot] = None
        if not all(other.stands or other.waits for other in blockers):
            # Who is on its way will be off it.
            return
        if any(other in self._untyings or (other.waits and rank(other) < rank(robot)) for other in blockers):
            return
        if not (self._push(robot) or self._clear_lanes(robot)):
            self._untie(robot)

    def keeps_aside(self, robot: Mobile) -> bool:
        """Return whether a robot has made room as one move of several; the next one begins, or all ask again."""
        untying = self._untyings.get(robot)
        if untying is None:
            return False
        self._go_on_untying(untying)
        return True

    # --- pushing --------------------------------------------------------------------------------------------------

    def _push(self, robot: Mobile) -> bool:
        """Have those make room that are in a robot's way, and let it go on; return whether they can."""
        wait = self.passage.waits.get(robot)
        if wait is None or not wait.leg.slots:
            return False
        slot = next(self.slots.missing(robot, wait.leg.slots), None)
        chain = None if slot is None else self._chain(slot, robot, robot, {robot: None})
        if chain is None:
            return False
        # Who stands on the lane has to be off it before anybody comes.
        goes = slot == wait.leg.slots[-1]
        if not self._make_room(chain, robot, [(robot, wait.leg)] if goes else []):
            return False
        if goes:
            self.passage.release(robot)
        return True

    def _make_room(self, chain: _Chain, robot: Mobile, own: Sequence[tuple[Mobile, Leg]] = ()) -> bool:
        """Have all of a chain make room for a robot at once, which may go itself; return whether there is room."""
        if not self.slots.exchange([*own, *((other, way.leg) for other, way in chain)]):
            return False
        for other, way in chain:
            self.passage.push(other, way.leg, robot)
        return True

    def _clear_lanes(self, robot: Mobile) -> bool:
        """Have somebody leave a lane in whose middle it stands, so that nobody gets past; return whether one can."""
        lanes = self.passage.graph.lanes
        for slot in range(len(lanes.names), len(lanes.names) + len(lanes.tracks)):
            if not any(self._gives_way(other, robot) for other in self.slots.inside(slot)):
                continue
            chain = self._chain(slot, robot, robot, {robot: None})
            if chain is not None and self._make_room(chain, robot):
                return True
        return False

    def _chain(self, slot: int, first: Mobile, pusher: Mobile, pushed: dict[Mobile, None]) -> _Chain | None:
        """Return who drives where so that there is room in a slot; None if they can't make any.

        Args:
            slot: Where.
            first: For whom all make room; it makes room itself when it goes on.
            pusher: Who needs the slot: there nobody can go.
            pushed: Who has been asked already.
        """
        for other in sorted(self.slots.inside(slot), key=rank, reverse=True):
            if other in pushed or not self._gives_way(other, first):
                continue
            pushed[other] = None
            for way in self._refuges(other, pusher):
                if not self.slots.full(way.end) or first in self.slots.inside(way.end):
                    return [(other, way)]
                further = self._chain(way.end, first, other, pushed)
                if further is not None:
                    return [(other, way), *further]
        return None

    def _gives_way(self, other: Mobile, robot: Mobile) -> bool:
        return other.may_make_room and other not in self._untyings and rank(other) > rank(robot)

    def _refuges(self, robot: Mobile, pusher: Mobile) -> list[Exit]:
        """Return the ways by which a robot can make room: the free ones first, and the best for its own way."""
        wait = self.passage.waits.get(robot)
        wanted = wait.leg.slots[-1:] if wait else ()

        def cost(way: Exit) -> tuple[bool, bool, float, int]:
            return self.slots.full(way.end), way.end not in wanted, way.leg.length, way.end

        return [
            way
            for way in sorted(exits(self.passage, robot), key=cost)
            if next(self.slots.missing(robot, way.leg.slots[:1]), None) is None and way.end not in pusher.slots
        ]

    # --- untying --------------------------------------------------------------------------------------------------

    def _untie(self, robot: Mobile) -> None:
        """Move the robots around one that can't go on so that it can, if there is a way."""
        wait = self.passage.waits.get(robot)
        if wait is None or len(wait.leg.slots) < 2:  # noqa: PLR2004 - a lane and the waypoint at its end
            return
        now = self.passage.now
        if now - self._searched.get(robot, -math.inf) < _BETWEEN_SEARCHES:
            return
        self._searched[robot] = now
        moves = find_moves(self, robot, wait.leg.slots[-1], self._most_states)
        if moves is None:
            around = any(other.stands for other in self.passage.blockers(robot)) and self.go_around(robot)
            circle = [] if around else circle_of(self.passage, robot)
            if circle and self.slots.at_rest(lambda other: self.passage.is_held_up(other) or not other.busy):
                # Nobody moves, and nobody ever will.
                self.give_up(circle)
            return
        untying = Untying(robot, moves)
        self._untyings.update(dict.fromkeys(untying.robots, untying))
        self._go_on_untying(untying)

    def movable(self, other: Mobile, robot: Mobile) -> bool:
        """Return whether a robot may be moved for another's sake."""
        return other is robot or self._gives_way(other, robot)

    def _go_on_untying(self, untying: Untying) -> None:
        """Begin the next move; if somebody else is in its way by now, all is dropped and everybody asks again."""
        if untying.moves:
            move: Move = untying.moves.pop(0)
            there = move.robot.may_make_room and move.robot.slots == (move.edge.start,)
            if there and self.slots.exchange([(move.robot, move.edge.leg)]):
                self.passage.push(move.robot, move.edge.leg, untying.first)
                return
        self._drop(untying)

    def _drop(self, untying: Untying) -> None:
        for robot in untying.robots:
            self._untyings.pop(robot, None)
        for robot in sorted(untying.robots, key=rank):
            self.passage.try_again(robot)

    def _tell(self, circle: Sequence[Mobile]) -> None:
        """Tell of a deadlock once, and not of each time that it is looked at."""
        if not any(robot in self._untyings for robot in circle):
            super()._tell(circle)


POLICY = Policy(name="priority", settings=PrioritySettings, rule=Priority)
