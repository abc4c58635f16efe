"""The interface of `hmrsim.traffic.admission` for traffic policies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.errors import GoalAborted
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.blockers import Blocker
    from hmrsim.traffic.policies._vehicle import Vehicle, Wait
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

    def kept_off(self, robot: Vehicle) -> Sequence[Lane]:
        """Return the lanes that a vehicle can never pass, such as those with a door that is not for it."""

    @property
    def all_open(self) -> bool:
        """Return whether all lanes are open and without barriers."""

    def may_drive(self, robot: Vehicle, lane: Lane) -> bool:
        """Return whether a vehicle can be moved along a lane: it is not closed, and what is on it opens for it."""

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
