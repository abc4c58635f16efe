"""The entities of a simulation: the robots, items and fixtures of the world file and those that were spawned."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING

from hmrsim.actions import registry as actions
from hmrsim.components import registry as components
from hmrsim.diagnostics import instead
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.facilities import Fixture, Site, install_all
from hmrsim.facilities.docks import DockBays
from hmrsim.items import Item
from hmrsim.navigation.route import Delays
from hmrsim.protocol.goal import Cause
from hmrsim.protocol.outputs import RosterChanged
from hmrsim.robots.robot import Robot
from hmrsim.traffic.admission import Admission
from hmrsim.traffic.policies import rules_of, settings_of
from hmrsim.world.model import RobotSpec

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.engine.chance import Chance
    from hmrsim.engine.environment import Environment
    from hmrsim.engine.internal_errors import InternalErrors
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.events import Event
    from hmrsim.geometry import Point, Pose
    from hmrsim.goals.dispatcher import Dispatcher
    from hmrsim.goals.fault_effects import GoalFaults
    from hmrsim.navigation.external_planner import Plans
    from hmrsim.navigation.graph import WaypointGraph
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.run_control import Gate
    from hmrsim.world.model import World


class Roster:
    """The robots and items of a world, by name. The goals of a robot that is removed or moved are aborted first.

    Args:
        gate: Serves the actions of the world itself.
        errors: Handles what components raise because of a bug.
        leaving: Called with the name of a robot that is about to be removed.

    Attributes:
        robots: In order; replaced when robots come or go, so that other threads may read it.
        items: In order.
        spawned: The names of those that are not of the world file.
    """

    fixtures: dict[str, Fixture]

    admission: Admission
    robots: dict[str, Robot]
    items: dict[str, Item]
    _world: World
    _graph: WaypointGraph

    def __init__(  # noqa: PLR0913 - each is a part of its simulation
        self,
        env: Environment,
        dispatcher: Dispatcher,
        gate: Gate,
        *,
        chance: Chance,
        plans: Plans,
        publisher: EventPublisher,
        errors: InternalErrors,
        emit: Callable[[Output], None],
        leaving: Callable[[str], None],
    ) -> None:
        self._env = env
        self._dispatcher = dispatcher
        self._gate = gate
        self._chance = chance
        self._plans = plans
        self._publisher = publisher
        self._errors = errors
        self._emit = emit
        self.spawned: set[str] = set()
        self.robots = {}
        self._leaving = leaving

    def __iter__(self) -> Iterator[Robot | Item | Fixture]:
        """Yield all robots, then all items, then all fixtures."""
        yield from self.robots.values()
        yield from self.items.values()
        yield from self.fixtures.values()

    def find(self, name: str) -> Robot | Item | Fixture | None:
        """Return the entity of a name; None if there is none."""
        return self.robots.get(name) or self.items.get(name) or self.fixtures.get(name)

    def fill(self, world: World, graph: WaypointGraph) -> None:
        """Replace all entities by those of a world."""
        for _, robot in sorted(self.robots.items()):
            robot.leave()
        self._world, self._graph = world, graph
        self.admission = Admission(
            self._env,
            world,
            graph,
            rules_of=rules_of,
            patience=settings_of(world).patience,
            publisher=self._publisher,
            ways_changed=lambda: self._emit(RosterChanged()),
        )
        self.spawned.clear()
        self.robots, self.items = {}, {}
        self.items |= self._own_items()
        self._delays = Delays(world, self._chance)
        site = Site(self._env, world, self.admission, lambda: self.robots, self._publisher, self._chance)
        self.fixtures = install_all(site)
        self._docks = {dock.name: dock for dock in self.fixtures.values() if isinstance(dock, DockBays)}
        self.admission.closures.publish()
        self._serve(self._own_robots())
        for _, item in sorted(self.items.items()):
            self._lay(item, item.point)

    def restore(self) -> None:
        """Reset all entities, including those of the world file that were deleted.

        No goal may be running. An entity that was spawned with the name of a deleted one keeps it.
        """
        for fixture in self.fixtures.values():
            fixture.reset()
        for _, robot in sorted(self.robots.items()):
            robot.reset()
        items, robots = self._own_items() | self.items, self._own_robots() | self.robots
        # Robots hold this very dictionary.
        self.items.clear()
        self.items.update(items)
        for _, item in sorted(items.items()):
            self._lay(item, item.home)
        if [*robots.values()] != [*self.robots.values()]:
            self._change(robots)

    def _own_items(self) -> dict[str, Item]:
        """Return the items of the world file in order, and create those that were deleted."""
        return {
            name: self.items.get(name) or Item(name, spec.weight, self._world.point(spec.at), blocks=spec.blocks)
            for name, spec in self._world.items.items()
            if name in self.items or name not in self.spawned
        }

    def _own_robots(self) -> dict[str, Robot]:
        """Likewise its robots; they take bays of docks in the order of names, not in the file's."""
        there = [name for name in self._world.robots if name in self.robots or name not in self.spawned]
        made = {name: self._robot(name, self._world.robots[name]) for name in sorted(there) if name not in self.robots}
        return {name: self.robots.get(name) or made[name] for name in there}

    def abort(self, reason: str, cause: str, robot: str | None = None) -> None:
        """Abort all goals, or those of one robot, for a reason; the robots then stand still."""
        # A process that has not begun can't be interrupted; one that is interrupted leaves its robot in order.
        self._env.take_urgent()
        self._dispatcher.stop(reason, robot, cause=cause)
        self._env.take_urgent()

    def spawn_robot(self, name: str, kind: str, pose: Pose) -> None:
        """Add a robot of a type of the world; the name must be free."""
        robot = self._robot(name, RobotSpec(type=kind, at=pose.point, yaw=pose.yaw))
        self.spawned.add(name)
        self._publisher.publish(lambda: Spawned(name, kind, pose.point))
        self._change({**self.robots, name: robot})

    def spawn_item(self, name: str, weight: float, point: Point) -> None:
        """Add an item; the name must be free."""
        self.items[name] = Item(name, weight, point)
        self.spawned.add(name)
        self._publisher.publish(lambda: Spawned(name, "item", point))

    def delete(self, name: str, why: str = "the robot was deleted") -> None:
        """Delete the entity of a name; a robot puts down the items that it holds."""
        item = self.items.get(name)
        self.spawned.discard(name)
        if name in self.robots:
            self.abort(why, Cause.DELETED, name)
            self._leaving(name)
            self.robots[name].halt()
            self.robots[name].release_all()
            self.robots[name].leave()
            self.admission.remove(self.robots[name])
            self._publisher.publish(lambda: Deleted(name))
            self._change({other: robot for other, robot in self.robots.items() if other != name})
        elif item is not None:
            if item.carrier is not None:
                item.carrier.lose(item)
            del self.items[name]
            self.admission.closures.clear(name)
            self._publisher.publish(lambda: Deleted(name))

    def move(self, entity: Robot | Item, pose: Pose, why: str) -> None:
        """Move a robot or an item to another place at once, after aborting the goal that holds the robot's base."""
        if isinstance(entity, Robot):
            self._env.take_urgent()
            self._dispatcher.free(entity.name, why, Cause.MOVED)
            self._env.take_urgent()
            entity.move_to(pose)
        else:
            if entity.carrier is not None:
                entity.carrier.lose(entity)
            self._lay(entity, pose.point)
        self._publisher.publish(lambda: Teleported(entity.name, pose.point, pose.yaw))

    def publish(self, make: Callable[[], Event]) -> None:
        """Publish an event of a fault's own; it is made only if it is wanted."""
        self._publisher.publish(make)

    @property
    def goals(self) -> GoalFaults:
        """The faults that reject or abort goals."""
        return self._dispatcher.faults

    def connect(self, name: str, *, connected: bool) -> None:
        """Connect a robot to the network, or disconnect it."""
        self._dispatcher.connect(name, connected=connected)

    def delay_news(self, name: str, seconds: float) -> Callable[[], None]:
        """Delay updates about a robot's goals; return a function that ends the delay."""
        return self._dispatcher.updates.delay(name, seconds)

    def _robot(self, name: str, spec: RobotSpec) -> Robot:
        robot = Robot(
            self._env,
            name,
            spec,
            world=self._world,
            graph=self._graph,
            items=self.items,
            docks=self._docks,
            admission=self.admission,
            chance=self._chance,
            delays=self._delays,
            plans=self._plans,
            publisher=self._publisher,
            errors=self._errors,
            abort=self._dispatcher.disable,
        )
        self.admission.place(robot)
        robot.settle_in()
        return robot

    def _lay(self, item: Item, point: Point) -> None:
        """Put an item down somewhere; a bulky one obstructs the lane there, and no other."""
        item.lie_at(point)
        self.admission.closures.clear(item.name)
        if item.blocks:
            self.admission.closures.obstruct(item.name, point, f"{item.name} lies there")

    def _serve(self, robots: dict[str, Robot]) -> None:
        self.robots = robots
        self._dispatcher.serve({**robots, self._gate.name: self._gate})

    def _change(self, robots: dict[str, Robot]) -> None:
        self._serve(robots)
        self._emit(RosterChanged())


_log = logging.getLogger(__name__)


@cache
def installed_actions() -> Mapping[str, AnyAction]:
    """Return all actions by name; log a warning, once, about each whose component does not exist."""
    known = components()
    for action in actions().values():
        if action.component is not None and action.component not in known:
            rest = instead(action.component, known)
            _log.warning("action %r needs the component %r, which no robot has%s", action.name, action.component, rest)
    return actions()
