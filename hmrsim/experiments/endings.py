"""The endings of a run: a sink that checks the conditions in an experiment's file after each event."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import error_of
from hmrsim.events import registry
from hmrsim.events.goals import SendGoalRejected
from hmrsim.events.orders import OrderDelivered
from hmrsim.events.robots import ItemEvent
from hmrsim.events.simulation import RunReported, Teleported
from hmrsim.geometry import distance
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.demand import NEAR
from hmrsim.trials.trial import HUNG
from hmrsim.world.overlays.expressions import OverlayFlaw, names_used_in, substituted

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.experiments.model import Ending
    from hmrsim.geometry import Point
    from hmrsim.simulation.simulator import Simulator

Check = Callable[["Simulator", Any], bool]
"""Returns whether a condition holds, given the simulator and the event that may have brought it about."""

REPORTED: Final = "reported"
"""The name by which the expressions of an ending refer to the values that controllers have reported."""
BY_REPORT: Final = ("item", "robot", "at", "where")
"""The fields of an ending that may contain such expressions."""
_MAX_FAILURES: Final = 1000
"""The number of failed goals of a robot's action within one instant that counts as a livelock."""


class Judge(SelectiveSink):
    """A sink that ends a run as soon as one of its endings holds; if several hold at once, the first in the file.

    Args:
        endings: The conditions of each ending, by its label; an ending holds if one of its conditions does.

    Attributes:
        label: The label of the ending that holds; empty while the run goes on.
        cause: Details that the label lacks, such as why the run hangs; usually empty.
        at: The simulated seconds at which the run ended.
        reported: The values that controllers have reported, by name, with the last label under ``label``.
    """

    def __init__(self, endings: Mapping[str, Sequence[Ending]]) -> None:
        self.label = self.cause = ""
        self.at = 0.0
        self.reported: dict[str, Any] = {}
        self._counts: dict[GoalStatus, int] = dict.fromkeys(GoalStatus, 0)
        # The failed goals of the present instant, by robot and action.
        self._failed_at = -1
        self._failures: dict[tuple[str, str], int] = {}
        self._endings = endings
        self._checks = [
            (label, kinds, check)
            for label, conditions in endings.items()
            for condition in conditions
            for kinds, check in [_check(condition, self.reported)]
            if kinds
        ]
        self._simulator: Simulator | None = None
        kinds = {kind for _, kinds, _ in self._checks for kind in kinds}
        # Goals and reports are published even if no sink subscribes to events.
        self._topics = frozenset({Topic.EVENTS}) if kinds - {GoalChanged, RunReported} else frozenset[Topic]()
        self._end: Callable[[str], None] = lambda _reason: None

    @property
    def counts(self) -> dict[str, int]:
        """The numbers of accepted goals and of ended goals, by status."""
        return {status.name.lower(): self._counts[status] for status in _COUNTED}

    @property
    def topics(self) -> Collection[Topic]:
        """The topics to subscribe to: all events, if one of them may end the run."""
        return self._topics

    def watch(self, simulator: Simulator, end: Callable[[str], None]) -> None:
        """Start judging the run; *end* ends it after this instant, and is called with the reason."""
        self._simulator, self._end = simulator, end

    def controller_ended(self, *, succeeded: bool, now: float) -> None:
        """End the run because the controller has ended, unless the run has ended before."""
        outcome = "succeeded" if succeeded else "failed"
        for label, conditions in self._endings.items():
            if any(condition.controller == outcome for condition in conditions):
                self.end(label, now)
        self.end(outcome, now)

    def end(self, label: str, now: float) -> None:
        """End the run with a label, unless it has ended before."""
        if not self.label:
            self.label, self.at = label, now
            self._end(f"the run has ended: {label}")

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {GoalChanged: self._note_goal, EventStamped: self._note_event}
        return handlers.get(kind)

    def _note_goal(self, change: GoalChanged) -> None:
        status = change.status
        self._counts[status] += 1
        if status is GoalStatus.ABORTED:
            self._note_failure(change.stamp, change, error_of(change.result) if change.result else "")
        if self._checks and status.terminal:
            self._check_endings(change)

    def _note_event(self, output: EventStamped) -> None:
        if self.label:
            return
        event = output.event
        if isinstance(event, SendGoalRejected):
            self._note_failure(output.stamp, event, event.error_msg)
        if isinstance(event, RunReported):
            self.reported |= {**event.values, "label": event.label}
        self._check_endings(event)

    def _note_failure(self, stamp: int, goal: GoalChanged | SendGoalRejected, why: str) -> None:
        """End the run if too many goals of a robot's action have failed within one instant."""
        if self._simulator is None or self.label:
            return
        if stamp != self._failed_at:
            self._failed_at, self._failures = stamp, {}
        key = goal.robot, goal.action
        count = self._failures[key] = self._failures.get(key, 0) + 1
        if count >= _MAX_FAILURES:
            last = f"; the last one: {why}" if why else ""
            what = f"{count:,} goals of {goal.robot}/{goal.action} failed within one instant"
            self.cause = f"time stands still: {what}{last}"
            self.end(HUNG, self._simulator.now)

    def _check_endings(self, event: Any) -> None:
        """End the run if an event or the end of a goal has brought about one of the endings."""
        simulator = self._simulator
        if simulator is None or self.label:
            return
        for label, kinds, check in self._checks:
            if isinstance(event, kinds) and check(simulator, event):
                self.end(label, simulator.now)
                return


