"""The body of a vehicle: its state, and its pose as a function of time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from simpy import Event

from hmrsim.geometry import Pose, distance
from hmrsim.navigation.motion import Piece, Progress
from hmrsim.robots.vehicle_state import VehicleEvent, VehicleState, next_state

if TYPE_CHECKING:
    from hmrsim.engine.environment import At, Environment
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.events.robots import MotionBegan
    from hmrsim.geometry import Point
    from hmrsim.navigation.delays import Delays
    from hmrsim.navigation.graph import WaypointGraph
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.admission import Admission
    from hmrsim.world.model import Base

_NANOSECOND: Final = 1e-9
"""What belongs to one instant, in seconds: commands come at whole nanoseconds, robots arrive in between."""

NEVER_STOPPED: Final = (-1.0, 0.0)
"""When a vehicle was stopped, and at which run-up, if it never was."""


class VehicleBody:
    """A vehicle as it stands or moves.

    Its activity is one `VehicleState`, which the events of `hmrsim.robots.vehicle_state` change.

    Args:
        speed: Its maximum speed, in the world's unit a second.
        changed: Called whenever it begins or ceases to move, or goes on after something was to be decided; None for no
            call. Where a battery is drained by distance, a way also ends where the mean speed changes.

    Attributes:
        radius: Of its footprint; 0 if it has none.
        flies: Whether nothing on the ground is in its way.
        recoveries: How often it had to wait or to take another route, since the start.
        rerouted: How often it has taken another route on this trip.
        rank: By what vehicles are ordered: when they began their trips, in simulated seconds, those that go nowhere
            last; then their names. It is kept up to date, as traffic compares it several times a lane.
        speed_scale: The factor of its maximum speed.
        disabled_reasons: Why it is disabled, by cause, such as ``battery_empty``; empty while it can be used.
    """

    # More attributes than a class can share the names of among its objects: each would get a separate large table.
    __slots__ = (
        "_admission",
        "_arrived",
        "_began",
        "_changed",
        "_delays",
        "_drive",
        "_enabled",
        "_entry",
        "_env",
        "_final_yaw",
        "_follows_speed",
        "_graph",
        "_last",
        "_motion_change",
        "_number",
        "_on_way_end",
        "_own_changed",
        "_publisher",
        "_rest",
        "_route",
        "_seconds",
        "_set_out",
        "_speed",
        "_state",
        "_still_since",
        "_trip",
        "_way_end",
        "_works",
        "base",
        "disabled_reasons",
        "flies",
        "home",
        "name",
        "radius",
        "rank",
        "recoveries",
        "rerouted",
        "speed_scale",
        "type",
    )

    def __init__(  # noqa: PLR0913 - each is a part of its world
        self,
        env: Environment,
        name: str,
        base: Base,
        *,
        robot_type: str,
        speed: float,
        home: Pose,
        graph: WaypointGraph,
        admission: Admission,
        delays: Delays,
        publisher: EventPublisher,
        changed: Callable[[], None] | None = None,
    ) -> None:
        self.name = name
        self.type = robot_type
        self.base = base
        self.radius = base.radius or 0.0
        self.flies = base.flies
        self.home = home
        self.recoveries = self.rerouted = 0
        self._set_out = 0.0
        self.rank = (math.inf, name)
        self.speed_scale = 1.0
        self.disabled_reasons: dict[str, str] = {}
        self._env = env
        self._speed = speed
        self._graph = graph
        self._admission = admission
        self._delays = delays
        self._trip = 0
        self._publisher = publisher
        self._follows_speed = False
        # Replaced as long as a process waits for the event, so that it costs nothing otherwise.
        self._changed = self._own_changed = changed
        self._motion_change: Event | None = None
        self._enabled: Event | None = None
        self._works = False
        self._state = VehicleState.IDLE
        self._still_since = env.now
        # Where it stands, and when it was stopped there last, with the run-up of the speed that it had.
        self._rest = home
        self._entry = NEVER_STOPPED
        # Where it is to go, and the yaw to face there, None for any.
        self._route: Route | None = None
        self._final_yaw: float | None = None
        # How it drives there, the piece of the drive that it is known to have begun, and when; `_catch_up` brings both
        # up to date. Nothing is to be decided, and no event happens, before the end of the last piece.
        self._drive: Drive | None = None
        self._seconds: Sequence[float] = ()
        self._number = self._last = 0
        self._began = 0.0
        self._way_end: At | None = None
        self._on_way_end: list[Callable[[Any], None]] = []
        self._arrived: Event | None = None

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self._env.now

    @property
    def state(self) -> VehicleState:
        """The current state of the vehicle."""
        return self._state

    @property
    def stands(self) -> bool:
        """Return whether the vehicle stands and has nowhere to go."""
        return self._state.stands

    @property
    def moves(self) -> bool:
        """Return whether the vehicle is moving."""
        return self._state.moves

    @property
    def waits(self) -> bool:
        """Return whether the vehicle is blocked on its route."""
        return self._state.waits

    @property
    def sets_out(self) -> bool:
        """Return whether the vehicle begins a lane or a turn at this very instant."""
        return self._state.moves and self._env.now < self.began + _NANOSECOND

    @property
    def busy(self) -> bool:
        """Return whether the current goal requires the vehicle to stand still."""
        return self._state is VehicleState.WORKING

    @property
    def activity(self) -> str:
        """A description of the current state, in words."""
        if self.disabled:
            return f"disabled ({self.disabled})"
        if self.busy:
            return "working"
        if self.waits:
            return "waiting"
        return "idle" if self.stands else "driving"

    @property
    def still_since(self) -> float:
        """When it last ceased to make progress, in simulated seconds; infinite while it moves or works.

        One that was asked to do something, but could not begin, has made none.
        """
        return math.inf if self._state.moves or self._state is VehicleState.WORKING else self._still_since

    @property
    def may_yield(self) -> bool:
        """Return whether the vehicle stands and can make room for others."""
        state, route = self._state, self._route
        return state is VehicleState.IDLE or (state.waits and route is not None and route.goal is not None)

    @property
    def will_yield(self) -> bool:
        """Return whether the vehicle can make room, now or once it stands or has finished its work."""
        if self._state.moves:
            return self._state is VehicleState.YIELDING or (self._state.needs_admission and self.goal is not None)
        return self.busy or self.may_yield

    @property
    def disabled(self) -> str:
        """Why it can do nothing now; empty while it can be used."""
        return next(iter(self.disabled_reasons.values()), "")

    @property
    def goal(self) -> Point | None:
        """The point to which another route may lead; None if it goes nowhere, or its path is given point by point."""
        return None if self._route is None else self._route.goal

    def _enter(self, event: VehicleEvent) -> None:
        before = self._state
        self._state = next_state(before, event)
        if self._state.stands is not before.stands:
            self._update_rank()

    def _update_rank(self) -> None:
        self.rank = (math.inf if self._state.stands else self._set_out, self.name)

    def _stop_progress(self) -> None:
        """Record that the vehicle ceases to make progress, unless it has made none since its command."""
        if self._began < self._env.now:
            self._still_since = self._env.now

    def _motion_changes(self) -> Event:
        """Return the event that it next begins or ceases to move, begins a lane or a turn, or is placed elsewhere."""
        if self._motion_change is None:
            self._motion_change, self._changed = Event(self._env), self._call_and_announce
        return self._motion_change

    def _call_and_announce(self) -> None:
        if self._own_changed is not None:
            self._own_changed()
        self._announce_change()

    def _announce_change(self) -> None:
        event, self._motion_change, self._changed = self._motion_change, None, self._own_changed
        if event is not None:
            event.succeed()

    def _catch_up(self) -> None:
        """Record the pieces driven since the last event; at the end of a piece the vehicle is on the next."""
        if self._number == self._last or not self._state.moves:
            return
        now, seconds, number, last = self._env.now, self._seconds, self._number, self._last
        began, ends = self._began, self._began + self._seconds[number]
        while ends <= now and number < last:
            number += 1
            began, ends = ends, ends + seconds[number]
        self._number, self._began = number, began

    def progress(self) -> Progress:
        """Return where it is now, and how far it still has to go; nothing is left when it stands."""
        if self._drive is None:
            return Progress(self._rest)
        self._catch_up()
        return self._drive.progress(self._number, 0.0 if self._state.waits else self._env.now - self._began)

    def pose(self) -> Pose:
        """Return the position of its center and its yaw, now."""
        if self._drive is None:
            return self._rest
        self._catch_up()
        return self._drive.pose(self._number, 0.0 if self._state.waits else self._env.now - self._began)

    @property
    def piece(self) -> Piece | None:
        """The lane or the turn that it drives now; None when it stands, or waits."""
        if self._drive is None or self._state.waits:
            return None
        self._catch_up()
        return self._drive.piece(self._number)

    @property
    def next_leg(self) -> Leg | None:
        """The leg that it drives now, or waits for; None when it stands, or turns."""
        if self._drive is None:
            return None
        self._catch_up()
        return self._drive.legs[self._number]

    @property
    def legs_ahead(self) -> list[Leg]:
        """The legs that it has not driven to their ends; none when it stands."""
        if self._drive is None:
            return []
        self._catch_up()
        return [leg for leg in self._drive.legs[self._number :] if leg]

    @property
    def speed(self) -> float:
        """The maximum speed that it can go now, in the world's unit a second."""
        return self._speed * self.speed_scale

    def velocity(self) -> tuple[float, float]:
        """Return the speed ahead and the turning rate, now; the mean of a piece that has no constant speed."""
        piece = self.piece
        return (0.0, 0.0) if piece is None else piece.velocity

    @property
    def distance_remaining(self) -> float:
        """The remaining length of the route that it drives; 0 when it stands."""
        return self.progress().length

    def distance_to(self, point: Point) -> float:
        """Return how far its center is from *point*."""
        return distance(self.pose().point, point)

    def is_within(self, room: float, point: Point) -> bool:
        """Return whether its center is less than *room* away from *point*; quick if it stands somewhere else."""
        x, y = self._rest.point if self._drive is None else self.pose().point
        return abs(x - point[0]) < room and abs(y - point[1]) < room and self.distance_to(point) < room

    @property
    def began(self) -> float:
        """When it began the piece that it drives now, in simulated seconds."""
        self._catch_up()
        return self._began

    @property
    def piece_ends(self) -> float:
        """When it begins the next piece, if no event says so; infinite otherwise."""
        self._catch_up()
        if self._number == self._last or not self._state.moves:
            return math.inf
        return self._began + self._seconds[self._number]

    def motion(self) -> dict[str, Any] | None:
        """Return the piece that it drives now and those after it, as an observer sees them; None when it stands."""
        fields = self._motion_began().to_json() if self.piece else {}
        fields.pop("robot", None)
        return fields or None

    def _motion_began(self) -> MotionBegan:
        """Return the event that it begins the piece that it drives now, with all that it drives before an event."""
        if self._drive is None:
            raise AssertionError
        first, *further = (self._drive.piece(number) for number in range(self._number, self._last + 1))
        return first.event(self.name, further)

    def route(self) -> list[list[float]]:
        """Return the points that it still drives to, as JSON values; none when it stands."""
        return [[*leg.end] for leg in self.legs_ahead]
