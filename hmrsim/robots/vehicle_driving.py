"""Driving: a vehicle drives one lane or turn after the other, each lane when traffic admits it.

There is one event where something is to be decided, such as whether it may drive the next lane, and none in between:
where nothing can be in its way, a whole route is one event.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from simpy import Event

from hmrsim.engine.environment import At
from hmrsim.errors import NoRoute
from hmrsim.events.robots import RouteTaken, Stopped
from hmrsim.events.traffic import Rerouted
from hmrsim.geometry import distance
from hmrsim.robots.vehicle_body import VehicleBody
from hmrsim.robots.vehicle_state import VehicleEvent, VehicleState

if TYPE_CHECKING:
    from hmrsim.errors import GoalAborted
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Leg, Route


class DrivingVehicle(VehicleBody):
    """A vehicle that carries out drives, can be stopped anywhere, and yields to others; see `Vehicle`."""

    __slots__ = ()

    def halt(self) -> None:
        """Stop here, wherever it was going; nothing happens if it stands."""
        if self._state.stands:
            return
        leg = None if self._state.waits or self.sets_out else self.next_leg
        piece = self.piece
        # A drive that begins at this instant begins at this speed.
        self._entry = self._env.now, piece.run_up(self._env.now - self._began) if piece else 0.0
        self._rest = self.pose()
        self._abandon_way()
        self._drive = None
        if self._state.moves:
            self._stop_progress()
        self._enter(VehicleEvent.HALT)
        self._admission.stopped(self, leg)
        if self._changed is not None:
            self._changed()
        self._publisher.publish(lambda: Stopped(self.name, self._rest.point))

    def give_up(self, why: GoalAborted) -> None:
        """Stop on its way, and fail the drive."""
        arrived = self._arrived
        self.halt()
        _fail(arrived, why)

    def _driven(self, legs: Sequence[Leg]) -> Drive:
        """Return how it drives legs from where it is, and then turns to the final yaw of its trip, if any.

        A base that yields leaves at once, since another one counts on its place, and turns neither before nor after.
        """
        yields = self._state.yields
        if self._delays:
            legs = [self._delays.of(leg, self.name, self.speed, self._trip) for leg in legs]
        return self._graph.drives.drive(
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
        self._follow(driven)
        self._began = self._env.now
        if self._publisher.interest.motion:
            self._publisher.publish_untraced(lambda: RouteTaken(self.name, [leg.end for leg in self.legs_ahead]))
        if admitted or self._may_begin(0):
            self._begin_way(0)

    def _follow(self, driven: Drive) -> None:
        """Take a drive, of which no piece is begun yet."""
        self._drive, self._seconds = driven, driven.seconds
        self._number = self._last = 0

    def _begin_way(self, number: int) -> None:
        """Begin a piece of the drive, and drive up to where something is to be decided; `_go_on` goes on from there.

        One event is scheduled anew for each way, past the process that drives: with many robots that is half the work
        of the whole simulation.
        """
        self._number, self._began = number, self._env.now
        self._last = self._sure_up_to(number)
        self._expect_way_end()
        self._publish_motion()

    def _go_on(self, way_end: Event) -> None:
        """Decide what comes after the end of a way."""
        if way_end is not self._way_end:
            # It was stopped on that way.
            return
        number = self._last + 1
        if number == len(self._seconds):
            self._number = self._last
            self._arrive()
        elif not self._admission.needed or self._may_begin(number):
            self._number, self._began = number, self._env.now
            self._last = self._sure_up_to(number)
            way_end.callbacks = self._on_way_end
            self._env.schedule_at(way_end, self._way_ends())
            self._publish_motion()

    def _sure_up_to(self, number: int) -> int:
        """Return up to which piece it drives on from one that it may drive, before something is to be decided."""
        if self._admission.needed and self._drive and self._state.needs_admission and not self.flies:
            last = self._admission.sure_up_to(self, self._drive.legs, number)
        else:
            last = len(self._seconds) - 1
        if self._follows_speed and self._drive:
            velocity = self._drive.piece(number).velocity
            while number < last and self._drive.piece(number + 1).velocity == velocity:
                number += 1
            return number
        return last

    def _way_ends(self) -> float:
        """Return when it ends the last piece of its way."""
        at = self._began
        for seconds in self._seconds[self._number : self._last + 1]:
            at += seconds
        return at

    def look_ahead(self) -> None:
        """Decide at the next lane that is no longer sure, as more can be in its way than when it began."""
        if not self._state.moves:
            return
        self._catch_up()
        last = self._sure_up_to(self._number)
        if last < self._last:
            self._abandon_way()
            self._last = last
            self._expect_way_end()

    def _expect_way_end(self) -> None:
        """Decide what comes next when it has driven the last piece of its way."""
        self._on_way_end = [self._go_on]
        self._way_end = At(self._env, self._way_ends(), self._on_way_end)

    def _abandon_way(self) -> None:
        """Let nothing happen at the end of its way."""
        if self._way_end is not None:
            self._env.abandon(self._way_end)
            self._way_end = None

    def _publish_motion(self) -> None:
        if self._changed is not None:
            self._changed()
        if self._publisher.interest.motion:
            self._publisher.publish_untraced(self._motion_began)

    def _may_begin(self, number: int) -> bool:
        """Return whether it is admitted to a piece of its drive; if not, it waits here."""
        leg = self._drive.legs[number] if self._drive and self._state.needs_admission and not self.flies else None
        if leg is None or self._admission.admit(self, leg):
            return True
        self._number = self._last = number
        self._block()
        self._admission.decide(self)
        return False

    def _block(self) -> None:
        self._stop_progress()
        self._enter(VehicleEvent.BLOCK)
        self._way_end = None
        self.recoveries += 1
        if self._changed is not None:
            self._changed()

    def _arrive(self) -> None:
        driven, arrived = self._drive, self._arrived
        if driven is None or arrived is None:
            raise AssertionError
        self._rest, self._drive, self._way_end = driven.end, None, None
        self._stop_progress()
        self._enter(VehicleEvent.ARRIVE)
        self._admission.arrived(self)
        if self._changed is not None:
            self._changed()
        if self._state is VehicleState.YIELDED:
            self._plan_on()
        else:
            self._env.succeed(arrived)

    def _plan_on(self) -> None:
        """Plan the rest of its trip, if any, from where it has yielded."""
        goal = self.goal
        if goal is None:
            self._enter(VehicleEvent.ARRIVE)
        else:
            try:
                route = self._admission.plan(self, self._rest.point, goal)
            except NoRoute as error:
                self.give_up(error)
                return
            self._route = route
            driven = self._driven(route.legs)
            if driven.seconds:
                self._follow(driven)
            else:
                # Where it has yielded is where it was going.
                self._enter(VehicleEvent.ARRIVE)
                if self._arrived is not None:
                    self._arrived.succeed()
        self._admission.yielded(self)

    def go_on(self) -> None:
        """Drive the leg for which it waits, or begin its maneuver: it is admitted now."""
        if self._drive is None or self._drive.in_pieces or self._state is VehicleState.MANEUVER_BLOCKED:
            self._enter(VehicleEvent.RESUME)
            self._begin_way(self._number)
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
        self._last = self._number
        self._abandon_way()
        self._block()

    def reroute(self, avoid: Collection[Lane]) -> bool:
        """Take another route from where it waits, without these lanes; return whether there is one."""
        goal = self.goal
        if goal is None or not self._state.waits:
            return False
        try:
            route = self._admission.plan(self, self.pose().point, goal, avoid)
        except NoRoute:
            return False
        ahead = self.next_leg
        if ahead is not None and route.legs and (route.legs[0].start, route.legs[0].end) == (ahead.start, ahead.end):
            # It begins with what is in the way, where it waits in the middle of a lane.
            return False
        self.rerouted += 1
        self.take_route(route)
        return True

    def take_route(self, route: Route) -> None:
        """Take a route from where it waits; it asks for the right of way again."""
        self._route = route
        self.recoveries += 1
        self._publisher.publish(lambda: Rerouted(self.name, self.pose().point))
        # It may have to turn first, and then asks later.
        self._admission.forget(self)
        driven = self._driven(route.legs)
        self._enter(VehicleEvent.REROUTE)
        self._begin(driven)

    def yield_along(self, legs: Sequence[Leg], *, rerouted: bool = False) -> None:
        """Yield to another vehicle by driving legs from where it stands, to which it is admitted already.

        Then it goes on to where it was going, if anywhere, when the traffic policy lets it. *rerouted* says whether
        this counts as another route.
        """
        here, stood, first = self.pose().point, self._state.stands, legs[0]
        self._enter(VehicleEvent.YIELD)
        if stood:
            self._route, self._arrived = None, Event(self._env)
        self._drive = None
        self.rerouted += rerouted
        if here != first.start:
            # It stands beside the waypoint, as after backing up.
            first = replace(first, start=here, length=distance(here, first.end))
        self._begin(self._driven([first, *legs[1:]]), admitted=True)


def _fail(arrived: Event | None, why: GoalAborted) -> None:
    if arrived is not None and not arrived.triggered:
        arrived.fail(why)
        # It may have no goal, as when it yields.
        arrived.defused = True
