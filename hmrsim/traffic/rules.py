"""The interface between admission and policies: vehicles, their waits and timeouts, and the rules of a policy."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Final, Literal, Protocol

if TYPE_CHECKING:
    from simpy import Timeout

    from hmrsim.engine.environment import Environment
    from hmrsim.errors import GoalAborted
    from hmrsim.events.traffic import Waiting
    from hmrsim.geometry import Point, Pose
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.motion import Piece
    from hmrsim.navigation.route import Leg, Route


Activity = Literal["disabled", "docked", "works", "drives", "idle"]
"""The activity of a vehicle that nothing holds up: the first of these that applies."""

by_rank: Final = attrgetter("rank")
"""The key by which vehicles are ordered."""


class Vehicle(Protocol):
    """A robot as traffic policies, barriers and lifts see it."""

    @property
    def name(self) -> str:
        """The unique name of the robot."""

    @property
    def type(self) -> str:
        """The name of its robot type."""

    @property
    def radius(self) -> float:
        """The radius of the footprint; 0 if there is none."""

    @property
    def flies(self) -> bool:
        """Return whether the vehicle flies, so that nothing on the ground blocks it."""

    @property
    def speed(self) -> float:
        """The maximum speed now, in the world's unit per second."""

    @property
    def rank(self) -> tuple[float, str]:
        """The key by which vehicles are ordered: by when they set out; those without a destination come last."""

    @property
    def rerouted(self) -> int:
        """The number of reroutes on the current trip."""

    @property
    def stands(self) -> bool:
        """Return whether the vehicle stands and has no destination."""

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
        """Return whether the vehicle stands still for a goal, or lingers after the end of one."""

    @property
    def stays_until(self) -> float:
        """The simulated time until which the vehicle lingers after a goal; in the past if it does not linger."""

    @property
    def may_yield(self) -> bool:
        """Return whether the vehicle stands and can make room for others."""

    @property
    def will_yield(self) -> bool:
        """Return whether the vehicle can make room now, or once it has stopped or ended its work."""

    def pose(self) -> Pose:
        """Return the current position of the center, and the yaw."""

    def distance_to(self, point: Point) -> float:
        """Return the distance from the center to *point*."""

    @property
    def disabled_reasons(self) -> Mapping[str, str]:
        """The reasons why the vehicle is disabled, by cause; empty while it can be used."""

    @property
    def activity(self) -> tuple[Activity, str, str]:
        """The vehicle's activity, a phrase for it such as ``is idle``, and details, which may be empty."""

    @property
    def still_since(self) -> float:
        """The simulated time since which the vehicle has made no progress; infinite while it moves or works."""

    @property
    def goal(self) -> Point | None:
        """The destination, to which any route may lead; None without one, or if the path is given point by point."""

    @property
    def piece(self) -> Piece | None:
        """The lane or turn that the vehicle drives now; None while it stands or waits."""

    @property
    def next_leg(self) -> Leg | None:
        """The leg that the vehicle drives now or waits for; None while it stands or turns."""

    @property
    def legs_ahead(self) -> list[Leg]:
        """The legs that the vehicle has not driven to their ends; empty while it stands."""

    def look_ahead(self) -> None:
        """Request each lane on the route again, since a lane may have closed."""

    def go_on(self) -> None:
        """Drive the leg for which the vehicle has waited, and to which it is now admitted."""

    def ask_again(self) -> None:
        """Request the right of way again if the vehicle waits; drive on or keep waiting."""

    def step_back(self) -> None:
        """Give up the right of way at the instant at which the vehicle sets out, and wait."""

    def reroute(self, avoid: Collection[Lane]) -> bool:
        """Take another route from the current position without these lanes; return whether there is one."""

    def take_route(self, route: Route) -> None:
        """Take a route from the current position, and request the right of way again."""

    def yield_along(self, legs: Sequence[Leg], by: str, *, rerouted: bool = False) -> None:
        """Make room for the vehicle *by* by driving legs to which this one is admitted."""

    def give_up(self, why: GoalAborted) -> None:
        """Stop on the route, and fail the drive."""


@dataclass(eq=False)
class Wait:
    """A vehicle that waits for the right of way.

    Attributes:
        leg: The leg for which the vehicle waits.
        since: The beginning of the wait, in simulated seconds.
        why: The obstacle, in words; empty if other vehicles block the leg.
        published: The last event about this wait; None if there is none yet.
        asks: Whether a time is set at which the vehicle requests again, because a search for a way out was postponed.
    """

    robot: Vehicle
    leg: Leg
    since: float
    why: str = ""
    published: Waiting | None = None
    asks: bool = False


