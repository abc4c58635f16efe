"""A robot: where it is, what it carries, and the verbs that actions are made of."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.components import registry as components
from hmrsim.geometry import Pose
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.mobile import Mobile
from hmrsim.sim_time import stamp

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping

    from hmrsim.environment import Environment
    from hmrsim.geometry import Point
    from hmrsim.graph import WaypointGraph
    from hmrsim.interest import Happenings
    from hmrsim.items import Item
    from hmrsim.passage import Passage
    from hmrsim.world.model import RobotSpec, World

C = TypeVar("C")


class Robot(Mobile):
    """One robot of a world.

    Args:
        env: The simulation's clock and events.
        name: Its name, which is a ROS name.
        spec: What the world file says of it.
        world: The world that it is in.
        graph: The ways open to it.
        items: All items of the world, by name.
        passage: Says what is in its way.
        happened: Tells what it does.
        abort: Aborts the goal that holds the base of the robot of a name, and says why.

    Attributes:
        type: Its type's name.
        planner: Who plans its routes.
        components: What it carries, by name.
        ailments: Why it can do nothing now, by what ails it, such as ``battery``; empty while it is well.
    """

    def __init__(  # noqa: PLR0913 - each is a part of its world
        self,
        env: Environment,
        name: str,
        spec: RobotSpec,
        *,
        world: World,
        graph: WaypointGraph,
        items: Mapping[str, Item],
        passage: Passage,
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
        self.items = items
        self.units = world.units
        self._kind = kind
        self._abort = abort
        self.ailments: dict[str, str] = {}
        self.components = self._equip()

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

    def pose_stamped(self) -> PoseStamped:
        """Return the pose as a ROS message, in the frame ``map``."""
        return PoseStamped.model_validate(self.stamped(self.pose()), strict=False)

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
        self.ailments.clear()
        self.components = self._equip()
        self.move_to(self.home)

    def fall_ill(self, what: str, why: str) -> None:
        """Be able to do nothing from now on; the goal that holds the base is aborted, and says why."""
        self.ailments[what] = why
        self._abort(self.name, why)
        self.halt()

    def recover(self, what: str) -> None:
        """Be rid of what ailed it; nothing happens if it did not."""
        self.ailments.pop(what, None)

    def let_go(self) -> None:
        """Lay down whatever its components hold where it is."""
        held = [item for item in self.items.values() if item.carrier is self]
        for item in sorted(held, key=lambda item: item.name):
            self.lose(item)
            self.put(item, self.pose().point)

    def lose(self, item: Item) -> None:
        """Hold an item no longer, whichever component did."""
        for component in self.components.values():
            if getattr(component, "item", None) is item:
                component.item = None

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

    def pick(self, item: Item) -> None:
        """Take an item, which moves with the robot from now on."""
        item.carrier = self
        self._happened("picked", lambda: {"robot": self.name, "item": item.name})

    def put(self, item: Item, point: Point) -> None:
        """Lay the item down at *point*."""
        item.carrier = None
        item.point = point
        self._happened("placed", lambda: {"robot": self.name, "item": item.name, "at": [*point]})
