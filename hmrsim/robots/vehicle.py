"""Something that moves: where it is, and how it gets from place to place.

A place is a formula of time while it moves: there is one event a lane, none in between.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from simpy import Event, Timeout
from simpy.events import NORMAL

from hmrsim.errors import NoRoute
from hmrsim.events.robots import RouteTaken, Stopped
from hmrsim.events.traffic import Rerouted
from hmrsim.geometry import Pose, distance, turn
from hmrsim.navigation.motion import Piece, Progress, drive

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Generator, Sequence

    from hmrsim.engine.environment import Environment
    from hmrsim.engine.subscriptions import Happenings
    from hmrsim.errors import GoalAborted
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.admission import Passage
    from hmrsim.world.model import Base

_STANDS: Final = (-1.0, 0.0)
"""When it was stopped, and the run-up that it had then, of something that was not."""


class Mobile:
    """A base that drives, or flies.

    Args:
        env: The simulation's clock and events.
        name: Its name.
        base: What moves it.
        speed: How fast, in the world's unit a second.
        home: Where it stands in the beginning.
        graph: The ways open to it.
        passage: Says what is in its way.
        happened: Tells what it does.

    Attributes:
        name: Its name.
        base: What moves it.
        radius: Of its footprint; 0 if it has none.
        flies: Whether nothing on the ground is in its way.
        home: Where it stands in the beginning.
        slots: What it occupies, where traffic counts; the rules of traffic keep it.
        recoveries: How often it had to wait or to take another way, since the beginning.
        rerouted: How often it has taken another way on this trip.
        set_out: When it began this trip, in simulated seconds.
        slowness: What its speed is multiplied with; see `retime`.
        busy: Whether it has something to do where it stands, so that it can't make room for anybody.
        changed: Called whenever it begins or ceases to move, or moves at another speed; None to call nobody.
    """

    # More attributes than a class can share the names of among its objects: each would have a large table of its own.
    __slots__ = (
        "_arrived",
        "_aside",
        "_began",
        "_drive",
        "_env",
        "_graph",
        "_happened",
        "_heeds",
        "_number",
        "_on_piece_end",
        "_passage",
        "_piece_ends",
        "_rest",
        "_run_up",
        "_seconds",
        "_speed",
        "_waits",
        "_way",
        "base",
        "busy",
        "changed",
        "flies",
        "home",
        "name",
        "radius",
        "recoveries",
        "rerouted",
        "set_out",
        "slots",
        "slowness",
    )

    def __init__(
        self,
        env: Environment,
        name: str,
        base: Base,
        *,
        speed: float,
        home: Pose,
        graph: WaypointGraph,
        passage: Passage,
        happened: Happenings,
    ) -> None:
        self.name = name
        self.radius = base.radius or 0.0
        self.flies = base.flies
        self.home = home
        self.slots: tuple[int, ...] = ()
        self.recoveries = self.rerouted = 0
        self.set_out = 0.0
        self.slowness = 1.0
        self.busy = False
        self.changed: Callable[[], None] | None = None
        self._env = env
        self.base = base
        self._speed = speed
        self._graph = graph
        self._passage = passage
        self._happened = happened
        self._rest = home
        self._run_up = _STANDS
        self._drive: Drive | None = None
        self._way: tuple[Route, float | None] | None = None
        self._number = 0
        self._seconds: Sequence[float] = ()
        self._waits = False
        self._heeds = False
        self._aside = False
        self._piece_ends: Timeout | None = None
        self._arrived: Event | None = None
        self._on_piece_end: list[Callable[[Any], None]] = [self._begin_next]
        self._began = 0.0

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self._env.now

    # --- where it is ----------------------------------------------------------------------------------------------

    def progress(self) -> Progress:
        """Return where it is now, and how far it still has to go; nothing is left when it stands."""
        if self._drive is None:
            return Progress(self._rest)
        return self._drive.progress(self._number, 0.0 if self._waits else self._env.now - self._began)

    def pose(self) -> Pose:
        """Return where its centre is now and which way it faces."""
        return self.progress().pose

    @property
    def piece(self) -> Piece | None:
        """The lane or the turn that it drives just now; None when it stands, or has to wait."""
        return None if self._drive is None or self._waits else self._drive.piece(self._number)

    @property
    def next_leg(self) -> Leg | None:
        """The leg that it drives just now, or waits for; None when it stands, or turns."""
        return None if self._drive is None else self._drive.legs[self._number]

    @property
    def legs_ahead(self) -> list[Leg]:
        """The legs that it has not driven to their ends; none when it stands."""
        return [] if self._drive is None else [leg for leg in self._drive.legs[self._number :] if leg]

    @property
    def waits(self) -> bool:
        """Whether something is in its way, so that it stands on its way."""
        return self._waits

    @property
    def stands(self) -> bool:
        """Whether it stands, and wants to go nowhere."""
        return self._drive is None

    @property
    def sets_out(self) -> bool:
        """Whether it begins to drive a leg or to turn at this very instant."""
        return self._drive is not None and not self._waits and self._began == self._env.now

    @property
    def moves(self) -> bool:
        """Whether it is on its way, and nothing is in it."""
        return self._drive is not None and not self._waits

    @property
    def speed(self) -> float:
        """The greatest speed that it can go now, in the world's unit a second."""
        return self._speed * self.slowness

    def velocity(self) -> tuple[float, float]:
        """Return the speed ahead and the turning rate, now; of a constant-speed piece, or its mean."""
        piece = self.piece
        return (0.0, 0.0) if piece is None else piece.velocity

    @property
    def distance_remaining(self) -> float:
        """What is left of the route that it drives; 0 when it stands."""
        return self.progress().length

    def distance_to(self, point: Point) -> float:
        """Return how far its centre is from *point*."""
        return distance(self.pose().point, point)

    # --- what is done to it ---------------------------------------------------------------------------------------

    def move_to(self, pose: Pose) -> None:
        """Stand somewhere else at once; no goal that holds the base may be running."""
        self.halt()
        self._rest, self._run_up = pose, _STANDS
        self._passage.place(self)

    def halt(self) -> None:
        """Stand still here, wherever it was going; nothing happens if it stands."""
        if self._drive is None:
            return
        leg = None if self._waits or self.sets_out else self.next_leg
        piece = self.piece
        # Whoever has it drive on at this instant finds it as fast as it is.
        self._run_up = self._env.now, piece.run_up(self._env.now - self._began) if piece else 0.0
        self._rest = self.pose()
        if self._piece_ends is not None:
            self._env.abandon(self._piece_ends)
        self._drive = self._piece_ends = None
        self._waits = self._aside = False
        self._passage.stopped(self, leg)
        if self.changed is not None:
            self.changed()
        self._happened.publish(lambda: Stopped(self.name, self._rest.point))

    def give_up(self, why: GoalAborted) -> None:
        """Stop on its way, and end what it drives for."""
        arrived = self._arrived
        self.halt()
        if arrived is not None and not arrived.triggered:
            arrived.fail(why)
            # It may be on its way for nobody's sake.
            arrived.defused = True

    # --- what it does ---------------------------------------------------------------------------------------------

    def plan_to(self, goal: Point, start: Point | None = None) -> Route:
        """Return the quickest route from where it is, or from *start*.

        Raises:
            NoRoute: The goal or *start* is outside the map, inside an obstacle, or no way leads there.
        """
        if start is None:
            start = self.pose().point
        else:
            self._graph.check_start(start)
        return self._graph.fly(start, goal) if self.flies else self._passage.plan(self, start, goal)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the way from where it is straight from point to point, and what stands in it; or ""."""
        return self._graph.straight_through([self.pose().point, *points], flies=self.flies)

    def reach(self, point: Point) -> tuple[Point, str]:
        """Return how far it gets straight towards *point*, and what stops it before; or ""."""
        return self._graph.reach(self.pose().point, point, flies=self.flies)

    def drive(self, route: Route, final_yaw: float | None) -> Generator[Any, Any, None]:
        """Drive a route that begins here, then face *final_yaw*, if any; an interrupt stops it where it is.

        Raises:
            GoalAborted: Something is in its way for too long, or it can go no further.
        """
        if self._aside and route.goal is not None:
            # It makes room for somebody who counts on it; then it plans anew.
            yield from self._finish(route, final_yaw)
        else:
            self.halt()
            self._way = route, final_yaw
            self.rerouted, self.set_out = 0, self._env.now
            yield from self._carry_out(self._driven(route.legs), heeds=not self.flies)
        if self.stands and final_yaw is not None and final_yaw != self._rest.yaw:
            # Without a turning rate no piece of the drive says so.
            start, self._rest = self._rest, Pose(*self._rest.point, final_yaw)
            turned = Piece(start, self._rest, 0.0, 0.0, turned=turn(start.yaw, final_yaw))
            self._happened.publish_untraced(lambda: turned.event(self.name))

    def perform(self, driven: Drive) -> Generator[Any, Any, None]:
        """Carry out a motion that begins here, whatever is in its way; an interrupt stops it where it is."""
        self.halt()
        self._way = None
        yield from self._carry_out(driven, heeds=False)

    def _driven(self, legs: Sequence[Leg]) -> Drive:
        """Return how it drives legs from where it is, and then turns to the final yaw of its way, if any.

        Who makes room is off at once, for whoever comes counts on it, and does not turn before or afterwards.
        """
        return drive(
            self.pose(),
            legs,
            self._way[1] if self._way and not self._aside else None,
            speed=self.speed,
            acceleration=self.base.acceleration,
            turning_rate=None if self._aside else self.base.turning_rate,
            run_up=self._run_up[1] if self._run_up[0] == self._env.now else 0.0,
        )

    def _carry_out(self, driven: Drive, *, heeds: bool) -> Generator[Any, Any, None]:
        if not driven.seconds:
            return
        self._heeds = heeds
        self._arrived = Event(self._env)
        self._begin(driven)
        yield from self._arrival()

    def _finish(self, route: Route, final_yaw: float | None) -> Generator[Any, Any, None]:
        """Go on where a route leads after what it drives just now."""
        self._way = route, final_yaw
        self.rerouted, self.set_out = 0, self._env.now
        self._arrived = Event(self._env)
        yield from self._arrival()

    def _arrival(self) -> Generator[Any, Any, None]:
        try:
            yield self._arrived
        except BaseException:
            self.halt()
            raise

    def _begin(self, driven: Drive, *, admitted: bool = False) -> None:
        """Begin a drive from where it is, or wait; nothing may be scheduled for the one before."""
        self._drive, self._seconds, self._number, self._waits = driven, driven.seconds, 0, False
        self._began = self._env.now
        if self._happened.interest.motion:
            self._happened.publish_untraced(lambda: RouteTaken(self.name, [leg.end for leg in self.legs_ahead]))
        if admitted or self._may_begin(0):
            self._set_out(0)

    def _set_out(self, number: int) -> None:
        """Begin a piece of the drive; `_begin_next` goes on from there.

        One timeout is scheduled anew for each piece, past the process that drives: with many robots that is half
        the work of the whole simulation.
        """
        self._number, self._began, self._waits = number, self._env.now, False
        self._piece_ends = Timeout(self._env, self._seconds[number])
        self._piece_ends.callbacks = self._on_piece_end
        self._moves()

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
            self._moves()

    def _moves(self) -> None:
        if self.changed is not None:
            self.changed()
        if self._happened.interest.motion and (piece := self.piece):
            self._happened.publish_untraced(lambda: piece.event(self.name))

    def _may_begin(self, number: int) -> bool:
        """Return whether nothing is in the way of a piece of its drive; if something is, it waits here."""
        leg = self._drive.legs[number] if self._drive and self._heeds else None
        if leg is None or self._passage.admit(self, leg):
            return True
        self._number, self._piece_ends, self._waits = number, None, True
        self.recoveries += 1
        if self.changed is not None:
            self.changed()
        self._passage.decide(self)
        return False

    def _arrive(self) -> None:
        driven, arrived = self._drive, self._arrived
        if driven is None or arrived is None:
            raise AssertionError
        last = driven.piece(len(self._seconds) - 1)
        self._rest, self._drive, self._piece_ends = last.end, None, None
        self._passage.arrived(self)
        if self.changed is not None:
            self.changed()
        if self._aside:
            self._aside = False
            self._stay_aside()
        else:
            arrived.succeed()

    def motion(self) -> dict[str, Any] | None:
        """Return the piece that is being driven, as an observer sees it; None when it stands, or has to wait."""
        piece = self.piece
        return piece.describe() if piece else None

    @property
    def began(self) -> float:
        """When it began the piece that it drives just now, in simulated seconds."""
        return self._began

    def route(self) -> list[list[float]]:
        """Return the points that it still drives to, as JSON values; none when it stands."""
        return [[*leg.end] for leg in self.legs_ahead]

    # --- when something is in its way -----------------------------------------------------------------------------

    def go_on(self) -> None:
        """Drive on from where it waits: what was in its way has let it pass."""
        if self._drive is None or not self._waits:
            return
        if self._drive.in_pieces:
            self._set_out(self._number)
        else:
            self._begin(self._driven(self.legs_ahead), admitted=True)

    def step_back(self) -> None:
        """Not have set out at this instant after all, and wait."""
        if self._piece_ends is not None:
            self._env.abandon(self._piece_ends)
        self._piece_ends, self._waits = None, True
        self.recoveries += 1
        if self.changed is not None:
            self.changed()

    def reroute(self, avoid: Collection[Lane]) -> bool:
        """Take another way from where it waits, without these lanes; return whether there is one."""
        way = self._way
        if way is None or way[0].goal is None or not self._waits:
            return False
        try:
            route = self._passage.plan(self, self.pose().point, way[0].goal, avoid)
        except NoRoute:
            return False
        if route.legs and route.legs[0] == self.next_leg:
            # It begins with what is in the way, where it waits in the middle of a lane.
            return False
        self._way = route, way[1]
        self.recoveries += 1
        self.rerouted += 1
        self._happened.publish(lambda: Rerouted(self.name, self.pose().point))
        # It may have to turn first, and then asks later.
        self._passage.forget(self)
        self._begin(self._driven(route.legs))
        return True

    def sidestep(self, leg: Leg) -> None:
        """Make room for somebody by driving a leg from where it stands; it is admitted already.

        Then it goes on to where it was going, if anywhere, when the rules of traffic say so.
        """
        here = self.pose().point
        if self._drive is None:
            self._way, self._arrived, self._heeds = None, Event(self._env), True
        self._drive, self._aside = None, True
        if here != leg.start:
            # It stands beside the waypoint, as after backing up.
            leg = replace(leg, start=here, length=distance(here, leg.end))
        self._begin(self._driven([leg]), admitted=True)

    def _stay_aside(self) -> None:
        """Wait until it may go on, having made room for somebody."""
        way = self._way
        if way is not None and way[0].goal is not None:
            try:
                route = self._passage.plan(self, self._rest.point, way[0].goal)
            except NoRoute as error:
                self.give_up(error)
                return
            self._way = route, way[1]
            driven = self._driven(route.legs)
            if driven.seconds:
                self._drive, self._seconds, self._number, self._waits = driven, driven.seconds, 0, True
            elif self._arrived is not None:
                # Where it has made room is where it was going.
                self._arrived.succeed()
        self._passage.made_room(self)

    @property
    def may_make_room(self) -> bool:
        """Whether it stands, and could go somewhere else for a while."""
        if self._drive is None:
            return not self.busy
        return self._waits and self._way is not None and self._way[0].goal is not None

    def ask_again(self) -> None:
        """Drive on from where it has made room, or wait there."""
        if self._drive is not None and self._waits:
            self._begin(self._drive)

    def retime(self) -> None:
        """Go on at the speed that it can go now."""
        if self._drive is None or self._way is None:
            return
        if self._waits:
            self._drive = self._driven(self.legs_ahead)
            self._seconds, self._number = self._drive.seconds, 0
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
        self._begin(self._driven(rest), admitted=leg is not None and not at_end)
