"""The mobile base of a robot: its activity, its motion along routes, and maneuvers.

A base drives lane by lane and turn by turn, and begins a lane when traffic admits it. There is one event per decision,
such as whether it may begin the next lane, and none in between. If nothing can get in its way, a whole route is one
event.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from simpy import Event

from hmrsim.engine.environment import At
from hmrsim.errors import BaseDisabled, NoRoute
from hmrsim.events.robots import RouteTaken, Stopped
from hmrsim.events.traffic import Rerouted
from hmrsim.geometry import SAME_PLACE, Pose, distance, turn
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.navigation.motion import Piece, drive_of, steered
from hmrsim.robots.motion import Motion
from hmrsim.robots.vehicle_state import VehicleEvent, VehicleState, next_state

if TYPE_CHECKING:
    from hmrsim.engine.environment import Environment
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.errors import GoalAborted
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Delays, Leg, Route
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.rules import Activity
    from hmrsim.world.model import Base

_NANOSECOND: Final = 1e-9
"""The length of an instant, in seconds: commands come at whole nanoseconds, and robots arrive in between."""

_STEERING_STEP: Final = 0.1
"""The duration in seconds of the straight pieces that approximate a curve driven at given velocities."""

_NEVER_STOPPED: Final = (-1.0, 0.0)
"""The entry of a vehicle that was never stopped: the time of the stop, and the run-up."""


class MobileBase:
    """A base that drives or flies, can be stopped anywhere, and makes room for others.

    Its activity is one `VehicleState`, which only the events of `hmrsim.robots.vehicle_state` change.

    Args:
        speed: The maximum speed, in the world's unit per second.
        moved: Called whenever the base begins or stops moving; None for no call. If distance drains a battery, it is
            also called whenever the mean speed changes.

    Attributes:
        motion: Its position as a function of time.
        graph: The graph on which it drives.
        radius: The radius of its footprint; 0 if it has none.
        flies: Whether it flies, so that nothing on the ground blocks it.
        recoveries: The number of times it had to wait or take another route since the start.
        rerouted: The number of times it has taken another route on this trip.
        rank: The sort key of vehicles: the start of the trip in simulated seconds, infinite without a trip, then the
            name. It is stored, as traffic compares it several times per lane.
        speed_scale: The factor of its maximum speed.
        works: Whether its goal requires it to stand still.
        disabled_reasons: The reasons for which it is disabled, by cause, such as ``battery_empty``.
    """

    # So many attributes exceed CPython's key-sharing dictionaries: each object would have a large table of its own.
    __slots__ = (
        "_admission",
        "_arrived",
        "_delays",
        "_enabled",
        "_entry",
        "_env",
        "_final_yaw",
        "_follows_speed",
        "_lingers",
        "_motion_change",
        "_moved",
        "_moved_aside",
        "_publisher",
        "_route",
        "_set_out",
        "_speed",
        "_state",
        "_stays_until",
        "_still_since",
        "_trip",
        "_trips_in_place",
        "base",
        "disabled_reasons",
        "flies",
        "graph",
        "home",
        "motion",
        "name",
        "radius",
        "rank",
        "recoveries",
        "rerouted",
        "speed_scale",
        "type",
        "works",
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
        moved: Callable[[], None] | None = None,
    ) -> None:
        self.name = name
        self.type = robot_type
        self.base = base
        self.radius = base.radius or 0.0
        self.flies = base.flies
        self.home = home
        self.graph = graph
        self.motion = Motion(env, home, self._end_way)
        self.recoveries = self.rerouted = 0
        self.rank = (math.inf, name)
        self.speed_scale = 1.0
        self.disabled_reasons: dict[str, str] = {}
        self._env = env
        self._speed = speed
        self._admission = admission
        self._delays = delays
        self._publisher = publisher
        self._moved = moved
        self._follows_speed = False
        self._state = VehicleState.IDLE
        self._still_since = env.now
        self.works = False
        # Whether the client of its last goal needs time to send the next one, and until when the base lingers for it.
        self._lingers = False
        self._stays_until = 0.0
        # The number of trips in a row that ended where they began; motion and work start a new row.
        self._trips_in_place = 0
        # If traffic has moved it aside since its last drive: from where, for which vehicle, and when.
        self._moved_aside: tuple[Point, str, float] | None = None
        # The route, and the yaw to face at its end; None for any.
        self._route: Route | None = None
        self._final_yaw: float | None = None
        self._trip = 0
        self._set_out = 0.0
        # The time of the last stop, and the run-up to the speed before it.
        self._entry = _NEVER_STOPPED
        # Processes wait for these events.
        self._arrived: Event | None = None
        self._motion_change: Event | None = None
        self._enabled: Event | None = None

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
        """Return whether the vehicle begins a lane or a turn at this instant."""
        if not self._state.moves:
            return False
        self.motion.catch_up()
        return self._env.now < self.motion.began + _NANOSECOND

    @property
    def busy(self) -> bool:
        """Return whether the vehicle stands still for a goal, or lingers where one has just ended."""
        return self._state is VehicleState.WORKING

    @property
    def stays_until(self) -> float:
        """The simulated time in seconds until which it lingers where its goal has ended; in the past if it does not."""
        return self._stays_until if self.busy and not self.works else 0.0

    @property
    def activity(self) -> tuple[Activity, str, str]:
        """The robot's activity, a phrase for it such as ``is idle``, and details, which may be empty."""
        if self.disabled_reasons:
            return "disabled", "is out of service", "; ".join(self.disabled_reasons.values())
        return ("drives", "is driving", "") if self.moves else ("idle", "is idle", "")

    @property
    def still_since(self) -> float:
        """The simulated time in seconds at which it last stopped making progress; infinite while it moves or works.

        A command that it could not begin to execute is no progress.
        """
        return math.inf if self._state.moves or self._state is VehicleState.WORKING else self._still_since

    @property
    def may_yield(self) -> bool:
        """Return whether the vehicle stands and can make room for others."""
        state, route = self._state, self._route
        return state is VehicleState.IDLE or (state.waits and route is not None and route.goal is not None)

    @property
    def will_yield(self) -> bool:
        """Return whether the vehicle can make room, now or after it has stopped or finished its work."""
        if self._state.moves:
            return self._state is VehicleState.YIELDING or (self._state.needs_admission and self.goal is not None)
        return self.busy or self.may_yield

    @property
    def moved_aside(self) -> str:
        """The last move by traffic since its last drive, with the other vehicle and the time, as text; may be empty."""
        if self._moved_aside is None:
            return ""
        start, by, at = self._moved_aside
        if self.distance_to(start) <= SAME_PLACE:
            # Its next goal came at the instant of its departure, or it has returned.
            return ""
        name = self._admission.causes.places.of
        return (
            f"{self.name} was at {name(start)} until traffic moved it aside for {by} at {at:g} s, and is at "
            f"{name(self.pose().point)} now: drive there again"
        )

    @property
    def disabled(self) -> str:
        """The first reason for which it is disabled; empty while it can be used."""
        return next(iter(self.disabled_reasons.values()), "")

    @property
    def goal(self) -> Point | None:
        """The destination of its trip; None without one, or if its path is given point by point."""
        return None if self._route is None else self._route.goal

    def _enter(self, event: VehicleEvent) -> None:
        before = self._state
        self._state = next_state(before, event)
        if self._state.stands is not before.stands:
            self._update_rank()

    def _update_rank(self) -> None:
        self.rank = (math.inf if self._state.stands else self._set_out, self.name)

    def _stop_progress(self) -> None:
        """Record that the vehicle stops making progress, unless it has made none since its command."""
        if self.motion.began < self._env.now:
            self._still_since = self._env.now

    def pose(self) -> Pose:
        """Return the current position of its center, and its yaw."""
        return self.motion.pose()

    def distance_to(self, point: Point) -> float:
        """Return the distance of its center from a point."""
        return distance(self.motion.pose().point, point)

    def velocity(self) -> tuple[float, float]:
        """Return the current forward speed and turning rate; the mean of a piece without a constant speed."""
        piece = self.motion.piece
        return (0.0, 0.0) if piece is None else piece.velocity

    @property
    def speed(self) -> float:
        """The current maximum speed, in the world's unit per second."""
        return self._speed * self.speed_scale

    @property
    def piece(self) -> Piece | None:
        """The current lane or turn; None while it stands or waits."""
        return self.motion.piece

    @property
    def next_leg(self) -> Leg | None:
        """The leg that it drives or waits for; None while it stands or turns."""
        legs = self.motion.legs
        return legs[0] if legs else None

    @property
    def legs_ahead(self) -> list[Leg]:
        """The legs that it has not completed; none while it stands."""
        return [leg for leg in self.motion.legs if leg]

    def _announce_motion(self) -> None:
        """Notify the robot, and the processes that watch it, of a change of its motion."""
        if self._moved is not None:
            self._moved()
        if self._motion_change is not None:
            self._announce_change()

    def _announce_change(self) -> None:
        event, self._motion_change = self._motion_change, None
        if event is not None:
            event.succeed()

    def plan_to(self, goal: Point, start: Point | None = None) -> Route:
        """Return the quickest route from its position, or from *start*.

        Raises:
            NoRoute: The goal or *start* is outside the map or inside an obstacle, or no route leads there.
        """
        if not self.flies:
            return self.plan_on_lanes(goal, start)
        if start is not None:
            self.graph.check_start(start)
        return self.graph.fly(self.pose().point if start is None else start, goal)

    def plan_on_lanes(self, goal: Point, start: Point | None = None) -> Route:
        """Return the quickest route along the lanes, even if the base flies.

        Raises:
            NoRoute: See `plan_to`.
        """
        if start is not None:
            self.graph.check_start(start)
        return self._admission.plan(self, self.pose().point if start is None else start, goal)

    def watch(self, seconds: float = math.inf) -> Generator[Any, Any, None]:
        """Wait until the piece ends, the motion or the open lanes change, or some seconds have passed."""
        if self._motion_change is None:
            self._motion_change = Event(self._env)
        woken = Event(self._env)

        def wake(_event: Event) -> None:
            if not woken.triggered:
                woken.succeed()

        events = (self._motion_change, self._admission.lanes_change())
        for event in events:
            event.callbacks.append(wake)
        try:
            yield from self._env.wait(woken, min(self._env.now + seconds, self.motion.piece_ends))
        finally:
            for event in events:
                if not event.processed:
                    event.callbacks.remove(wake)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the route from its position straight from point to point, and the obstacle on it, if any, or ""."""
        return self.graph.straight_through([self.pose().point, *points], flies=self.flies)

    def drive(self, route: Route, final_yaw: float | None) -> Generator[Any, Any, None]:
        """Drive a route that begins here, then turn to *final_yaw*, if any; an interrupt stops it on the spot.

        Raises:
            GoalAborted: Something is in its way for too long, it can go no further, or it is disabled.
        """
        self._check_enabled()
        yields = self._state.yields and route.goal is not None
        if not yields:
            self.halt()
        self._route, self._final_yaw = route, final_yaw
        self._trip += 1
        self._moved_aside = None
        self.rerouted, self._set_out = 0, self._env.now
        if yields:
            self._update_rank()
            # The other vehicle needs the place that it leaves; the route is planned again from where it makes room.
            self._enter(VehicleEvent.REDIRECT)
            self._arrived = Event(self._env)
            yield from self._arrival()
        else:
            yield from self._carry_out(self._driven(route.legs), VehicleEvent.SET_OUT)
        if self.stands and final_yaw is not None and final_yaw != self.motion.rest.yaw:
            # A base without a turning rate turns at once, and its drive has no piece for that.
            start, end = self.motion.rest, Pose(*self.motion.rest.point, final_yaw)
            self.motion.stand(end)
            self._publisher.publish_untraced(
                lambda: Piece(start, end, 0.0, 0.0, turned=turn(start.yaw, end.yaw)).event(self.name)
            )

    def _check_enabled(self) -> None:
        for cause, why in self.disabled_reasons.items():
            raise BaseDisabled(FollowPath.Result.UNKNOWN, why, cause)

    def perform(self, driven: Drive) -> Generator[Any, Any, None]:
        """Carry out a motion that begins here, regardless of obstacles; an interrupt stops it on the spot.

        Raises:
            BaseDisabled: It is disabled, or was disabled on the way.
        """
        self._check_enabled()
        self.halt()
        self._route = None
        yield from self._carry_out(driven, VehicleEvent.MANEUVER)

    def steer(self, speed: float, turning_rate: float, seconds: float) -> str:
        """Move at constant velocities without a goal, until an obstacle blocks it or another motion begins.

        Args:
            speed: The forward speed, negative for backwards, in the world's unit per second; limited to the maximum
                speed, regardless of acceleration.
            turning_rate: The turning rate in radians per second, limited to that of the base.
            seconds: The duration.

        Returns:
            The obstacle in its way; empty if there is none.
        """
        self.halt()
        self._route = None
        speed = math.copysign(min(abs(speed), self.speed), speed)
        rate = min(abs(turning_rate), self.base.turning_rate or math.inf)
        pieces: list[Piece] = []
        here, blocked, left = self.motion.rest, "", seconds if speed or rate else 0.0
        while left > _NANOSECOND and not blocked:
            step = min(left, _STEERING_STEP)
            piece = steered(here, speed, math.copysign(rate, turning_rate), step)
            if speed:
                end, blocked = self.graph.reach(here.point, piece.end.point, flies=self.flies)
            if blocked:
                length = distance(here.point, end)
                piece = piece.first(step * length / piece.length)
            if piece.duration > _NANOSECOND:
                pieces.append(piece)
            here, left = piece.end, left - step
        if pieces:
            self._enter(VehicleEvent.MANEUVER)
            self._arrived = Event(self._env)
            self._begin(drive_of(*pieces))
        return blocked

    def move_to(self, pose: Pose) -> None:
        """Place it at a pose at once; no goal that holds the base may be running."""
        self.halt()
        self.motion.stand(pose)
        self._entry, self._still_since = _NEVER_STOPPED, self._env.now
        self._moved_aside = None
        self._trips_in_place = 0
        self._admission.place(self)
        self._announce_change()

    def disable(self, cause: str, why: str) -> None:
        """Stop it, and keep it from acting until this and all other causes have ended."""
        self.disabled_reasons[cause] = why
        if self._state.maneuvers:
            self.give_up(BaseDisabled(FollowPath.Result.UNKNOWN, why, cause))
        else:
            self.halt()
        self._enter(VehicleEvent.DISABLE)

    def enable(self, cause: str) -> None:
        """End a cause for which it is disabled, if it is."""
        if self.disabled_reasons.pop(cause, None) is not None and not self.disabled_reasons:
            self._enter(VehicleEvent.ENABLE)
            if self.works:
                self._enter(VehicleEvent.WORK)
            if self._enabled is not None and not self._enabled.triggered:
                self._enabled.succeed()

    def wait_until_enabled(self, until: float) -> Generator[Any, Any, None]:
        """Wait while it is disabled, at most until a simulated time, in seconds, which may be infinite."""
        while self.disabled_reasons and self._env.now < until:
            self._enabled = Event(self._env)
            try:
                yield from self._env.wait(self._enabled, until)
            finally:
                self._enabled = None

    def begin_work(self) -> None:
        """Make it stand still, and make no room, until `finish_work`."""
        if not self._state.stands:
            self.halt()
        self.works = True
        self._trips_in_place = 0
        self._enter(VehicleEvent.WORK)

    def finish_work(self) -> None:
        """Finish the work; do nothing if the vehicle has moved on to something else."""
        self.works = False
        if not (self.busy and self._linger()):
            self._become_idle()

    def _become_idle(self) -> None:
        if self.busy:
            self._still_since = self._env.now
            self._enter(VehicleEvent.FINISH_WORK)
        self._admission.became_idle(self)

    def _linger(self) -> bool:
        """Keep it from making room for a while if its next goal needs time to come; return whether it does."""
        if not (self._lingers and self._admission.grace) or self.flies:
            return False
        self._enter(VehicleEvent.WORK)
        until = self._stays_until = self._env.now + self._admission.grace
        At(self._env, until, [lambda _event: self._become_idle() if self.stays_until == until else None])
        return True

    def stop_lingering(self) -> None:
        """Make room for others from now on, even if a goal has just ended here."""
        if self.stays_until:
            self._become_idle()

    def scale_speed(self, scale: float) -> None:
        """Set the share of its maximum speed at which it drives, now and later."""
        self.speed_scale = scale
        if self._route is None or self._state.stands:
            return
        if self._state.waits:
            self.motion.follow(self._driven(self.legs_ahead))
            self._enter(VehicleEvent.RESCALE)
            return
        leg, here = self.next_leg, self.pose().point
        rest = self.legs_ahead
        at_end = leg is not None and here == leg.end
        if at_end:
            rest = rest[1:]
        elif leg is not None and leg.ride:
            rest[0] = replace(leg, ride=leg.ride - self.motion.elapsed)
        elif leg is not None:
            rest[0] = replace(leg, start=here, length=distance(here, leg.end))
        if not rest:
            # It arrives at this instant, or turns at the end.
            return
        self.motion.stand(self.pose())
        self._enter(VehicleEvent.RESCALE)
        self._begin(self._driven(rest), admitted=leg is not None and not at_end)

    def halt(self) -> None:
        """Stop it where it is, and end its trip; do nothing if it stands."""
        if self._state.stands:
            return
        leg = None if self._state.waits or self.sets_out else self.next_leg
        motion, piece = self.motion, self.piece
        # A drive that begins at this instant starts at this speed.
        self._entry = self._env.now, piece.run_up(motion.elapsed) if piece else 0.0
        motion.stand(motion.pose())
        if self._state.moves:
            self._stop_progress()
        self._enter(VehicleEvent.HALT)
        self._admission.stopped(self, leg)
        self._announce_motion()
        self._publisher.publish(lambda: Stopped(self.name, motion.rest.point))

    def give_up(self, why: GoalAborted) -> None:
        """Stop it on its way, and fail the drive."""
        arrived = self._arrived
        self.halt()
        _fail(arrived, why)

    def _driven(self, legs: Sequence[Leg]) -> Drive:
        """Return the drive along legs from its position, with a turn to the final yaw of its trip, if any.

        A base that makes room leaves at once, as another one needs its place, and turns neither before nor after.
        """
        yields = self._state.yields
        if self._delays.any:
            legs = [self._delays.of(leg, self.name, self.speed, self._trip) for leg in legs]
        return self.graph.drives.drive(
            self.motion.pose(),
            legs,
            None if yields or self._route is None else self._final_yaw,
            speed=self.speed,
            acceleration=self.base.acceleration,
            turning_rate=None if yields else self.base.turning_rate,
            run_up=self._entry[1] if self._entry[0] == self._env.now else 0.0,
        )

    def _carry_out(self, driven: Drive, event: VehicleEvent) -> Generator[Any, Any, None]:
        if not driven.seconds:
            self._trips_in_place += 1
            if self._trips_in_place == 1:
                # A client that repeats this goal would otherwise keep it from ever making room.
                self._linger()
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
        """Begin a drive from its position, or wait; nothing may be scheduled for the previous one."""
        self._trips_in_place = 0
        self.motion.follow(driven)
        if self._publisher.interest.motion:
            self._publisher.publish_untraced(lambda: RouteTaken(self.name, [leg.end for leg in self.legs_ahead]))
        self._drive_on(0, admitted=admitted)

    def _end_way(self, _event: Event) -> None:
        """Continue after the last piece that needed no decision."""
        number = self.motion.last + 1
        if number > self.motion.final:
            self._arrive()
        else:
            self._drive_on(number)

    def _drive_on(self, number: int, *, admitted: bool = False) -> None:
        """Drive from a piece to the next decision if it is admitted; otherwise wait here."""
        motion, admission = self.motion, self._admission
        if motion.drive is None:
            raise AssertionError
        last = motion.final
        if (admission.needed or admission.waits) and self._state.needs_admission and not self.flies:
            leg = motion.drive.legs[number]
            if not (admitted or leg is None or admission.admit(self, leg)):
                self._block(number)
                admission.decide(self)
                return
            last = number if admission.by_legs else admission.sure_up_to(self, motion.drive.legs, number)
        sets_out = not motion.drives
        motion.begin(number, self._with_speed(number, last) if self._follows_speed else last)
        if sets_out or self._follows_speed or self._motion_change is not None:
            self._announce_motion()
        if self._publisher.interest.motion:
            self._publisher.publish_untraced(lambda: motion.event(self.name))

    def _with_speed(self, number: int, last: int) -> int:
        """Return the last piece, at most *last*, up to which it keeps its mean speed."""
        while number < last and self.motion.keeps_speed(number):
            number += 1
        return number

    def look_ahead(self) -> None:
        """Request the next lane that needs a decision now, as more can block it than when it began."""
        motion = self.motion
        if motion.drive is None or not self._state.moves or not self._state.needs_admission or self.flies:
            return
        motion.catch_up()
        last = self._admission.sure_up_to(self, motion.drive.legs, motion.number)
        if last < motion.last:
            motion.shorten(last)

    def _block(self, number: int) -> None:
        """Make it wait before a piece of its drive."""
        self.motion.wait_at(number)
        self._stop_progress()
        self._enter(VehicleEvent.BLOCK)
        self.recoveries += 1
        self._announce_motion()

    def _arrive(self) -> None:
        motion, arrived = self.motion, self._arrived
        if motion.drive is None or arrived is None:
            raise AssertionError
        motion.stand(motion.drive.end)
        self._stop_progress()
        self._enter(VehicleEvent.ARRIVE)
        if self.stands:
            self._linger()
        self._admission.arrived(self)
        self._announce_motion()
        if self._state is VehicleState.YIELDED:
            self._plan_on()
        else:
            self._env.succeed(arrived)

    def _plan_on(self) -> None:
        """Plan the rest of its trip, if any, from where it has made room."""
        goal = self.goal
        if goal is None:
            self._enter(VehicleEvent.ARRIVE)
        else:
            try:
                route = self._admission.plan(self, self.motion.rest.point, goal)
            except NoRoute as error:
                self.give_up(error)
                return
            self._route = route
            driven = self._driven(route.legs)
            if driven.seconds:
                self.motion.follow(driven)
            else:
                # Where it has yielded is where it was going.
                self._enter(VehicleEvent.ARRIVE)
                self._linger()
                if self._arrived is not None:
                    self._arrived.succeed()
        self._admission.yielded(self)

    def go_on(self) -> None:
        """Drive the leg for which it waits, or begin its maneuver, after it was admitted."""
        drive = self.motion.drive
        if drive is None or drive.in_pieces or self._state is VehicleState.MANEUVER_BLOCKED:
            self._enter(VehicleEvent.RESUME)
            self._drive_on(self.motion.number, admitted=True)
        else:
            driven = self._driven(self.legs_ahead)
            self._enter(VehicleEvent.RESUME)
            self._begin(driven, admitted=True)

    def ask_again(self) -> None:
        """Request its leg again if it waits, and drive on or keep waiting."""
        if self.motion.drive is not None and self._state.waits:
            self._enter(VehicleEvent.RESUME)
            self._begin(self.motion.drive)

    def step_back(self) -> None:
        """Take the right of way back at the instant of its departure, so that it waits."""
        self._block(self.motion.number)

    def reroute(self, avoid: Collection[Lane]) -> bool:
        """Take another route without these lanes from where it waits; return whether there is one."""
        goal = self.goal
        if goal is None or not self._state.waits:
            return False
        try:
            route = self._admission.plan(self, self.pose().point, goal, avoid)
        except NoRoute:
            return False
        ahead = self.next_leg
        if ahead is not None and route.legs and (route.legs[0].start, route.legs[0].end) == (ahead.start, ahead.end):
            # It waits in the middle of a lane, and the other route begins with the blocked leg, too.
            return False
        self.rerouted += 1
        self.take_route(route)
        return True

    def take_route(self, route: Route) -> None:
        """Take a route from where it waits, and request its legs anew."""
        self._route = route
        self.recoveries += 1
        self._publisher.publish(lambda: Rerouted(self.name, self.pose().point))
        # It may have to turn first, and request a leg later.
        self._admission.forget(self)
        driven = self._driven(route.legs)
        self._enter(VehicleEvent.REROUTE)
        self._begin(driven)

    def yield_along(self, legs: Sequence[Leg], by: str, *, rerouted: bool = False) -> None:
        """Make room for another vehicle by driving legs from where it stands, whose slots it already holds.

        Afterwards it resumes its trip, if it has one, when the traffic policy allows that. *rerouted* says whether this
        counts as another route.
        """
        here, stood, first = self.pose().point, self._state.stands, legs[0]
        self._enter(VehicleEvent.YIELD)
        if stood:
            self._route, self._arrived = None, Event(self._env)
            self._moved_aside = (self._moved_aside or (here,))[0], by, self._env.now
        self.motion.stand(self.motion.rest)
        self.rerouted += rerouted
        if here != first.start:
            # It stands beside the waypoint, for example after backing up.
            first = replace(first, start=here, length=distance(here, first.end))
        self._begin(self._driven([first, *legs[1:]]), admitted=True)


def _fail(arrived: Event | None, why: GoalAborted) -> None:
    if arrived is not None and not arrived.triggered:
        arrived.fail(why)
        # There may be no goal to fail, for example while it makes room.
        arrived.defused = True
