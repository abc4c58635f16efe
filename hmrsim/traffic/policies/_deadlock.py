"""Moving robots that stand in each other's way one by one, as a search over where each of them is says."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.traffic.policies.reserve import rank

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hmrsim.navigation.lanes import Edge
    from hmrsim.robots.vehicle import Mobile
    from hmrsim.traffic.policies.priority import Priority

_MOST_ROBOTS = 6
"""Robots that are moved for one: each one more makes the search longer by as many times as there are waypoints."""

_Places = tuple[int, ...]


class Move(NamedTuple):
    """One robot drives one lane."""

    robot: Mobile
    edge: Edge


@dataclass(eq=False)
class Untying:
    """A knot that is being untied.

    Attributes:
        first: For whose sake.
        moves: What is still to be done, in order.
        robots: Who is moved.
    """

    first: Mobile
    moves: list[Move]
    robots: list[Mobile] = field(init=False)

    def __post_init__(self) -> None:
        """Note who is moved."""
        self.robots = [*dict.fromkeys([self.first, *(move.robot for move in self.moves)])]


def find_moves(rules: Priority, robot: Mobile, target: int, most: int) -> list[Move] | None:
    """Return the fewest moves after which a robot is at a waypoint; None if there are none, or none that are found.

    Those who stand in the way of it come into the search one after the other, nearest first.

    Args:
        rules: Who is where, and who may be moved.
        robot: Which.
        target: The waypoint.
        most: How many situations are looked at, at most, in all.
    """
    if robot.slots[-1] >= len(rules.passage.graph.lanes.out):
        # It stands in the middle of a lane, which only those before it and behind it can leave.
        return None
    group = [robot]
    while len(group) < _MOST_ROBOTS and most > 0:
        joining = next(_around(rules, group, target), None)
        if joining is None:
            return None
        group.append(joining)
        moves, looked = _search(rules, group, target, most)
        if moves is not None:
            return moves
        most -= looked
    return None


def _around(rules: Priority, group: Sequence[Mobile], target: int) -> Iterator[Mobile]:
    """Yield those that may be moved, in the order in which one comes upon them from the target."""
    out = rules.passage.graph.lanes.out
    seen, todo = {target}, deque([target])
    while todo:
        node = todo.popleft()
        for other in sorted(rules.slots.inside(node), key=rank):
            if other not in group and other.slots == (node,) and rules.movable(other, group[0]):
                yield other
        for edge in out[node]:
            if edge.end not in seen:
                seen.add(edge.end)
                todo.append(edge.end)


def _search(rules: Priority, group: Sequence[Mobile], target: int, most: int) -> tuple[list[Move] | None, int]:
    """Search all situations of a group breadth first; return the moves, and how many situations were looked at."""
    start: _Places = tuple(robot.slots[-1] for robot in group)
    before: dict[_Places, tuple[_Places, int, Edge] | None] = {start: None}
    todo = deque([start])
    while todo and len(before) < most:
        places = todo.popleft()
        if places[0] == target:
            return _moves(before, places, group), len(before)
        for i, place in enumerate(places):
            for edge in _steps(rules, group, place):
                if edge.end in places:
                    continue
                after = (*places[:i], edge.end, *places[i + 1 :])
                if after not in before:
                    before[after] = (places, i, edge)
                    todo.append(after)
    return None, len(before)


def _steps(rules: Priority, group: Sequence[Mobile], place: int) -> Iterator[Edge]:
    """Yield the lanes from a waypoint on which only the group can be in the way."""
    slots = rules.slots
    for edge in rules.passage.graph.lanes.out[place]:
        lane = edge.leg.lane
        others = (other for slot in edge.leg.slots if slots.full(slot) for other in slots.inside(slot))
        if lane and rules.passage.is_open(lane) and all(other in group for other in others):
            yield edge


def _moves(
    before: dict[_Places, tuple[_Places, int, Edge] | None], places: _Places, group: Sequence[Mobile]
) -> list[Move]:
    moves = []
    while (step := before[places]) is not None:
        places, i, edge = step
        moves.append(Move(group[i], edge))
    return moves[::-1]
