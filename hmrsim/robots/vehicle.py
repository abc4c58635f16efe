"""A mobile base: its pose, and its motion along routes.

Its pose is a formula of time while it moves: there is one event a lane, and none in between.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from simpy import Event, Timeout
from simpy.events import NORMAL

from hmrsim.errors import GoalAborted, NoRoute
from hmrsim.events.robots import RouteTaken, Stopped
from hmrsim.events.traffic import Rerouted
from hmrsim.geometry import Pose, distance, turn
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.navigation.motion import Piece, Progress, drive
from hmrsim.robots.vehicle_state import VehicleEvent, VehicleState, next_state

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Generator, Sequence

    from hmrsim.engine.environment import Environment
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.events.robots import MotionBegan
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.admission import Passage
    from hmrsim.world.model import Base

_NEVER_STOPPED: Final = (-1.0, 0.0)


class MobileBase:
    """A base that drives, or flies.

    What it does is one `VehicleState`, which the events of `hmrsim.robots.vehicle_state` change.

    Args:
        env: The simulation's clock and events.
        name: Its name.
        robot_type: The name of its robot type.
        base: Its settings.
        speed: Its maximum speed, in the world's unit a second.
        home: Its pose at the start.
        graph: The lanes that it may use.
        passage: Admits it to each lane.
        publisher: Publishes what it does.
        changed: Called whenever it begins or ceases to move, or begins a lane or a turn; None for no call.

    Attributes:
        name: Its name.
        type: The name of its robot type.
        base: Its settings.
        radius: Of its footprint; 0 if it has none.
        flies: Whether nothing on the ground is in its way.
        home: Its pose at the start.
        recoveries: How often it had to wait or to take another route, since the start.
        rerouted: How often it has taken another route on this trip.
        set_out: When it began this trip, in simulated seconds.
        speed_scale: The factor of its maximum speed.
        disabled_reasons: Why it is disabled, by cause, such as ``battery_empty``; empty while it can be used.
    """

    # More attributes than a class can share the names of among its objects: each would have a large table of its own.
    __slots__ = (
        "_arrived",
        "_began",
        "_changed",
        "_drive",
        "_entry",
        "_env",
        "_final_yaw",
        "_graph",
        "_number",
        "_on_piece_end",
        "_passage",
        "_piece_ends",
        "_publisher",
        "_rest",
        "_route",
        "_seconds",
        "_speed",
        "_state",
        "base",
        "disabled_reasons",
        "flies",
        "home",
        "name",
        "radius",
        "recoveries",
        "rerouted",
        "set_out",
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
        passage: Passage,
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
        self.set_out = 0.0
        self.speed_scale = 1.0
        self.disabled_reasons: dict[str, str] = {}
        self._env = env
        self._speed = speed
        self._graph = graph
        self._passage = passage
        self._publisher = publisher
        self._changed = changed
        self._state = VehicleState.IDLE
        # Where it stands, and when it was stopped there last, with the run-up of the speed that it had.
        self._rest = home
        self._entry = _NEVER_STOPPED
        # Where it is to go, and the yaw to face there, None for any.
        self._route: Route | None = None
        self._final_yaw: float | None = None
        # How it drives there, which piece of the drive it is at, since when, and until when.
        self._drive: Drive | None = None
        self._seconds: Sequence[float] = ()
        self._number = 0
        self._began = 0.0
        self._piece_ends: Timeout | None = None
        self._on_piece_end: list[Callable[[Any], None]] = [self._begin_next]
        self._arrived: Event | None = None

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self._env.now

    # --- state ----------------------------------------------------------------------------------------------------

    @property
    def state(self) -> VehicleState:
        """What it does."""
        return self._state

    @property
    def stands(self) -> bool:
        """Whether it stands, and goes nowhere."""
        return self._state.stands

    @property
    def moves(self) -> bool:
        """Whether it is on its way, and nothing is in it."""
        return self._state.moves

    @property
    def waits(self) -> bool:
        """Whether it stands on its way, since something is in it."""
        return self._state.waits

    @property
    def sets_out(self) -> bool:
        """Whether it begins a lane or a turn at this very instant."""
        return self._state.moves and self._began == self._env.now

    @property
    def busy(self) -> bool:
        """Whether its goal needs it to stand still."""
        return self._state is VehicleState.WORKING

    @property
    def may_yield(self) -> bool:
        """Whether it stands, and could go somewhere else for a while."""
        return self._state is VehicleState.IDLE or (self._state.waits and self._goal is not None)

    @property
    def disabled(self) -> str:
        """Why it can do nothing now; empty while it can be used."""
        return next(iter(self.disabled_reasons.values()), "")

    @property
    def _goal(self) -> Point | None:
        """The point to which another route may lead; None if it goes nowhere, or its path is given point by point."""
        return None if self._route is None else self._route.goal

    def _enter(self, event: VehicleEvent) -> None:
        self._state = next_state(self._state, event)

    # --- pose -----------------------------------------------------------------------------------------------------

    def progress(self) -> Progress:
        """Return where it is now, and how far it still has to go; nothing is left when it stands."""
        if self._drive is None:
            return Progress(self._rest)
        return self._drive.progress(self._number, 0.0 if self._state.waits else self._env.now - self._began)

    def pose(self) -> Pose:
        """Return the position of its centre and its yaw, now."""
        return self.progress().pose

    @property
    def piece(self) -> Piece | None:
        """The lane or the turn that it drives now; None when it stands, or waits."""
        return None if self._drive is None or self._state.waits else self._drive.piece(self._number)

    @property
    def next_leg(self) -> Leg | None:
        """The leg that it drives now, or waits for; None when it stands, or turns."""
        return None if self._drive is None else self._drive.legs[self._number]

    @property
    def legs_ahead(self) -> list[Leg]:
        """The legs that it has not driven to their ends; none when it stands."""
        return [] if self._drive is None else [leg for leg in self._drive.legs[self._number :] if leg]

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
        """Return how far its centre is from *point*."""
        return distance(self.pose().point, point)

    @property
    def began(self) -> float:
        """When it began the piece that it drives now, in simulated seconds."""
        return self._began

    def motion(self) -> dict[str, Any] | None:
        """Return the piece that it drives now, as an observer sees it; None when it stands, or waits."""
        piece = self.piece
        return piece.describe() if piece else None

    def route(self) -> list[list[float]]:
        """Return the points that it still drives to, as JSON values; none when it stands."""
        return [[*leg.end] for leg in self.legs_ahead]

    # --- planning -------------------------------------------------------------------------------------------------

    def plan_to(self, goal: Point, start: Point | None = None) -> Route:
        """Return the quickest route from where it is, or from *start*.

        Raises:
            NoRoute: The goal or *start* is outside the map or inside an obstacle, or no route leads there.
        """
        if start is None:
            start = self.pose().point
        else:
            self._graph.check_start(start)
        return self._graph.fly(start, goal) if self.flies else self._passage.plan(self, start, goal)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the route from where it is straight from point to point, and what is in its way; or ""."""
        return self._graph.straight_through([self.pose().point, *points], flies=self.flies)

    def reach(self, point: Point) -> tuple[Point, str]:
        """Return how far it gets straight towards *point*, and what stops it before; or ""."""
        return self._graph.reach(self.pose().point, point, flies=self.flies)

    # --- commands -------------------------------------------------------------------------------------------------

    def drive(self, route: Route, final_yaw: float | None) -> Generator[Any, Any, None]:
        """Drive a route that begins here, then face *final_yaw*, if any; an interrupt stops it where it is.

        Raises:
            GoalAborted: Something is in its way for too long, it can go no further, or it is disabled.
        """
        if self.disabled_reasons:
            raise GoalAborted(FollowPath.Result.UNKNOWN, self.disabled)
        yields = self._state.yields and route.goal is not None
        if not yields:
            self.halt()
        self._route, self._final_yaw = route, final_yaw
        self.rerouted, self.set_out = 0, self._env.now
        if yields:
            # The other vehicle counts on the place that it leaves; the route is planned again from where it yields.
            self._enter(VehicleEvent.REDIRECT)
            self._arrived = Event(self._env)
            yield from self._arrival()
        else:
            yield from self._carry_out(self._driven(route.legs), VehicleEvent.SET_OUT)
        if self.stands and final_yaw is not None and final_yaw != self._rest.yaw:
            # Without a turning rate no piece of the drive says so.
            start, self._rest = self._rest, Pose(*self._rest.point, final_yaw)
            turned = Piece(start, self._rest, 0.0, 0.0, turned=turn(start.yaw, final_yaw))
            self._publisher.publish_untraced(lambda: turned.event(self.name))

    def perform(self, driven: Drive) -> Generator[Any, Any, None]:
        """Carry out a motion that begins here, without regard to obstacles; an interrupt stops it where it is.

        Raises:
            GoalAborted: It is disabled.
        """
        if self.disabled_reasons:
            raise GoalAborted(FollowPath.Result.UNKNOWN, self.disabled)
        self.halt()
        self._route = None
        yield from self._carry_out(driven, VehicleEvent.MANEUVER)

    def halt(self) -> None:
        """Stop here, wherever it was going; nothing happens if it stands."""
        if self._state.stands:
            return
        leg = None if self._state.waits or self.sets_out else self.next_leg
        piece = self.piece
        # A drive that begins at this instant begins at this speed.
        self._entry = self._env.now, piece.run_up(self._env.now - self._began) if piece else 0.0
        self._rest = self.pose()
        if self._piece_ends is not None:
            self._env.abandon(self._piece_ends)
        self._drive = self._piece_ends = None
        self._enter(VehicleEvent.HALT)
        self._passage.stopped(self, leg)
        if self._changed is not None:
            self._changed()
        self._publisher.publish(lambda: Stopped(self.name, self._rest.point))

    def give_up(self, why: GoalAborted) -> None:
        """Stop on its way, and fail the drive."""
        arrived = self._arrived
        self.halt()
        _fail(arrived, why)

    def move_to(self, pose: Pose) -> None:
        """Stand somewhere else at once; no goal that holds the base may be running."""
        self.halt()
        self._rest, self._entry = pose, _NEVER_STOPPED
        self._passage.place(self)

    def disable(self, cause: str, why: str) -> None:
        """Stop, and be able to do nothing until this and all other causes are gone."""
        self.disabled_reasons[cause] = why
        self.halt()
        self._enter(VehicleEvent.DISABLE)

    def enable(self, cause: str) -> None:
        """Be disabled by this cause no longer; nothing happens if it is not."""
        if self.disabled_reasons.pop(cause, None) is not None and not self.disabled_reasons:
            self._enter(VehicleEvent.ENABLE)

    def begin_work(self) -> None:
        """Stand still until `finish_work`, and yield to no other vehicle."""
        if not self._state.stands:
            self.halt()
        self._enter(VehicleEvent.WORK)

    def finish_work(self) -> None:
        """Have no work any more; nothing happens if it does something else by now."""
        if self._state is VehicleState.WORKING:
            self._enter(VehicleEvent.FINISH_WORK)
        self._passage.became_idle(self)

    def scale_speed(self, scale: float) -> None:
        """Go at this share of its maximum speed, also on the route that it drives now."""
        self.speed_scale = scale
        if self._route is None or self._state.stands:
            return
        if self._state.waits:
            self._drive = self._driven(self.legs_ahead)
            self._seconds, self._number = self._drive.seconds, 0
            self._enter(VehicleEvent.RESCALE)
            return
        leg, here = self.next_leg, self.pose().point
        rest = self.legs_ahead
        at_end = leg is not None and here == leg.end
        if at_end:
            rest = rest[1:]
        elif leg is not None and leg.ride:
            rest[0] = replace(leg, ride=leg.ride - (self._env.now - self._began))
        elif leg is not None:
            rest[0] = replace(leg, start=here, length=distance(here, leg.end))
        if not rest:
            # It arrives at this instant, or turns there.
            return
        self._rest = self.pose()
        if self._piece_ends is not None:
            self._env.abandon(self._piece_ends)
        self._drive = None
        self._enter(VehicleEvent.RESCALE)
        self._begin(self._driven(rest), admitted=leg is not None and not at_end)

    # --- driving --------------------------------------------------------------------------------------------------

    def _driven(self, legs: Sequence[Leg]) -> Drive:
        """Return how it drives legs from where it is, and then turns to the final yaw of its trip, if any.

        A base that yields leaves at once, since another one counts on its place, and turns neither before nor after.
        """
        yields = self._state.yields
        return drive(
            self.pose(),
            legs,
            None if yields or self._route is None else self._final_yaw,
            speed=self.speed,
            acceleration=self.base.acceleration,
            turning_rate=None if yields else self.base.turning_rate,
            run_up=self._entry[1] if self._entry[0] == self._env.now else 0.0,
        )

    def _carry_out(self, driven: Drive, event: VehicleEvent) -> Generator[Any, Any, None]:
        if not driven.seconds:
            return
        self._enter(event)
        self._arrived = Event(self._env)
        self._begin(driven)
        yield from self._arrival()

    def _arrival(self) -> Generator[Any, Any, None]:
        try:
            yield self._arrived
        except BaseException:
            self.halt()
            raise

    def _begin(self, driven: Drive, *, admitted: bool = False) -> None:
        """Begin a drive from where it is, or wait; nothing may be scheduled for the one before."""
        self._drive, self._seconds, self._number = driven, driven.seconds, 0
        self._began = self._env.now
        if self._publisher.interest.motion:
            self._publisher.publish_untraced(lambda: RouteTaken(self.name, [leg.end for leg in self.legs_ahead]))
        if admitted or self._may_begin(0):
            self._begin_piece(0)

    def _begin_piece(self, number: int) -> None:
        """Begin a piece of the drive; `_begin_next` goes on from there.

        One timeout is scheduled anew for each piece, past the process that drives: with many robots that is half
        the work of the whole simulation.
        """
        self._number, self._began = number, self._env.now
        self._piece_ends = Timeout(self._env, self._seconds[number])
        self._piece_ends.callbacks = self._on_piece_end
        self._publish_motion()

    def _begin_next(self, piece_end: Event) -> None:
        if piece_end is not self._piece_ends:
            # It was stopped on that way.
            return
        number = self._number + 1
        if number == len(self._seconds):
            self._arrive()
        elif not self._passage.needed or self._may_begin(number):
            self._number, self._began = number, self._env.now
            piece_end.callbacks = self._on_piece_end
            self._env.schedule(piece_end, NORMAL, self._seconds[number])
            self._publish_motion()

    def _publish_motion(self) -> None:
        if self._changed is not None:
            self._changed()
        if self._publisher.interest.motion:
            self._publisher.publish_untraced(self._motion_began)

    def _motion_began(self) -> MotionBegan:
        piece = self.piece
        if piece is None:
            raise AssertionError
        return piece.event(self.name)

    def _may_begin(self, number: int) -> bool:
        """Return whether it is admitted to a piece of its drive; if not, it waits here."""
        leg = self._drive.legs[number] if self._drive and self._state.needs_admission and not self.flies else None
        if leg is None or self._passage.admit(self, leg):
            return True
        self._number = number
        self._block()
        self._passage.decide(self)
        return False

    def _block(self) -> None:
        self._enter(VehicleEvent.BLOCK)
        self._piece_ends = None
        self.recoveries += 1
        if self._changed is not None:
            self._changed()

    def _arrive(self) -> None:
        driven, arrived = self._drive, self._arrived
        if driven is None or arrived is None:
            raise AssertionError
        last = driven.piece(len(self._seconds) - 1)
        self._rest, self._drive, self._piece_ends = last.end, None, None
        self._enter(VehicleEvent.ARRIVE)
        self._passage.arrived(self)
        if self._changed is not None:
            self._changed()
        if self._state is VehicleState.YIELDED:
            self._plan_on()
        else:
            arrived.succeed()

    def _plan_on(self) -> None:
        """Plan the rest of its trip, if any, from where it has yielded."""
        goal = self._goal
        if goal is None:
            self._enter(VehicleEvent.ARRIVE)
        else:
            try:
                route = self._passage.plan(self, self._rest.point, goal)
            except NoRoute as error:
                self._enter(VehicleEvent.HALT)
                _fail(self._arrived, error)
                return
            self._route = route
            driven = self._driven(route.legs)
            if driven.seconds:
                self._drive, self._seconds, self._number = driven, driven.seconds, 0
            else:
                # Where it has yielded is where it was going.
                self._enter(VehicleEvent.ARRIVE)
                if self._arrived is not None:
                    self._arrived.succeed()
        self._passage.yielded(self)

    # --- traffic --------------------------------------------------------------------------------------------------

    def go_on(self) -> None:
        """Drive the leg for which it waits: it is admitted now."""
        if self._drive is None or self._drive.in_pieces:
            self._enter(VehicleEvent.RESUME)
            self._begin_piece(self._number)
        else:
            driven = self._driven(self.legs_ahead)
            self._enter(VehicleEvent.RESUME)
            self._begin(driven, admitted=True)

    def ask_again(self) -> None:
        """Ask for the right of way again if it waits, and drive on or keep waiting."""
        if self._drive is not None and self._state.waits:
            self._enter(VehicleEvent.RESUME)
            self._begin(self._drive)

    def step_back(self) -> None:
        """Lose the right of way at the instant at which it sets out, and wait."""
        piece_ends = self._piece_ends
        self._block()
        if piece_ends is not None:
            self._env.abandon(piece_ends)

    def reroute(self, avoid: Collection[Lane]) -> bool:
        """Take another route from where it waits, without these lanes; return whether there is one."""
        goal = self._goal
        if goal is None or not self._state.waits:
            return False
        try:
            route = self._passage.plan(self, self.pose().point, goal, avoid)
        except NoRoute:
            return False
        if route.legs and route.legs[0] == self.next_leg:
            # It begins with what is in the way, where it waits in the middle of a lane.
            return False
        self._route = route
        self.recoveries += 1
        self.rerouted += 1
        self._publisher.publish(lambda: Rerouted(self.name, self.pose().point))
        # It may have to turn first, and then asks later.
        self._passage.forget(self)
        driven = self._driven(route.legs)
        self._enter(VehicleEvent.REROUTE)
        self._begin(driven)
        return True

    def yield_along(self, leg: Leg, *, rerouted: bool = False) -> None:
        """Yield to another vehicle by driving a leg from where it stands, to which it is admitted already.

        Then it goes on to where it was going, if anywhere, when the traffic policy lets it.

        Args:
            leg: The leg.
            rerouted: Whether this counts as another route.
        """
        here, stood = self.pose().point, self._state.stands
        self._enter(VehicleEvent.YIELD)
        if stood:
            self._route, self._arrived = None, Event(self._env)
        self._drive = None
        self.rerouted += rerouted
        if here != leg.start:
            # It stands beside the waypoint, as after backing up.
            leg = replace(leg, start=here, length=distance(here, leg.end))
        self._begin(self._driven([leg]), admitted=True)


def _fail(arrived: Event | None, why: GoalAborted) -> None:
    if arrived is not None and not arrived.triggered:
        arrived.fail(why)
        # It may have no goal, as when it yields.
        arrived.defused = True
