"""The interfaces that traffic policies use: `hmrsim.traffic.admission`, its vehicles and their waits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Final, Protocol

if TYPE_CHECKING:
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.errors import GoalAborted
    from hmrsim.events.traffic import Waiting
    from hmrsim.geometry import Point, Pose
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.motion import Piece
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.blockers import Blocker
    from hmrsim.world.model import World


class AdmissionControl(Protocol):
    """The lanes of one world, and the vehicles that wait for them."""

    @property
    def world(self) -> World:
        """The world in which the vehicles drive."""

    @property
    def graph(self) -> WaypointGraph:
        """The graph of the world's lanes."""

    @property
    def publisher(self) -> EventPublisher:
        """The publisher of events about traffic."""

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""

    @property
    def waits(self) -> Mapping[Vehicle, Wait]:
        """The vehicles that wait, in the order in which they began to."""

    @property
    def asking(self) -> Iterable[Vehicle]:
        """The vehicles that are about to ask again at this instant, in order."""

    def plan(self, robot: Vehicle, start: Point, goal: Point) -> Route:
        """Return the quickest route for a vehicle, without lanes that it can never pass.

        Raises:
            NoRoute: No way leads there.
        """

    def kept_off(self, robot: Vehicle) -> Collection[Lane]:
        """Return the lanes that a vehicle can never pass, such as those with a door that is not for it."""

    def shut_to(self, robot: Vehicle) -> Collection[Lane]:
        """Return the lanes along which a vehicle can't be moved: closed ones, and those that it can never pass."""

    def lets(self, robot: Vehicle, legs: Sequence[Leg]) -> bool:
        """Return whether only traffic can be in a vehicle's way on legs now; if not, what is there begins to open.

        All vehicles that wait ask again when it is open.
        """

    def blockers(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles for which one waits; none if it does not wait, or waits for something else."""

    def explain_blockers(self, robots: Sequence[Vehicle], waiting: Vehicle) -> Sequence[Blocker]:
        """Return descriptions of the vehicles for which another one waits."""

    def is_held_up(self, robot: Vehicle) -> bool:
        """Return whether a vehicle can't go on because of others."""

    def waits_for_barrier(self, robot: Vehicle) -> bool:
        """Return whether a vehicle waits for a door or a lift that will let it pass."""

    def soon(self, call: Callable[[], None]) -> None:
        """Call a function at this instant but after what happens now."""

    def look_again(self, robots: Sequence[Vehicle]) -> None:
        """Make waiting vehicles request their legs again, at the end of this instant."""

    def look_again_at(self, robot: Vehicle, at: float) -> None:
        """Make a vehicle request again at a simulated time, in seconds, if it still waits for the same leg then."""

    def try_again(self, robot: Vehicle) -> None:
        """Make a vehicle that waits or has yielded request again, at this instant."""

    def release(self, robot: Vehicle) -> None:
        """Resume a waiting vehicle that now holds the slots of its leg."""

    def push(self, robot: Vehicle, legs: Sequence[Leg], by: Vehicle, *, rerouted: bool = False) -> None:
        """Make a vehicle yield to another by driving legs whose slots it already holds."""

    def abort(self, robot: Vehicle, why: GoalAborted) -> None:
        """Abort the motion of a waiting vehicle; its next motion starts a new wait."""


by_rank: Final = attrgetter("rank")
"""The key by which vehicles are ordered."""


class Vehicle(Protocol):
    """A robot as those see it that admit it to lanes, open for it, or carry it."""

    @property
    def name(self) -> str:
        """Its name, which is unique."""

    @property
    def type(self) -> str:
        """The name of its robot type."""

    @property
    def radius(self) -> float:
        """Of its footprint; 0 if it has none."""

    @property
    def flies(self) -> bool:
        """Return whether the vehicle flies, so that nothing on the ground blocks it."""

    @property
    def speed(self) -> float:
        """The maximum speed that it can go now, in the world's unit a second."""

    @property
    def rank(self) -> tuple[float, str]:
        """By what vehicles are ordered: by when they set out, those that go nowhere last."""

    @property
    def rerouted(self) -> int:
        """The number of reroutes on the current trip."""

    @property
    def stands(self) -> bool:
        """Return whether the vehicle stands and has nowhere to go."""

    @property
    def moves(self) -> bool:
        """Return whether the vehicle is moving."""

    @property
    def waits(self) -> bool:
        """Return whether the vehicle is blocked on its route."""

    @property
    def sets_out(self) -> bool:
        """Return whether the vehicle begins a lane or a turn at this very instant."""

    @property
    def busy(self) -> bool:
        """Return whether the current goal requires the vehicle to stand still."""

    @property
    def may_yield(self) -> bool:
        """Return whether the vehicle stands and can make room for others."""

    @property
    def will_yield(self) -> bool:
        """Return whether the vehicle can make room, now or once it stands or has finished its work."""

    def pose(self) -> Pose:
        """Return the position of its center and its yaw, now."""

    def distance_to(self, point: Point) -> float:
        """Return how far its center is from *point*."""

    @property
    def activity(self) -> str:
        """A description of the state, such as ``idle``."""

    @property
    def still_since(self) -> float:
        """When it last ceased to make progress, in simulated seconds; infinite while it moves or works."""

    @property
    def goal(self) -> Point | None:
        """The point to which any route may lead; None if it goes nowhere, or its path is given point by point."""

    @property
    def piece(self) -> Piece | None:
        """The lane or the turn that it drives now; None when it stands, or waits."""

    @property
    def next_leg(self) -> Leg | None:
        """The leg that it drives now, or waits for; None when it stands, or turns."""

    @property
    def legs_ahead(self) -> list[Leg]:
        """The legs that it has not driven to their ends; none when it stands."""

    def look_ahead(self) -> None:
        """Ask again before each lane on its way that may be closed by now."""

    def go_on(self) -> None:
        """Drive the leg for which it waits: it is admitted now."""

    def ask_again(self) -> None:
        """Ask for the right of way again if it waits, and drive on or keep waiting."""

    def step_back(self) -> None:
        """Lose the right of way at the instant at which it sets out, and wait."""

    def reroute(self, avoid: Collection[Lane]) -> bool:
        """Take another route from where it waits, without these lanes; return whether there is one."""

    def take_route(self, route: Route) -> None:
        """Take a route from where it waits; it asks for the right of way again."""

    def yield_along(self, legs: Sequence[Leg], *, rerouted: bool = False) -> None:
        """Yield to another vehicle by driving legs, to which it is admitted already; it may count as another route."""

    def give_up(self, why: GoalAborted) -> None:
        """Stop on its way, and fail the drive."""


@dataclass(eq=False)
class Wait:
    """A vehicle that waits for the right of way.

    Attributes:
        leg: The leg that it is to drive.
        since: When it began to wait, in simulated seconds.
        why: The obstacle, in words; empty where other vehicles block it.
        told: The event that was published of it last, if any.
        asks: Whether it is to ask again at a time, as a search for a way out was put off.
    """

    robot: Vehicle
    leg: Leg
    since: float
    why: str = ""
    told: Waiting | None = None
    asks: bool = False
