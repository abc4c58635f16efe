"""A robot: where it is, what it carries, and the verbs that actions are made of."""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.components import registry as components
from hmrsim.components.battery import Battery
from hmrsim.engine.sim_time import stamp
from hmrsim.events.items import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.geometry import SAME_PLACE, Pose
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.robots.power import Energy
from hmrsim.robots.vehicle import Mobile

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Mapping

    from simpy import Event

    from hmrsim.engine.environment import Environment
    from hmrsim.engine.subscriptions import Happenings
    from hmrsim.errors import GoalAborted
    from hmrsim.events import Event as WorldEvent
    from hmrsim.facilities.docks import Berths
    from hmrsim.geometry import Point
    from hmrsim.navigation.external_planner import Plans
    from hmrsim.navigation.graph import WaypointGraph
    from hmrsim.robots.items import Item
    from hmrsim.traffic.admission import Passage
    from hmrsim.world.model import RobotSpec, World

C = TypeVar("C")

_RIGHT = Pose(0.0, 0.0)
"""How far a robot is off that knows where it is."""


class Robot(Mobile):
    """One robot of a world.

    Args:
        env: The simulation's clock and events.
        name: Its name, which is a ROS name.
        spec: What the world file says of it.
        world: The world that it is in.
        graph: The ways open to it.
        items: All items of the world, by name.
        docks: All docks of the world, by name.
        passage: Says what is in its way.
        plans: Asks the planner outside.
        happened: Tells what it does.
        abort: Aborts the goal that holds the base of the robot of a name, and says why.

    Attributes:
        type: Its type's name.
        planner: Who plans its routes.
        plans: Asks the planner outside.
        components: What it carries, by name.
        ailments: Why it can do nothing now, by what ails it, such as ``battery_empty``; empty while it is well.
        misplaced: How far from its pose it believes to be; nothing that it does depends on it, only what it tells.
        docks: All docks of the world, by name.
        dock: Where it is docked; None if nowhere.
        doing: The actions of its goals that run.
        energy: The account of its battery; None if it has none.
    """

    __slots__ = (
        "_abort",
        "_kind",
        "_turn",
        "ailments",
        "components",
        "dock",
        "docks",
        "doing",
        "energy",
        "items",
        "misplaced",
        "planner",
        "plans",
        "type",
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
        docks: Mapping[str, Berths],
        passage: Passage,
        plans: Plans,
        happened: Happenings,
        abort: Callable[[str, str], None],
    ) -> None:
        kind = world.robot_type(spec)
        super().__init__(
            env,
            name,
            kind.base,
            speed=world.speed(kind.base),
            home=Pose(*world.point(spec.at), spec.yaw),
            graph=graph,
            passage=passage,
            happened=happened,
        )
        self.type = spec.type
        self.planner = spec.planner
        self.plans = plans
        self.items = items
        self.units = world.units
        self._kind = kind
        self._abort = abort
        self.ailments: dict[str, str] = {}
        self.misplaced = _RIGHT
        self.components = self._equip()
        self.docks = docks
        self.dock: Berths | None = None
        self.doing: list[str] = []
        self._turn: Event | None = None
        self.energy = self._power_up()
        if docks or self.energy is not None:
            self.changed = self._look

    def _power_up(self) -> Energy | None:
        battery = self.components.get("battery")
        return Energy(self._env, self, battery, self._happened) if isinstance(battery, Battery) else None

    def _look(self) -> None:
        """Take note that it moves, or stands: whoever drives off is docked no longer."""
        if self.dock is not None and self.moves:
            self.dock.let_go(self)
        if self.energy is not None:
            self.energy.look()

    def _equip(self) -> dict[str, Any]:
        return {
            key: components()[key].create(components()[key].settings.model_validate(settings))
            for key, settings in sorted(self._kind.components.items())
        }

    def component(self, kind: type[C]) -> C:
        """Return the component of this type.

        Raises:
            LookupError: The robot has none.
        """
        for component in self.components.values():
            if isinstance(component, kind):
                return component
        raise LookupError(f"{self.name} has no {kind.__name__}")

    @property
    def unfit(self) -> str:
        """Why it can do nothing now; empty while it is well."""
        return next(iter(self.ailments.values()), "")

    def believed(self, pose: Pose) -> Pose:
        """Return where a pose is for the robot, which sees everything from where it believes to be."""
        if self.misplaced == _RIGHT:
            return pose
        here, (dx, dy, turned) = self.pose(), self.misplaced
        x, y = pose.x - here.x, pose.y - here.y
        cos, sin = math.cos(turned), math.sin(turned)
        return Pose(here.x + dx + x * cos - y * sin, here.y + dy + x * sin + y * cos, pose.yaw + turned)

    def pose_stamped(self) -> PoseStamped:
        """Return the pose that it believes to have as a ROS message, in the frame ``map``."""
        return PoseStamped.model_validate(self.stamped(self.believed(self.pose())), strict=False)

    def stamped(self, pose: Pose) -> dict[str, Any]:
        """Return a pose of now as the plain values of a PoseStamped, which are made in a tenth of the time."""
        half = pose.yaw / 2
        return {
            "header": {"stamp": values_of(stamp(self._env.now)), "frame_id": "map"},
            "pose": {
                "position": {"x": pose.x, "y": pose.y, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
            },
        }

    # --- what is done to it ---------------------------------------------------------------------------------------

    def begin_anew(self) -> None:
        """Be as in the beginning; no goal may be running."""
        self.slowness = 1.0
        self.misplaced = _RIGHT
        self.ailments.clear()
        self.retire()
        self.components = self._equip()
        # Where it is before what it has in it: an empty battery says where, and a dock charges the new one.
        super().move_to(self.home)
        self.energy = self._power_up()
        self.settle_in()

    def retire(self) -> None:
        """Take no place in a dock any more, and expect nothing."""
        if self.dock is not None:
            self.dock.let_go(self)
        if self.energy is not None:
            self.energy.stop()

    def fall_ill(self, what: str, why: str) -> None:
        """Be able to do nothing from now on; the goal that holds the base is aborted, and says why.

        Nobody gets past it on the lane where it stands.
        """
        self.ailments[what] = why
        self._abort(self.name, why)
        self.halt()
        self._obstruct()

    def recover(self, what: str) -> None:
        """Be rid of what ailed it; nothing happens if it did not."""
        if self.ailments.pop(what, None) is not None:
            self._obstruct()

    def move_to(self, pose: Pose) -> None:
        """Stand somewhere else at once, in the way there if it can do nothing; no goal may hold the base."""
        if self.dock is not None:
            self.dock.let_go(self)
        super().move_to(pose)
        self.settle_in()

    def settle_in(self) -> None:
        """Be docked if it stands where it can dock, and in the way if it can do nothing."""
        for dock in self.docks.values():
            if dock.has_room_for(self) and self.distance_to(dock.pose.point) <= SAME_PLACE:
                dock.take_in(self)
                break
        self._obstruct()

    def _obstruct(self) -> None:
        """Be in the way where it is if it can't get out of it, and nowhere else."""
        self._passage.closures.clear(self.name)
        if self.unfit and not self.flies:
            self._passage.closures.obstruct(self.name, self.pose().point, self.unfit)

    def let_go(self) -> None:
        """Lay down whatever its components hold where it is."""
        for item in self.held:
            self.lose(item)
            self.put(item, self.pose().point)

    @property
    def load(self) -> float:
        """What it carries, in kg."""
        return math.fsum(item.weight for item in self.items.values() if item.carrier is self)

    @property
    def held(self) -> list[Item]:
        """The items that it carries, in order of name."""
        return sorted((item for item in self.items.values() if item.carrier is self), key=lambda item: item.name)

    def lose(self, item: Item) -> None:
        """Hold an item no longer, whichever component did."""
        for component in self.components.values():
            if getattr(component, "item", None) is item:
                component.item = None
        item.detach()
        if self.energy is not None:
            self.energy.carry(handled=False)

    # --- what it does ---------------------------------------------------------------------------------------------

    def hold(self, seconds: float) -> Generator[Any, Any, None]:
        """Stand still for a while."""
        self.halt()
        over = self._env.timeout(seconds)
        self.busy = True
        try:
            yield over
        except BaseException:
            self._env.abandon(over)
            raise
        finally:
            self.busy = False
            self._passage.may_make_room(self)

    def wait_for(self, turn: Event) -> Generator[Any, Any, None]:
        """Do nothing until it is its turn.

        Raises:
            GoalAborted: That takes longer than it may; see `within`.
        """
        self._turn = turn
        try:
            yield turn
        finally:
            self._turn = None

    @contextmanager
    def within(self, seconds: float, why: GoalAborted) -> Iterator[None]:
        """Give up driving, or waiting for its turn, if that takes longer; 0 is any time."""

        def give_up(_event: Event) -> None:
            if self._turn is None:
                self.give_up(why)
            elif not self._turn.triggered:
                self._turn.fail(why)
                # Somebody else may end its goal at this instant.
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
    def may_make_room(self) -> bool:
        """Whether it stands, and could go somewhere else for a while: it is well, and in no dock."""
        return not self.unfit and self.dock is None and super().may_make_room

    def act(self, action: str, *, begins: bool) -> None:
        """Take note that a goal of an action begins, or ends."""
        if begins:
            self.doing.append(action)
        else:
            self.doing.remove(action)
        if self.energy is not None:
            self.energy.act()

    def publish(self, make: Callable[[], WorldEvent]) -> None:
        """Publish an event of an action's own; it is made only if it is wanted."""
        self._happened.publish(make)

    def pick(self, item: Item) -> None:
        """Take an item, which moves with the robot from now on."""
        item.attach_to(self)
        if self.energy is not None:
            self.energy.carry(handled=True)
        self._passage.closures.clear(item.name)
        self._happened.publish(lambda: ItemPicked(self.name, item.name))

    def put(self, item: Item, point: Point) -> None:
        """Lay the item down at *point*."""
        self._lay(item, point)
        if self.energy is not None:
            self.energy.carry(handled=True)
        self._happened.publish(lambda: ItemPlaced(self.name, item.name, point))

    def drop(self, item: Item) -> None:
        """Let an item fall where it is; nobody gets past it on a lane, however small it is."""
        point = self.pose().point
        self.lose(item)
        self._lay(item, point)
        self._passage.closures.obstruct(item.name, point, f"{item.name} has fallen there")
        self._happened.publish(lambda: ItemDropped(self.name, item.name, point))

    def _lay(self, item: Item, point: Point) -> None:
        item.lie_at(point)
        if item.blocks:
            self._passage.closures.obstruct(item.name, point, f"{item.name} lies there")
