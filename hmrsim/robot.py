"""A robot: where it is, what it carries, and the verbs that actions are made of."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeVar

from simpy import Event, Timeout
from simpy.events import NORMAL

from hmrsim.components import registry as components
from hmrsim.geometry import Pose, distance
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.motion import Progress, drive
from hmrsim.sim_time import stamp

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence

    from hmrsim.environment import Environment
    from hmrsim.geometry import Point
    from hmrsim.graph import WaypointGraph
    from hmrsim.interest import Happenings
    from hmrsim.items import Item
    from hmrsim.motion import Drive, Piece
    from hmrsim.route import Route
    from hmrsim.world.model import RobotSpec, World

C = TypeVar("C")


class Robot:
    """One robot of a world.

    Args:
        env: The simulation's clock and events.
        name: Its name, which is a ROS name.
        spec: What the world file says of it.
        world: The world that it is in.
        graph: The ways open to it.
        items: All items of the world, by name.
        happened: Tells what it does.
    """

    def __init__(
        self,
        env: Environment,
        name: str,
        spec: RobotSpec,
        world: World,
        graph: WaypointGraph,
        items: Mapping[str, Item],
        happened: Happenings,
    ) -> None:
        kind = world.robot_type(spec)
        self.name = name
        self.type = spec.type
        self.planner = spec.planner
        self.items = items
        self.units = world.units
        self._env = env
        self._graph = graph
        self._happened = happened
        self._kind = kind
        self._base = kind.base
        self.speed = world.speed(kind.base)
        self._home = Pose(*world.point(spec.at), spec.yaw)
        self._rest = self._home
        self._drive: Drive | None = None
        self.components = self._equip()
        self._number = 0
        self._seconds: Sequence[float] = ()
        self._piece_ends: Timeout | None = None
        self._arrived: Event | None = None
        self._on_piece_end: list[Callable[[Any], None]] = []
        self._began = 0.0

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self._env.now

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

    # --- where it is ----------------------------------------------------------------------------------------------

    def progress(self) -> Progress:
        """Return where it is now, and how far it still has to go; nothing is left when it stands."""
        if self._drive is None:
            return Progress(self._rest)
        return self._drive.progress(self._number, self._env.now - self._began)

    def pose(self) -> Pose:
        """Return where its centre is now and which way it faces."""
        return self.progress().pose

    @property
    def _piece(self) -> Piece | None:
        """What it is driving just now; None when it stands."""
        return self._drive.piece(self._number) if self._drive else None

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

    def velocity(self) -> tuple[float, float]:
        """Return the speed ahead and the turning rate, now; of a constant-speed piece, or its mean."""
        piece = self._piece
        if piece is None:
            return 0.0, 0.0
        if piece.leg is None:
            turned = piece.end.yaw - piece.start.yaw
            return 0.0, turned / piece.duration
        return piece.length / piece.duration, 0.0

    @property
    def distance_remaining(self) -> float:
        """What is left of the route that it drives; 0 when it stands."""
        return self.progress().length

    def distance_to(self, point: Point) -> float:
        """Return how far its centre is from *point*."""
        return distance(self.pose().point, point)

    # --- what is done to it ---------------------------------------------------------------------------------------

    def begin_anew(self) -> None:
        """Be as in the beginning; no goal may be running."""
        self._rest, self.components = self._home, self._equip()

    def move_to(self, pose: Pose) -> None:
        """Stand somewhere else at once; no goal that holds the base may be running."""
        self._rest = pose

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

    def plan_to(self, goal: Point) -> Route:
        """Return the quickest route from where it is.

        Raises:
            NoRoute: The goal is outside the map, inside an obstacle, or no way leads there.
        """
        return self._graph.plan(self.pose().point, goal, self.speed)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the way from where it is straight from point to point, and what stands in it; or ""."""
        return self._graph.straight_through([self.pose().point, *points])

    def drive(self, route: Route, final_yaw: float | None) -> Generator[Any, Any, None]:
        """Drive a route that begins here, then face *final_yaw*, if any; an interrupt stops it where it is."""
        driven = self._drive = drive(
            self.pose(),
            route.legs,
            final_yaw,
            speed=self.speed,
            acceleration=self._base.acceleration,
            turning_rate=self._base.turning_rate,
        )
        if driven.seconds:
            try:
                yield self._set_out(driven)
            except BaseException:
                self._rest = self.pose()
                if self._piece_ends is not None:
                    self._env.abandon(self._piece_ends)
                self._drive = self._piece_ends = None
                self._happened("stopped", lambda: {"robot": self.name, "at": [*self._rest.point]})
                raise
            self._rest = driven.piece(-1).end
        self._drive = None
        if final_yaw is not None:
            self._rest = Pose(*self._rest.point, final_yaw)

    def _set_out(self, driven: Drive) -> Event:
        """Begin the first piece of a drive; return what happens at the end of the last.

        One timeout is scheduled anew for each piece, past the process that drives: with many robots that is half
        the work of the whole simulation.
        """
        self._seconds = driven.seconds
        arrived = self._arrived = Event(self._env)
        self._piece_ends = Timeout(self._env, driven.seconds[0])
        self._on_piece_end = self._on_piece_end or [self._begin_next]
        self._piece_ends.callbacks = self._on_piece_end
        self._number, self._began = 0, self._env.now
        self._happened.moved(self._motion)
        return arrived

    def _begin_next(self, piece_end: Event) -> None:
        if piece_end is not self._piece_ends or self._arrived is None:
            # The robot was stopped on that way.
            return
        number = self._number + 1
        if number == len(self._seconds):
            self._arrived.succeed()
            return
        self._number, self._began = number, self._env.now
        if self._happened.interest.motion:
            self._happened.moved(self._motion)
        piece_end.callbacks = self._on_piece_end
        self._env.schedule(piece_end, NORMAL, self._seconds[number])

    def _motion(self) -> dict[str, Any]:
        """Return the piece that is being driven, as an observer sees it."""
        piece = self._piece
        return {"robot": self.name, **(piece.describe() if piece else {})}

    def hold(self, seconds: float) -> Generator[Any, Any, None]:
        """Stand still for a while."""
        over = self._env.timeout(seconds)
        try:
            yield over
        except BaseException:
            self._env.abandon(over)
            raise

    def pick(self, item: Item) -> None:
        """Take an item, which moves with the robot from now on."""
        item.carrier = self
        self._happened("picked", lambda: {"robot": self.name, "item": item.name})

    def put(self, item: Item, point: Point) -> None:
        """Lay the item down at *point*."""
        item.carrier = None
        item.point = point
        self._happened("placed", lambda: {"robot": self.name, "item": item.name, "at": [*point]})
