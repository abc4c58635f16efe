"""The setting of an environment: the world, robots, chargers and limits that all episodes share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, Self

from hmrsim.diagnostics import listed
from hmrsim.errors import NoRoute
from hmrsim.geometry import distance
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.simulation.simulator import Simulator
from hmrsim.trials.model import AnyWorld, read_world

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

CHARGED: Final = 0.8
"""The charge at which a robot leaves its charger, as a share."""

SEEDS: Final = 2**31
"""The upper bound of the seeds that an environment chooses itself."""

_NEEDED: Final = frozenset({"navigate_to_pose", "pickup", "place"})


@dataclass(frozen=True)
class Charger:
    """A dock that charges robots.

    Attributes:
        capacity: The number of robots that can use it at the same time.
    """

    at: Point
    capacity: int


@dataclass(frozen=True)
class Setting:
    """The world, the robots that serve its orders, and the limits of an episode.

    Attributes:
        robots: The robots that serve orders, in the world's order.
        chargers: The docks where each of these robots may charge.
        routes: Travel times in the world.
        horizon: Simulated seconds.
        orders: The maximum number of orders that a robot can choose from.
        charge_below: The share of its battery below which an idle robot goes to a charger.
    """

    world: World
    robots: tuple[str, ...]
    chargers: Mapping[str, Mapping[str, Charger]]
    routes: Routes
    horizon: float
    orders: int
    charge_below: float

    @classmethod
    def of(
        cls,
        world: AnyWorld,
        *,
        changes: Mapping[str, Any] | None = None,
        robots: Sequence[str] | None = None,
        horizon: float = 1800.0,
        orders: int = 8,
        charge_below: float = 0.25,
    ) -> Self:
        """Return a setting; the arguments are those of `DispatchEnv`.

        Raises:
            WorldError: The world is invalid; it has all errors.
            ValueError: An argument is out of range, or the world has no demand or no robot to serve it.
        """
        read = read_world(world, changes)
        if not read.demand:
            raise ValueError(f"world {read.name!r} has no demand; an environment needs orders to dispatch")
        if not 0 < horizon < float("inf"):
            raise ValueError(f"horizon must be positive and finite, got {horizon} s")
        if orders < 1:
            raise ValueError(f"orders must be 1 at least, got {orders}")
        if not 0 <= charge_below < CHARGED:
            raise ValueError(f"charge_below must be at least 0 and less than {CHARGED}, got {charge_below}")
        able = _able(read)
        if unable := [robot for robot in robots or () if robot not in able]:
            raise ValueError(f"robot {unable[0]!r} can't serve orders; those that can are: {listed(able)}")
        chosen = tuple(robot for robot in able if robots is None or robot in robots)
        if not chosen:
            raise ValueError(f"world {read.name!r} has no robot that can pick items up and has no script of its own")
        chargers = {robot: _chargers(read, robot) for robot in chosen}
        return cls(read, chosen, chargers, Routes(read), float(horizon), orders, charge_below)


def _able(world: World) -> list[str]:
    """Return the robots that can fetch and deliver items, and have no script."""
    actions_of = Simulator(world).dispatcher.servers.actions_of
    return [name for name, robot in world.robots.items() if not robot.script and _NEEDED.issubset(actions_of(name))]


def _chargers(world: World, robot: str) -> dict[str, Charger]:
    """Return the chargers that a robot may use."""
    names = {robot, world.robots[robot].type}
    return {
        name: Charger(world.dock_point(name), dock.capacity)
        for name, dock in world.docks.items()
        if dock.charges and (dock.reserved_for is None or names.intersection(dock.reserved_for))
    }


_KEPT: Final = 65_536
"""Pairs of points whose travel time is cached."""


class Routes:
    """Travel times in a world, on all lanes, including lanes that are closed at the moment."""

    def __init__(self, world: World) -> None:
        self._graph = WaypointGraph(world)
        self.seconds = lru_cache(_KEPT)(self._seconds)
        """Return the seconds that the quickest route takes at a speed; without a route, those of a straight line."""

    def _seconds(self, start: Point, goal: Point, speed: float) -> float:
        try:
            return self._graph.plan(start, goal, speed).length / speed
        except NoRoute:
            return distance(start, goal) / speed
