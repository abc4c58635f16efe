"""A mobile base: what its robot plans and commands."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from simpy import Event

from hmrsim.engine.environment import At
from hmrsim.errors import BaseDisabled
from hmrsim.geometry import Pose, distance, turn
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.navigation.motion import Piece
from hmrsim.robots.vehicle_body import NEVER_STOPPED
from hmrsim.robots.vehicle_driving import DrivingVehicle
from hmrsim.robots.vehicle_state import VehicleEvent, VehicleState

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import WaypointGraph
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Route


class MobileBase(DrivingVehicle):
    """A base that drives, or flies."""

    __slots__ = ()

    def plan_to(self, goal: Point, start: Point | None = None) -> Route:
        """Return the quickest route from where it is, or from *start*.

        Raises:
            NoRoute: The goal or *start* is outside the map or inside an obstacle, or no route leads there.
        """
        if not self.flies:
            return self.plan_on_lanes(goal, start)
        if start is not None:
            self._graph.check_start(start)
        return self._graph.fly(self.pose().point if start is None else start, goal)

    def plan_on_lanes(self, goal: Point, start: Point | None = None) -> Route:
        """Return the quickest route along the lanes, for a robot that flies, too.

        Raises:
            NoRoute: As `plan_to` says.
        """
        if start is not None:
            self._graph.check_start(start)
        return self._admission.plan(self, self.pose().point if start is None else start, goal)

    @property
    def graph(self) -> WaypointGraph:
        """The graph on which it drives."""
        return self._graph

    def watch(self, seconds: float = math.inf) -> Generator[Any, Any, None]:
        """Wait until it begins another lane or turn, its motion or the open lanes change, or for some seconds."""
        woken = Event(self._env)

        def wake(_event: Event) -> None:
            if not woken.triggered:
                woken.succeed()

        # No condition of simpy: if its process were interrupted it would stay with events that may never happen.
        until = min(self._env.now + seconds, self.piece_ends)
        over = At(self._env, until, []) if until < math.inf else None
        events = [event for event in (self._motion_changes(), self._admission.lanes_change(), over) if event]
        for event in events:
            event.callbacks.append(wake)
        try:
            yield woken
        finally:
            for event in events:
                if not event.processed:
                    event.callbacks.remove(wake)
            if over is not None and not over.processed:
                self._env.abandon(over)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the route from where it is straight from point to point, and what is in its way; or ""."""
        return self.straight_along([self.pose().point, *points])

    def straight_along(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the route straight from the first of some points to the last, and what is in its way; or ""."""
        return self._graph.straight_through(points, flies=self.flies)

    def reach(self, point: Point) -> tuple[Point, str]:
        """Return how far it gets straight towards *point*, and what stops it before; or ""."""
        return self._graph.reach(self.pose().point, point, flies=self.flies)

    def drive(self, route: Route, final_yaw: float | None) -> Generator[Any, Any, None]:
        """Drive a route that begins here, then face *final_yaw*, if any; an interrupt stops it where it is.

        Raises:
            GoalAborted: Something is in its way for too long, it can go no further, or it is disabled.
        """
        self._check_enabled()
        yields = self._state.yields and route.goal is not None
        if not yields:
            self.halt()
        self._route, self._final_yaw = route, final_yaw
        self._trip += 1
        self.rerouted, self._set_out = 0, self._env.now
        if yields:
            self._update_rank()
            # The other vehicle counts on the place that it leaves; the route is planned again from where it yields.
            self._enter(VehicleEvent.REDIRECT)
            self._arrived = Event(self._env)
            yield from self._arrival()
        else:
            yield from self._carry_out(self._driven(route.legs), VehicleEvent.SET_OUT)
        if self.stands and final_yaw is not None and final_yaw != self._rest.yaw:
            # Without a turning rate no piece of the drive says so.
            start, end = self._rest, Pose(*self._rest.point, final_yaw)
            self._rest = end
            self._publisher.publish_untraced(
                lambda: Piece(start, end, 0.0, 0.0, turned=turn(start.yaw, end.yaw)).event(self.name)
            )

    def _check_enabled(self) -> None:
        for cause, why in self.disabled_reasons.items():
            raise BaseDisabled(FollowPath.Result.UNKNOWN, why, cause)

    def perform(self, driven: Drive) -> Generator[Any, Any, None]:
        """Carry out a motion that begins here, without regard to obstacles; an interrupt stops it where it is.

        Raises:
            BaseDisabled: It is disabled, or was meanwhile and has stopped.
        """
        self._check_enabled()
        self.halt()
        self._route = None
        yield from self._carry_out(driven, VehicleEvent.MANEUVER)

    def move_to(self, pose: Pose) -> None:
        """Stand somewhere else at once; no goal that holds the base may be running."""
        self.halt()
        self._rest, self._entry, self._still_since = pose, NEVER_STOPPED, self._env.now
        self._admission.place(self)
        self._announce_change()

    def disable(self, cause: str, why: str) -> None:
        """Stop, and be able to do nothing until this and all other causes are gone."""
        self.disabled_reasons[cause] = why
        if self._state.maneuvers:
            self.give_up(BaseDisabled(FollowPath.Result.UNKNOWN, why, cause))
        else:
            self.halt()
        self._enter(VehicleEvent.DISABLE)

    def enable(self, cause: str) -> None:
        """Be disabled by this cause no longer; nothing happens if it is not."""
        if self.disabled_reasons.pop(cause, None) is not None and not self.disabled_reasons:
            self._enter(VehicleEvent.ENABLE)
            if self._works:
                self._enter(VehicleEvent.WORK)
            if self._enabled is not None and not self._enabled.triggered:
                self._enabled.succeed()

    def wait_until_enabled(self, until: float) -> Generator[Any, Any, None]:
        """Wait as long as it is disabled, but only until a point of simulated time; infinity is none."""
        while self.disabled_reasons and self._env.now < until:
            self._enabled = woken = Event(self._env)

            def wake(_event: Event, woken: Event = woken) -> None:
                if not woken.triggered:
                    woken.succeed()

            over = At(self._env, until, [wake]) if until < math.inf else None
            try:
                yield woken
            finally:
                self._enabled = None
                if over is not None and not over.processed:
                    self._env.abandon(over)

    def begin_work(self) -> None:
        """Stand still until `finish_work`, and yield to no other vehicle."""
        if not self._state.stands:
            self.halt()
        self._works = True
        self._enter(VehicleEvent.WORK)

    def finish_work(self) -> None:
        """Finish the work; do nothing if the vehicle has moved on to something else."""
        self._works = False
        if self._state is VehicleState.WORKING:
            self._still_since = self._env.now
            self._enter(VehicleEvent.FINISH_WORK)
        self._admission.became_idle(self)

    def scale_speed(self, scale: float) -> None:
        """Go at this share of its maximum speed, also on the route that it drives now."""
        self.speed_scale = scale
        if self._route is None or self._state.stands:
            return
        if self._state.waits:
            self._follow(self._driven(self.legs_ahead))
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
        self._abandon_way()
        self._drive = None
        self._enter(VehicleEvent.RESCALE)
        self._begin(self._driven(rest), admitted=leg is not None and not at_end)
