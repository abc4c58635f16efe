"""A monitor that tests feed with events by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bt_controller.loading.trees import load
from bt_controller.running.runner import run_tree
from hmrsim.events import from_json
from hmrsim.history.occurrence import Occurrence, SceneSeen
from hmrsim.properties import Ended, Monitor, MonitorSink, properties_of
from hmrsim.settings.run import RunSettings
from hmrsim.world_checks import load_world
from hmrsim.world_checks.loading import world_of
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.properties import Verdict
    from hmrsim.world.model import World

OFF = dict.fromkeys(
    (
        "goals_end",
        "no_deadlock",
        "nobody_stranded",
        "orders_in_time",
        "controller_lives",
        "no_vain_goals",
        "mission_ends",
        "recovers",
    ),
    False,
)
"""Settings that turn all built-in properties off."""

WARD = {
    "name": "ward",
    "waypoints": {"lab": [0, 0], "hall": [10, 0], "ward_a": [20, 0], "ward_b": [20, 10]},
    "lanes": [["lab", "hall"], ["hall", "ward_a"], ["ward_a", "ward_b"]],
    "items": {"medicine": {"at": [0, 0.5]}},
    "doors": {"gate": {"at": [[5, -1], [5, 1]]}},
    "docks": {"charger": {"at": "lab", "type": "charger"}},
    "robot_types": {"nurse": {"components": {"claw": {}, "battery": {}}}},
    "robots": {
        "eve": {"type": "nurse", "at": "lab"},
        "wall_e": {"type": "nurse", "at": "hall"},
        "cart": {"at": "ward_b"},
    },
    "demand": [{"name": "pills", "at": "lab", "to": "ward_a", "arrives": 100, "within": 60}],
}
"""A world with waypoints 10 m apart and an entity of each kind."""


def ward(**changes: Any) -> World:
    """Return the world, with some of its parts replaced."""
    return world_of({**WARD, **changes}, "ward")


def seconds(at: float) -> int:
    """Return simulated seconds as nanoseconds."""
    return round(at * 1e9)


class Feed:
    """A monitor with methods that feed it.

    Args:
        properties: By name.
        built_in: Settings of built-in properties; all are off by default.
    """

    def __init__(
        self,
        properties: Mapping[str, Any] | None = None,
        *,
        built_in: Mapping[str, Any] | None = None,
        world: World | None = None,
    ) -> None:
        file = {"properties": dict(properties or {}), "built_in": {**OFF, **(built_in or {})}}
        self.monitor = Monitor(properties_of(file), world or ward())

    def event(self, at: float, kind: str, /, **fields: Any) -> Feed:
        """Feed an event to the monitor."""
        self.monitor.take(Occurrence(seconds(at), from_json({"kind": kind, **fields})))
        return self

    def goal(self, at: float, robot: str, action: str, goal_id: str, *statuses: int, cause: str = "") -> Feed:
        """Feed several statuses of a goal at one instant."""
        for status in statuses:
            why = {"cause": cause} if cause and status > 4 else {}
            self.event(at, "status", robot=robot, action=action, goal_id=goal_id, status=status, **why)
        return self

    def scene(self, at: float, **fields: Any) -> Feed:
        """Feed the state of the world."""
        self.monitor.take(Occurrence(seconds(at), SceneSeen(fields)))
        return self

    def end(self, at: float, ending: str | None = "succeeded", cause: str = "") -> Feed:
        """Feed the end of the run."""
        self.monitor.end(seconds(at), None if ending is None else Ended(ending, cause))
        return self

    @property
    def violations(self) -> list[tuple[float, str, str, str]]:
        """The violations: time in seconds, property, subject, reason."""
        return [(each.at / 1e9, each.property, each.subject, each.reason) for each in self.monitor.violations]

    def verdict(self, name: str) -> Verdict:
        """Return the verdict on a property."""
        (found,) = [each for each in self.monitor.verdicts() if each.property == name]
        return found


def watch(world: str, tree: str, properties: Mapping[str, Any] | None = None) -> Monitor:
    """Return the monitor of a run of a tree by all robots of a shipped world."""
    loaded, made = load_world(world).world, list[Monitor]()

    def watchers(simulator: Any, _pacing: Any) -> list[MonitorSink]:
        made.append(Monitor(properties_of(properties or {}), loaded))
        return [MonitorSink(simulator, made[0])]

    with (
        LoopbackHost(loaded, RunSettings(), watchers=watchers) as host,
        Client(session=host.open_session(), name="bt_controller") as client,
    ):
        run_tree(client, load(tree), [*host.simulator.robots])
        made[0].end(None, Ended("succeeded"))
    return made[0]
