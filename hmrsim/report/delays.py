"""The lead times of delivered orders, divided into parts such as travel, queues and traffic."""

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
"""The part of the lead time to which each state of the order's robot counts."""


class _Handling(NamedTuple):
    """A robot picks up an item or puts it down.

    Attributes:
        number: The number of times that the robot has picked up or put down anything before.
    """

    at: int
    robot: str
    picked: bool
    number: int


class Delays:
    """Divides the lead times of delivered orders into parts, by the states of the robots that serve them.

    The robot that serves an order is the one that carries its item. Before the item is picked up, it is the robot that
    will pick it up, from the last time that this robot picked up or put down anything. At all other times, the order
    waits for its assignment.
    """

    def __init__(self, timeline: Timeline, robot_log: RobotLog) -> None:
        self._robot_log = robot_log
        self._pasts: dict[str, Past] = {}
        self._of_item: dict[str, list[_Handling]] = defaultdict(list)
        self._of_robot: dict[str, list[int]] = defaultdict(list)
        timeline.on(ItemPicked, lambda at, event: self._handle(at, event.robot, event.item, picked=True))
        timeline.on(
            (ItemPlaced, ItemDropped), lambda at, event: self._handle(at, event.robot, event.item, picked=False)
        )

    def _handle(self, at: int, robot: str, item: str, *, picked: bool) -> None:
        times = self._of_robot[robot]
        self._of_item[item].append(_Handling(at, robot, picked, len(times)))
        times.append(at)

    def of(self, order: Order) -> dict[Part, int] | None:
        """Return the parts of an order's lead time in nanoseconds; None if it was not delivered.

        The parts add up to the lead time. Call this only after the end of the run.
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
        """Add the states of a robot during a time; the rest, such as time without a robot, counts as assignment."""
        rest = ended - began
        for part, time in _parts_of(self._past(robot), began, ended) if robot in self._robot_log.tracks else ():
            parts[part] += time
            rest -= time
        parts["assignment"] += rest

    def _past(self, robot: str) -> Past:
        if robot not in self._pasts:
            self._pasts[robot] = Past(self._robot_log.tracks[robot])
        return self._pasts[robot]


def _parts_of(past: Past, began: int, ended: int) -> Iterator[tuple[Part, int]]:
    """Yield the parts into which a robot's states divide a time, each with its nanoseconds."""
    for start, end, state in past.spans_within(began, ended):
        since, until = max(start, began), min(end, ended)
        if since >= until:
            continue
        special_time = 0
        if state in ("busy", "waiting"):
            # Queues at docks and waits for closed lanes are separate parts.
            special: Part = "queue" if state == "busy" else "faults"
            special_time = sum(
                max(0, min(wait.ended or wait.began, until) - max(wait.began, since))
                for wait in past.waits_within(since, until)
                if (wait.kind == "dock" if state == "busy" else wait.kind == "way" and wait.closed)
            )
            yield special, special_time
        yield PART_OF[state], until - since - special_time
