"""A robot: a mobile base with components, and the operations that actions consist of."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Final, TypeVar

from hmrsim.caches import LruCache
from hmrsim.components import Settings
from hmrsim.components import registry as components
from hmrsim.components.battery import Battery
from hmrsim.diagnostics import listed
from hmrsim.engine.internal_errors import BUGS
from hmrsim.engine.sim_time import stamp
from hmrsim.errors import GoalAborted
from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.geometry import SAME_PLACE, Pose
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.protocol.goal import Cause, GoalStatus
from hmrsim.robots.mobile_base import MobileBase
from hmrsim.robots.power import EMPTY, Energy, Level

if TYPE_CHECKING:
    from simpy import Event

    from hmrsim.distributions import RandomValue
    from hmrsim.engine.chance import Chance
    from hmrsim.engine.environment import Environment
    from hmrsim.engine.internal_errors import InternalErrors
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.events import Event as WorldEvent
    from hmrsim.geometry import Point
    from hmrsim.items import Item
    from hmrsim.navigation.external_planner import Plans
    from hmrsim.navigation.graph import WaypointGraph
    from hmrsim.navigation.route import Delays
    from hmrsim.robots.docking import DockBay
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.rules import Activity
    from hmrsim.world.model import RobotSpec, World

C = TypeVar("C")

_SETTINGS: Final = LruCache[tuple[type[Settings], str], Settings](256)
"""Recently validated settings of components, by their text: robots of one type share them, across runs."""

_NO_ERROR = Pose(0.0, 0.0)
"""The localization error of a robot that knows where it is."""


class Robot(MobileBase):
    """One robot of a world.

    Args:
        name: The name of the robot, a valid ROS name.
        errors: Handles exceptions that its components raise because of a bug.
        abort: Aborts the goal that holds the base, given the robot's name, a reason and a cause.

    Attributes:
        localization_error: The error of its estimated pose, which affects only what the robot reports.
        doing: The actions of its active goals.
    """

    __slots__ = (
        "_abort",
        "_chance",
        "_errors",
        "_kind",
        "_last_goal",
        "_turn",
        "components",
        "dock",
        "docks",
        "doing",
        "energy",
        "items",
        "localization_error",
        "planner",
        "plans",
        "tags",
        "units",
    )

    def __init__(  # noqa: PLR0913 - each is a part of its world
        self,
        env: Environment,
        name: str,
        spec: RobotSpec,
        *,
        world: World,
        graph: WaypointGraph,
        items: Mapping[str, Item],
        docks: Mapping[str, DockBay],
        admission: Admission,
        chance: Chance,
        delays: Delays,
        plans: Plans,
        publisher: EventPublisher,
        errors: InternalErrors,
        abort: Callable[[str, str, str], None],
    ) -> None:
        kind = world.robot_type(spec)
        super().__init__(
            env,
            name,
            kind.base,
            robot_type=spec.type,
            speed=world.speed(kind.base),
            home=Pose(*world.point(spec.at), spec.yaw),
            graph=graph,
            admission=admission,
            delays=delays,
            publisher=publisher,
            moved=self._follow_motion if docks or "battery" in kind.components else None,
        )
        self.planner = spec.planner
        self.tags = spec.tags
        self._chance = chance
        self.plans = plans
        self.items = items
        self.units = world.units
        self._kind = kind
        self._abort = abort
        self._errors = errors
        self.localization_error = _NO_ERROR
        self.components = self._equip()
        self.docks = docks
        self.dock: DockBay | None = None
        self.doing: list[str] = []
        self._last_goal: tuple[str, GoalStatus, float] | None = None
        self._turn: Event | None = None
        self.energy = self._power_up()

    def _power_up(self) -> Energy | None:
        """Return the energy of its battery, if it has one; an empty battery disables the robot."""
        battery = self.components.get("battery")
        if not isinstance(battery, Battery):
            return None
        energy = Energy(self._env, self, battery, self._publisher)
        self._follows_speed = bool(battery.settings.drain.distance)
        if energy.level is Level.EMPTY:
            super().disable(EMPTY, energy.why_empty)
        return energy

    def _follow_motion(self) -> None:
        """Leave the dock if it moves, and account for the energy of the motion."""
        if self.dock is not None and self._state.moves:
            self.dock.release(self)
        if self.energy is not None:
            self.energy.look(moves=self._state.moves)

    def _equip(self) -> dict[str, Any]:
        """Return new components, without any that can't be created because of a bug."""
        made = {}
        for key, settings in sorted(self._kind.components.items()):
            kind = components()[key]
            try:
                checked = partial(kind.settings.model_validate, settings)
                made[key] = kind.create(_SETTINGS.get((kind.settings, repr(settings)), checked))
            except BUGS as bug:
                self._errors.handle(f"component {key}", bug, self.name)
        return made

    def component(self, kind: type[C]) -> C:
        """Return the component of a type.

        Raises:
            LookupError: The robot has no such component.
        """
        for component in self.components.values():
            if isinstance(component, kind):
                return component
        raise LookupError(f"{self.name} has no {kind.__name__}")

    def set_localization_error(self, error: Pose) -> None:
        """Set the error of its estimated pose."""
        self.localization_error = error

    def estimated(self, pose: Pose) -> Pose:
        """Return the robot's estimate of a pose, which has the same error as the estimate of its own pose."""
        if self.localization_error == _NO_ERROR:
            return pose
        here, (dx, dy, turned) = self.pose(), self.localization_error
        x, y = pose.x - here.x, pose.y - here.y
        cos, sin = math.cos(turned), math.sin(turned)
        return Pose(here.x + dx + x * cos - y * sin, here.y + dy + x * sin + y * cos, pose.yaw + turned)

    def pose_stamped(self) -> PoseStamped:
        """Return its estimated pose as a message, in the frame ``map``."""
        return PoseStamped.model_validate(self.stamped(self.estimated(self.pose())), strict=False)

    def stamped(self, pose: Pose) -> dict[str, Any]:
        """Return a pose with the current time as plain values of a PoseStamped, ten times as fast as the message."""
        half = pose.yaw / 2
        return {
            "header": {"stamp": values_of(stamp(self._env.now)), "frame_id": "map"},
            "pose": {
                "position": {"x": pose.x, "y": pose.y, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
            },
        }

    def reset(self) -> None:
        """Restore the initial state, after the docks were reset; no goal may be running."""
        self.speed_scale = 1.0
        self.localization_error = _NO_ERROR
        for cause in [*self.disabled_reasons]:
            super().enable(cause)
        self.dock = self._last_goal = None
        self.retire()
        self._trip = 0
        self.components = self._equip()
        # Place it first: the report of an empty battery says where it is, and a dock charges the new battery.
        super().move_to(self.home)
        self.energy = self._power_up()
        self.settle_in()

    def retire(self) -> None:
        """Leave the dock, and cancel the alarms of the battery."""
        if self.dock is not None:
            self.dock.release(self)
        if self.energy is not None:
            self.energy.stop()

    def leave(self) -> None:
        """Leave the simulation."""
        self.retire()
        self.stop_lingering()
        self.motion.detach()

    def disable(self, cause: str, why: str) -> None:
        """Stop it, and keep it from acting until this and all other causes have ended.

        The goal that holds the base is aborted with the reason, unless its action survives that. The robot obstructs
        the lane on which it stands.
        """
        self.disabled_reasons[cause] = why
        self._abort(self.name, why, cause)
        super().disable(cause, why)
        self._obstruct()

    def enable(self, cause: str) -> None:
        """End a cause for which it is disabled, if it is."""
        if cause in self.disabled_reasons:
            super().enable(cause)
            self._obstruct()

    def move_to(self, pose: Pose) -> None:
        """Place it at a pose at once, where it obstructs the lane if it is disabled; no goal may hold the base."""
        if self.dock is not None:
            self.dock.release(self)
        super().move_to(pose)
        self.settle_in()

    def settle_in(self) -> None:
        """Dock if it stands at a dock with room, and obstruct the lane if it is disabled."""
        here = self.pose().point
        for dock in self.docks.values():
            if dock.away(here) <= SAME_PLACE and dock.has_room_for(self):
                dock.take_in(self)
                break
        self._obstruct()

    def _obstruct(self) -> None:
        """Obstruct the lane on which it stands if it is disabled, and no other lane."""
        self._admission.closures.clear(self.name)
        if self.disabled and not self.flies:
            self._admission.closures.obstruct(self.name, self.pose().point, self.disabled)

    def enter_dock(self, dock: DockBay) -> None:
        """Record that it is docked; it charges if the dock is a charger."""
        self.dock = dock
        self.dock_changed()

    def leave_dock(self) -> None:
        """Record that it has left its dock."""
        self.dock = None
        self.dock_changed()

    def dock_changed(self) -> None:
        """Start or stop charging, as its dock requires."""
        if self.energy is not None:
            self.energy.switch()

    def release_all(self) -> None:
        """Put all held items down at its position."""
        for item in self.held:
            self.lose(item)
            self.put(item, self.pose().point)

    @property
    def load(self) -> float:
        """The total weight of the items that it carries, in kg."""
        return math.fsum(item.weight for item in self.items.values() if item.carrier is self)

    @property
    def held(self) -> list[Item]:
        """The items that it carries, sorted by name."""
        return sorted((item for item in self.items.values() if item.carrier is self), key=lambda item: item.name)

    def lose(self, item: Item) -> None:
        """Detach an item from the component that holds it."""
        for component in self.components.values():
            if getattr(component, "item", None) is item:
                component.item = None
        item.detach()
        if self.energy is not None:
            self.energy.carry(handled=False)

    def draw(self, value: RandomValue, use: str) -> float:
        """Draw a value for the next occurrence of a *use*, such as an action; a plain number stands for itself."""
        return self._chance.draw(value, self.name, use)

    def hold(self, seconds: float) -> Generator[Any, Any, None]:
        """Stand still for a while."""
        self.begin_work()
        over = self._env.timeout(seconds)
        try:
            yield over
        except BaseException:
            self._env.abandon(over)
            raise
        finally:
            self.finish_work()

    def wait_for(self, turn: Event) -> Generator[Any, Any, None]:
        """Wait for an event, such as a bay that becomes free.

        Raises:
            GoalAborted: The event takes too long; see `within`.
        """
        self._turn = turn
        try:
            yield turn
        finally:
            self._turn = None

    @property
    def why_held_up(self) -> str:
        """The obstacle that holds the robot up, such as the queue of a dock; empty if there is none."""
        causes = self._admission.causes
        return causes.link(self).text if causes.is_held_up(self) else ""

    @contextmanager
    def within(self, seconds: float, late: GoalAborted) -> Iterator[None]:
        """Limit the time for driving, or for waiting for an event, to some simulated seconds; 0 is no limit.

        After that, the goal fails with the error *late*, to which the causes of the delay are added.
        """

        def give_up(_event: Event) -> None:
            causes = self._admission.causes
            told = f"{late}: {causes.chain(self)}" if causes.is_held_up(self) else str(late)
            why = GoalAborted(late.code, told, late.cause)
            if self._turn is None:
                self.give_up(why)
            elif not self._turn.triggered:
                self._turn.fail(why)
                # Its goal may end for another reason at this instant.
                self._turn.defused = True

        if seconds <= 0.0:
            yield
            return
        over = self._env.timeout(seconds)
        over.callbacks = [give_up]
        try:
            yield
        finally:
            if not over.processed:
                self._env.abandon(over)

    @property
    def may_yield(self) -> bool:
        """Return whether the robot stands and can make room; in a dock, only if it waits to leave."""
        return (self.dock is None or self.waits) and super().may_yield

    @property
    def will_yield(self) -> bool:
        """Return whether the robot can make room, now or soon; in a dock, only if it waits to leave."""
        return (self.dock is None or not self.stands) and super().will_yield

    @property
    def activity(self) -> tuple[Activity, str, str]:
        """The robot's activity, a phrase for it such as ``is idle``, and details, which may be empty."""
        activity = super().activity
        if activity[0] != "idle":
            return activity
        executes = f"executes {listed(self.doing)}"
        if self.dock is not None:
            charging = self.energy is not None and self.energy.battery.charging
            verb = f"is {'charging' if charging else 'docked'} in {self.dock.name!r}"
            return "docked", verb, f"it {executes}" if self.doing else self._since_last_goal
        return ("works", executes, "") if self.doing else ("idle", "is idle", self._since_last_goal)

    @property
    def last_goal_succeeded(self) -> bool:
        """Return whether its last goal succeeded, so that its client relies on the robot's position at that time."""
        return self._last_goal is not None and self._last_goal[1] is GoalStatus.SUCCEEDED

    @property
    def _since_last_goal(self) -> str:
        """The end of its last goal, in words."""
        if self._last_goal is None:
            return "it has had no goal yet"
        action, status, at = self._last_goal
        if self._trips_in_place > 1 and status is GoalStatus.SUCCEEDED:
            times = f"{self._trips_in_place} times in a row"
            return f"it was sent to where it already stands {times}, and {action} {status.name} at {at:g} s"
        return f"it has had no goal since {action} {status.name} at {at:g} s"

    def act(
        self, action: str, ended: GoalStatus | None = None, *, holds: bool = True, in_real_time: bool = False
    ) -> None:
        """Record that a goal of an action begins, or, with a status, that it has *ended*.

        A goal that *holds* no component, such as one that computes a path, does not count as the last goal. After any
        other goal from a client *in_real_time*, the robot lingers where it is, so that its next goal can arrive.
        """
        if ended is None:
            self.doing.append(action)
            if holds:
                self._lingers = in_real_time
        else:
            self.doing.remove(action)
            if holds:
                self._last_goal = action, ended, self.now
        if self.energy is not None:
            self.energy.act()

    def out_of_place(self, code: int, text: str, cause: str = Cause.FAILED) -> GoalAborted:
        """Return the error of a goal that fails at the robot's position, with a note if traffic has moved it there."""
        if not (aside := self.moved_aside):
            return GoalAborted(code, text, cause)
        return GoalAborted(code, f"{text}; {aside}", Cause.MOVED)

    def publish(self, make: Callable[[], WorldEvent]) -> None:
        """Publish an event of an action; it is created only if there is a subscriber."""
        self._publisher.publish(make)

    def pick(self, item: Item) -> None:
        """Take an item, which then moves with the robot."""
        item.attach_to(self)
        if self.energy is not None:
            self.energy.carry(handled=True)
        self._admission.closures.clear(item.name)
        self._publisher.publish(lambda: ItemPicked(self.name, item.name))

    def put(self, item: Item, point: Point) -> None:
        """Lay an item down at a point."""
        self._lay(item, point)
        if self.energy is not None:
            self.energy.carry(handled=True)
        self._publisher.publish(lambda: ItemPlaced(self.name, item.name, point))

    def drop(self, item: Item) -> None:
        """Drop an item at the robot's position, where it obstructs the lane, however small it is."""
        point = self.pose().point
        self.lose(item)
        self._lay(item, point)
        self._admission.closures.obstruct(item.name, point, f"{item.name} has fallen there")
        self._publisher.publish(lambda: ItemDropped(self.name, item.name, point))

    def _lay(self, item: Item, point: Point) -> None:
        item.lie_at(point)
        if item.blocks:
            self._admission.closures.obstruct(item.name, point, f"{item.name} lies there")
