"""The topics that show what goes wrong: the log of the nodes, and the diagnostics of the robots."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import stamp
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.events.goals import GoalStatusChanged, SendGoalRejected
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.diagnostic_msgs import DiagnosticStatus
from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.topics import Topic
from hmrsim.robots.power import Level
from hmrsim_zenoh.ros2.keys import Node
from hmrsim_zenoh.ros2.names import OTHER_NODE, WORLD_NODE, node_of
from hmrsim_zenoh.ros2.publishing.endpoints import DIAGNOSTICS, ROSOUT

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.protocol.outputs import EventStamped, GoalChanged
    from hmrsim.robots.power import Energy
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.publishing.publishers import TopicPublishers
    from hmrsim_zenoh.server.interest import SubscriberWatch

_LEVELS: Final[Mapping[Severity, int]] = {
    Severity.INFO: Log.INFO,
    Severity.WARNING: Log.WARN,
    Severity.ERROR: Log.ERROR,
}
"""The levels of events in the log; events for debugging are not in it."""

_OF_LEVEL: Final[Mapping[Level, tuple[int, str]]] = {
    Level.GOOD: (DiagnosticStatus.OK, "good"),
    Level.LOW: (DiagnosticStatus.WARN, "low"),
    Level.CRITICAL: (DiagnosticStatus.ERROR, "critical"),
    Level.EMPTY: (DiagnosticStatus.ERROR, "empty"),
}
"""The condition of a battery at each level."""

_PERIOD: Final = 1.0
"""Simulated seconds between two messages of diagnostics, as with diagnostic_updater."""


_ROSOUT, _DIAGNOSTICS = f"/{ROSOUT}", f"/{DIAGNOSTICS}"


class HealthTopics:
    """Publishes the log and the diagnostics, if they have subscribers."""

    def __init__(self, simulator: Simulator, publishers: TopicPublishers, interest: SubscriberWatch[str]) -> None:
        self._simulator = simulator
        self._interest = interest
        self._publish = publishers.publish
        self._diagnosed = -_PERIOD

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is needed for a subscriber."""
        if topic is Topic.CLOCK:
            return self._interest[_DIAGNOSTICS]
        return topic is Topic.EVENTS and self._interest[_ROSOUT]

    def event(self, output: EventStamped) -> None:
        """Log an event of the world."""
        if self._interest[_ROSOUT]:
            self._log_event(output.event)

    def change(self, change: GoalChanged) -> None:
        """Log the end of a goal."""
        if self._interest[_ROSOUT] and change.status.terminal:
            self._log_event(change.event())

    def log(self, node: Node, level: int, text: str) -> None:
        """Publish a line of a node's log; from any thread.

        Args:
            node: The node.
            level: As in `Log`.
            text: The line.
        """
        if not self._interest[_ROSOUT]:
            return
        logger = node.full_name[1:].replace("/", ".")
        now = values_of(stamp(self._simulator.now))
        line = unbuilt(Log, stamp=now, level=level, name=logger, msg=printable(text))
        self._publish(WORLD, ROSOUT, line)

    def tick(self) -> None:
        """Publish the diagnostics if they are due; called at each sample of the clock."""
        now = self._simulator.now
        if self._interest[_DIAGNOSTICS] and not 0.0 <= now - self._diagnosed < _PERIOD:
            self._diagnosed = now
            header = {"stamp": values_of(stamp(now)), "frame_id": ""}
            message = {"header": header, "status": list(diagnostics(self._simulator))}
            self._publish(WORLD, DIAGNOSTICS, message)

    def _log_event(self, event: Event) -> None:
        severity = event.severity
        if severity is Severity.DEBUG:
            return
        if isinstance(event, (GoalStatusChanged, SendGoalRejected)):
            node, text = node_of(event.robot, event.action), event.text()
        elif event.subject in self._simulator.roster.robots:
            node, text = Node(f"/{event.subject}", OTHER_NODE), event.text()
        else:
            node, text = WORLD_NODE, event.describe()
        # A robot without a connection can't tell.
        if node.robot not in self._simulator.dispatcher.cut_off:
            self.log(node, _LEVELS[severity], text)


def diagnostics(simulator: Simulator) -> Iterator[dict[str, Any]]:
    """Yield a DiagnosticStatus for each robot, battery and active fault, as plain values."""
    cut_off = simulator.dispatcher.cut_off
    for name, robot in simulator.roster.robots.items():
        if name in cut_off:
            yield _status(name, "robot", DiagnosticStatus.STALE, "no connection")
            continue
        disabled = "; ".join(robot.disabled_reasons.values())
        level = DiagnosticStatus.ERROR if disabled else DiagnosticStatus.WARN if robot.waits else DiagnosticStatus.OK
        moving = "waits" if robot.waits else "drives" if robot.moves else "stands"
        yield _status(name, "robot", level, disabled or moving, type=robot.type)
        if robot.energy is not None:
            yield _battery(name, robot.energy, robot.now)
    for name, fault in sorted(simulator.fault_injector.known.items()):
        if fault.end is not None:
            began = fault.began()
            robot_name = began.robot or began.subject
            yield _status(robot_name, f"fault {name}", DiagnosticStatus.WARN, began.fault, since=f"{fault.since:g}")


def _battery(robot: str, energy: Energy, now: float) -> dict[str, Any]:
    level, text = _OF_LEVEL[energy.level]
    share, charging = energy.battery.share(now), bool(energy.battery.charging)
    return _status(robot, "battery", level, text, percentage=f"{share:.3f}", charging=str(charging))


def _status(hardware: str, part: str, level: int, message: str, **values: str) -> dict[str, Any]:
    return {
        "level": level,
        "name": f"{hardware}: {part}" if hardware else part,
        "message": printable(message),
        "hardware_id": hardware,
        "values": [{"key": key, "value": value} for key, value in values.items()],
    }