class Rules(Protocol):
    """A policy at work in one world."""

    @property
    def grace(self) -> float:
        """The seconds for which a vehicle is not moved after a goal, if its next goal may take time to come."""

    def held(self, robot: Vehicle) -> tuple[int, ...]:
        """Return the slots that a vehicle holds, in the order in which it drives them."""

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, and release all others that it holds; return False if they are taken."""

    def reset(self) -> None:
        """Forget the past, but keep the slots of the vehicles."""

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a standing vehicle these slots, even if they are full, and release all others that it holds."""

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle."""

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """End the wait of a vehicle for a leg."""

    def spot(self, point: Point) -> int:
        """Return the slot of a point beside the lanes."""

    def full(self, slot: int) -> bool:
        """Return whether a slot has no room for another vehicle now."""

    def inside(self, slot: int) -> Sequence[Vehicle]:
        """Return the vehicles that hold a slot."""

    def near(self, slot: int, radius: float) -> Iterator[tuple[int, Vehicle]]:
        """Yield the slots and their holders that a vehicle of this radius in a slot would touch."""

    def blockers(self, robot: Vehicle, leg: Leg) -> Sequence[Vehicle]:
        """Return the vehicles that hold slots which a vehicle needs for a leg."""

    def ahead_of(self, robot: Vehicle) -> Iterable[Vehicle]:
        """Return the vehicles whose turn comes before that of a waiting one; its patience does not count before."""

    def why_stays(self, other: Vehicle, robot: Vehicle) -> str:
        """Return why *other* does not make room for *robot*, as the end of a sentence: "it …"."""

    def waiting_for(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles that wait for a slot which a vehicle holds."""

    def shut_in_by(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles that occupy all ways out of where a vehicle stands; none if a way is free."""

    def moves_past(self, robots: Sequence[Vehicle]) -> Sequence[tuple[Vehicle, Point]]:
        """Return moves of vehicles, in order, that bring the first one, which waits, to its goal or ahead.

        All other vehicles stay; the result is empty if no moves are found.
        """

    def halted(self, robot: Vehicle) -> None:
        """Record that a vehicle was stopped on its leg, so that it will not arrive."""

    def stays_aside(self, robot: Vehicle) -> bool:
        """Return whether a vehicle that has yielded has to stay there; if so, the policy resumes it later."""

    def opened(self) -> None:
        """Record that a door opened, a cabin arrived, or a lane opened or closed."""

    def blocked(self, robot: Vehicle) -> None:
        """Resolve the wait of a vehicle that begins to wait, if that is possible."""


class WaitTimeout:
    """Reports waits that have been hopeless for too long; one timeout serves all waits, as their limit is the same.

    Args:
        seconds: The limit; None for no limit.
        since: Returns since when neither the vehicle of a wait nor any of those for which it waits has made progress,
            in simulated seconds. Infinite if one of them does now; None if the wait is over.
        expired: Called with a wait that has reached the limit.
    """

    def __init__(
        self,
        env: Environment,
        seconds: float | None,
        *,
        since: Callable[[Wait], float | None],
        expired: Callable[[Wait], None],
    ) -> None:
        self._env = env
        self._seconds = seconds
        self._since = since
        self._expired = expired
        self._number = 0
        self._waiting: list[tuple[float, int, Wait]] = []
        self._timeout: Timeout | None = None

    def begin(self, wait: Wait) -> None:
        """Watch a wait that begins now."""
        if self._seconds is None:
            return
        self._add(wait.since, wait)
        if self._timeout is not None and self._waiting[0][2] is wait:
            self._env.abandon(self._timeout)
            self._timeout = None
        if self._timeout is None:
            self._set_timeout()

    def stop(self) -> None:
        """Forget all waits, and remove the timeout, which would otherwise keep simulated time going."""
        if self._timeout is not None:
            self._env.abandon(self._timeout)
            self._timeout = None
        self._waiting.clear()

    def _add(self, since: float, wait: Wait) -> None:
        self._number += 1
        heapq.heappush(self._waiting, (since, self._number, wait))

    def _set_timeout(self) -> None:
        """Set the timeout for the wait that may reach the limit next, if any."""
        while self._waiting and self._since(self._waiting[0][2]) is None:
            heapq.heappop(self._waiting)
        if self._waiting and self._seconds is not None:
            left = self._waiting[0][0] + self._seconds - self._env.now
            self._timeout = self._env.timeout(max(0.0, left))
            self._timeout.callbacks = [lambda _event: self._expire()]

    def _expire(self) -> None:
        self._timeout = None
        looked, _, wait = heapq.heappop(self._waiting)
        since = self._since(wait)
        if since is not None:
            if since <= looked:
                self._expired(wait)
            else:
                # There was progress meanwhile: the time counts from when the last of these vehicles stopped.
                self._add(min(since, self._env.now), wait)
        # A vehicle that gives up can make another one wait, which sets the timeout.
        if self._timeout is None:
            self._set_timeout()
