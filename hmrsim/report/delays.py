"""The delay of each delivered order, attributed to what its robots did meanwhile."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.report.first_causes import Past

if TYPE_CHECKING:
    from hmrsim.history.items import Order
    from hmrsim.history.robots import State
    from hmrsim.history.timeline import Timeline
    from hmrsim.report.robots import RobotLog

Part = Literal["assignment", "travel", "handling", "queue", "charging", "traffic", "faults"]

PARTS: Final[tuple[Part, ...]] = ("assignment", "travel", "handling", "queue", "charging", "traffic", "faults")
"""The parts of an order's lead time."""

PART_OF: Final[dict[State, Part]] = {
    "offline": "faults",
    "stopped": "faults",
    "waiting": "traffic",
    "driving": "travel",
    "charging": "charging",
    "busy": "handling",
    "idle": "assignment",
}
"""The part of the lead time for which a state of the order's robot counts."""


class _Handled(NamedTuple):
    """An item is picked up or put down; *number* is the place in the list of what its robot has handled."""

    at: int
    robot: str
    picked: bool
    number: int


class Delays:
    """Attributes the lead times of delivered orders.

    An order is with the robot that carries its item. Before, it is with the robot that picks the item up next, from
    the time at which that robot last picked up or put down anything. In between, the order waits for its assignment.
    """

    def __init__(self, timeline: Timeline, robot_log: RobotLog) -> None:
        self._robot_log = robot_log
        self._pasts: dict[str, Past] = {}
        self._of_item: dict[str, list[_Handled]] = defaultdict(list)
        self._of_robot: dict[str, list[int]] = defaultdict(list)
        timeline.on(ItemPicked, lambda at, event: self._handle(at, event.robot, event.item, picked=True))
        timeline.on(
            (ItemPlaced, ItemDropped), lambda at, event: self._handle(at, event.robot, event.item, picked=False)
        )

    def _handle(self, at: int, robot: str, item: str, *, picked: bool) -> None:
        times = self._of_robot[robot]
        self._of_item[item].append(_Handled(at, robot, picked, len(times)))
        times.append(at)

    def of(self, order: Order) -> dict[Part, int] | None:
        """Return the parts of an order's lead time in nanoseconds; None if it was not delivered.

        They add up to the lead time. The tracks of the robots must have ended.
        """
        if order.state != "delivered" or order.ended is None:
            return None
        parts = dict.fromkeys(PARTS, 0)
        at, carrier = order.placed, ""
        for handled in self._of_item.get(order.item, ()):
            if not order.placed <= handled.at <= order.ended:
                continue
            since, robot = at, carrier
            if handled.picked and not carrier:
                robot = handled.robot
                since = max(at, self._of_robot[robot][handled.number - 1]) if handled.number else at
                parts["assignment"] += since - at
            self._add(parts, robot, since, handled.at)
            at, carrier = handled.at, handled.robot if handled.picked else ""
        self._add(parts, carrier, at, order.ended)
        return parts

    def _add(self, parts: dict[Part, int], robot: str, began: int, ended: int) -> None:
        """Add what a robot did in some time; time without a robot, or without a known state, is for its assignment."""
        left = ended - began
        for part, time in _parts_of(self._past(robot), began, ended) if robot in self._robot_log.tracks else ():
            parts[part] += time
            left -= time
        parts["assignment"] += left

    def _past(self, robot: str) -> Past:
        if robot not in self._pasts:
            self._pasts[robot] = Past(self._robot_log.tracks[robot])
        return self._pasts[robot]


def _parts_of(past: Past, began: int, ended: int) -> Iterator[tuple[Part, int]]:
    """Yield what a robot did in some time, and for how long."""
    for start, end, state in past.spans_within(began, ended):
        since, until = max(start, began), min(end, ended)
        if since >= until:
            continue
        apart = 0
        if state in ("busy", "waiting"):
            special: Part = "queue" if state == "busy" else "faults"
            apart = sum(
                max(0, min(wait.ended or wait.began, until) - max(wait.began, since))
                for wait in past.waits_within(since, until)
                if (wait.kind == "dock" if state == "busy" else wait.kind == "way" and wait.closed)
            )
            yield special, apart
        yield PART_OF[state], until - since - apart