_COUNTED: Final = (GoalStatus.ACCEPTED, *(status for status in GoalStatus if status.terminal))


def _check(condition: Ending, reported: Mapping[str, Any]) -> tuple[tuple[type, ...], Check]:
    """Return the types of events that may bring about a condition, and the function that checks it then.

    There are no types for a condition that no event brings about. *reported* has the values that controllers have
    reported so far.
    """
    kinds, check = _check_of(condition)
    expressions = {name: value for name in BY_REPORT if names_used_in(value := getattr(condition, name))}
    if not expressions:
        return kinds, check

    def check_with_reported(simulator: Simulator, event: Any) -> bool:
        try:
            values = {name: substituted(value, {REPORTED: reported}) for name, value in expressions.items()}
        except OverlayFlaw:
            return False  # the value has not been reported yet
        # Controllers may report a number as a name.
        fields = {name: value if name == "where" else str(value) for name, value in values.items()}
        return _check_of(condition.model_copy(update=fields))[1](simulator, event)

    return (kinds if condition.event else (*kinds, RunReported)), check_with_reported


def _check_of(condition: Ending) -> tuple[tuple[type, ...], Check]:
    """Return the same as `_check` for a condition without expressions."""
    if condition.event is not None:
        return (registry()[condition.event],), partial(_is_event, condition.where)
    if condition.reported is not None:
        return (RunReported,), lambda _simulator, event: bool(event.label == condition.reported)
    if condition.item is not None:
        return (ItemEvent, Teleported), partial(_item_is_there, condition)
    if condition.robot is not None:
        return (GoalChanged, Teleported), partial(_robot_is_there, condition)
    if condition.orders is not None:
        return (OrderDelivered,), partial(_orders_are_served, condition.count)
    return (), lambda _simulator, _event: False


def _is_event(where: Mapping[str, Any], _simulator: Simulator, event: Event) -> bool:
    if not where:
        return True
    fields = event.as_dict()
    return all(fields.get(name) == value for name, value in where.items())


def _item_is_there(condition: Ending, simulator: Simulator, _event: object) -> bool:
    item = simulator.items.get(condition.item or "")
    if item is None or (condition.carried is not None and condition.carried is not (item.carrier is not None)):
        return False
    return _near(simulator, item.position, condition.at or "")


def _robot_is_there(condition: Ending, simulator: Simulator, _event: object) -> bool:
    robot = simulator.robots.get(condition.robot or "")
    return robot is not None and _near(simulator, robot.pose().point, condition.at or "")


def _near(simulator: Simulator, point: Point, place: str) -> bool:
    world = simulator.world
    try:
        there = world.point(place)
    except KeyError:  # a name that the controller has reported
        return False
    return distance(point, there) <= NEAR[world.units]


def _orders_are_served(count: int | None, simulator: Simulator, _event: object) -> bool:
    demand = simulator.demand
    # The event arrives before the order is closed.
    return demand.totals.delivered >= count if count is not None else demand.served
