"""The admission of vehicles to lanes: it asks closed lanes, barriers such as doors, and the traffic policy.

A vehicle requests each leg before it begins it. If it is not admitted, it waits where it is, and requests again when
the answer may have changed. In a world where nothing can block a vehicle, vehicles request nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from simpy import Event

from hmrsim.engine.environment import At
from hmrsim.errors import GoalAborted, NoRoute
from hmrsim.events.traffic import GaveUpWaiting, MadeRoom, Waiting, WentOn
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, FollowPath
from hmrsim.protocol.goal import Cause
from hmrsim.traffic.causes import Causes
from hmrsim.traffic.lane_closures import Barriers, LaneClosures
from hmrsim.traffic.rules import Wait, WaitTimeout

if TYPE_CHECKING:
    from hmrsim.engine.environment import Environment
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.lane_closures import Barrier
    from hmrsim.traffic.rules import Rules, Vehicle
    from hmrsim.world.model import World


class Admission:
    """Decides which vehicles may drive which lanes of a world, and resumes those that had to wait.

    Args:
        world: The world.
        rules_of: Returns the rules of the traffic policy; None if no vehicle can block another.
        patience: The seconds that a vehicle waits before its goal is aborted; None for no limit.
        ways_changed: Called when lanes have been closed or opened; see `LaneClosures.publish`.

    Attributes:
        causes: Finds the causes for which vehicles make no progress.
        closures: The lanes that are closed now.
        needed: Whether a lane, a barrier or another vehicle can block a vehicle.
        by_legs: Whether a vehicle requests each leg separately, since the policy has rules.
        grace: The simulated seconds for which a vehicle lingers after a goal, if its next goal may take time to come.
        waits: The vehicles that wait, in the order in which they began to wait.
    """

    def __init__(
        self,
        env: Environment,
        world: World,
        graph: WaypointGraph,
        *,
        rules_of: Callable[[Admission], Rules | None],
        patience: float | None,
        publisher: EventPublisher,
        ways_changed: Callable[[], None],
    ) -> None:
        self.world = world
        self.graph = graph
        self.publisher = publisher
        self.waits: dict[Vehicle, Wait] = {}
        self._vehicles: dict[Vehicle, None] = {}
        self._stopped: dict[Vehicle, tuple[float, Wait]] = {}
        self._env = env
        self._barriers = Barriers()
        self.closures = LaneClosures(graph, publisher, self._follow_closures, ways_changed)
        self._asking: dict[Vehicle, None] = {}
        self._wait_timeout = WaitTimeout(env, patience, since=self._hopeless_since, expired=self._give_up)
        self._rules = rules_of(self)
        self.causes = Causes(world, self._vehicles, self.waits, self._rules, self.closures, self._barriers)
        self._obstructed = False
        self._lanes_change: Event | None = None
        self.needed = self.by_legs = self._rules is not None
        self.grace = self._rules.grace if self._rules is not None else 0.0

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self._env.now

    def reset(self) -> None:
        """Clear the history of the traffic policy; no vehicle may be driving."""
        self._stopped.clear()
        if self._rules is not None:
            self._rules.reset()

    def plan(self, robot: Vehicle, start: Point, goal: Point, avoid: Collection[Lane] = ()) -> Route:
        """Return the quickest route for a vehicle, without lanes to *avoid* and those that it can never pass.

        Raises:
            NoRoute: There is none, as for `WaypointGraph.plan`; the text names the closed lanes.
        """
        kept_off = self._barriers.kept_off(robot)
        try:
            if avoid:
                return self.graph.detour(start, goal, robot.speed, kept_off, avoid)
            return self.graph.plan(start, goal, robot.speed, kept_off)
        except NoRoute as error:
            if error.code != ComputePathToPose.Result.NO_VALID_PATH or not (kept_off or self.closures.lanes):
                raise
            up_to = self.closures.obstructions.up_to(
                goal, self.closures.lanes, lambda end: self.graph.plan(start, end, robot.speed, [*kept_off, *avoid])
            )
            if up_to is not None:
                return up_to
            closed = self.closures.descriptions() + [f"{a}-{b} may not be driven by {robot.name}" for a, b in kept_off]
            raise NoRoute(error.code, f"{error}; {', '.join(closed)}") from None

    def add_barrier(self, barrier: Barrier) -> None:
        """Register a barrier: vehicles request passage on its lanes and when they leave the graph."""
        self._barriers.add(barrier)
        self._update_needed()

    def lanes_change(self) -> Event:
        """Return the event of the next time that lanes are closed or opened."""
        if self._lanes_change is None:
            self._lanes_change = Event(self._env)
        return self._lanes_change

    def _follow_closures(self) -> None:
        self._update_needed()
        if self._rules is not None:
            self._rules.opened()
        elif self._obstructed:
            for robot in self._vehicles:
                robot.look_ahead()
        self.look_again([*self.waits])
        event, self._lanes_change = self._lanes_change, None
        if event is not None:
            event.succeed()

    def _update_needed(self) -> None:
        self._obstructed = bool(self._barriers) or bool(self.closures.lanes)
        self.needed = self._rules is not None or self._obstructed

    def place(self, robot: Vehicle) -> None:
        """Record that a vehicle is new, or was moved to where it stands now."""
        self._vehicles[robot] = None
        self.forget(robot)
        self._barriers.leave(robot)
        if self._rules is not None and not robot.flies:
            self._rules.stand(robot, self._slots_at(robot.pose().point))

    def full_at(self, point: Point, radius: float, name: str = "") -> str | None:
        """Return why a vehicle of this radius can't stand at a point, because another holds it; None if it can.

        The other vehicle holds the waypoint or lane at the point, or one so near that both would touch. The vehicle of
        this *name* does not count.
        """
        if self._rules is None:
            return None
        for slot in self._slots_at(point):
            others = [robot for robot in self._rules.inside(slot) if robot.name != name]
            if self._rules.full(slot) and others:
                return f"is on {self._called(slot, others[0])}, which {others[0].name} has"
            for at, other in self._rules.near(slot, radius):
                if other.name != name:
                    return f"is near {self._called(at, other)}, which {other.name} has"
        return None

    def _called(self, slot: int, robot: Vehicle) -> str:
        """Return the name of a slot that a vehicle holds."""
        lanes = self.graph.lanes
        track = slot - len(lanes.names)
        if track < 0:
            return f"waypoint {lanes.names[slot]!r}"
        return (
            "lane {}-{}".format(*lanes.tracks[track])
            if track < len(lanes.tracks)
            else self.causes.places.of(robot.pose().point)
        )

    def remove(self, robot: Vehicle) -> None:
        """Forget a vehicle that has left the world."""
        self._vehicles.pop(robot, None)
        self.closures.clear(robot.name)
        self.forget(robot)
        self._stopped.pop(robot, None)
        self._barriers.leave(robot)
        if self._rules is not None and not robot.flies:
            self._rules.halted(robot)
            self._rules.leave(robot)

    def arrived(self, robot: Vehicle) -> None:
        """Record that a vehicle has reached the end of its leg."""
        if robot in self.waits:
            self.forget(robot)
        if robot in self._barriers.inside:
            self._barriers.leave(robot)
        if self._rules is not None and not robot.flies:
            self._rules.stand(robot, self._rules.held(robot)[-1:])

    def stopped(self, robot: Vehicle, leg: Leg | None) -> None:
        """Record that a vehicle stops on its leg; the leg is None if it had not begun one."""
        if robot in self.waits:
            self._stopped[robot] = self._env.now, self.waits[robot]
        self.forget(robot)
        if robot in self._barriers.inside:
            self._barriers.leave(robot)
        if self._rules is None or robot.flies:
            return
        self._rules.halted(robot)
        if leg is None or leg.ride:
            self._stand_back(robot, self._rules)
        else:
            self._rules.stand(robot, leg.slots[:1] if leg.lane else self._slots_at(robot.pose().point))

    def _stand_back(self, robot: Vehicle, rules: Rules) -> None:
        """Put a vehicle back to where it was before this instant, and vehicles that set out for that place, too."""
        slots = self._slots_at(robot.pose().point)
        for slot in slots:
            inside = [*rules.inside(slot)] if rules.full(slot) else []
            for other in dict.fromkeys([*inside, *(near for _, near in rules.near(slot, robot.radius))]):
                if other is not robot and other.sets_out and (leg := other.next_leg):
                    other.step_back()
                    self._stand_back(other, rules)
                    self._wait(other, leg, "")
                    rules.halted(other)
                    self.look_again([other])
        rules.stand(robot, slots)

    def _slots_at(self, point: Point) -> tuple[int, ...]:
        """Return the slots of a vehicle that stands at a point: a waypoint, a lane, or a spot beside the lanes."""
        lanes = self.graph.lanes
        at = lanes.at.get(point)
        if at is not None:
            return (at,)
        on_lane, feet = lanes.feet(point)
        if not on_lane:
            return (self._rules.spot(point),) if self._rules else ()
        edge = feet[0][0]
        for node in (edge.start, edge.end):
            if distance(point, lanes.points[node]) <= SAME_PLACE:
                return (node,)
        return edge.leg.slots[:1]

    def admit(self, robot: Vehicle, leg: Leg) -> bool:
        """Return whether a vehicle may begin a leg now; if not, it waits until it is released."""
        if self.waits and robot in self.waits:
            # The vehicle has taken another route meanwhile.
            self.forget(robot)
        why = self._in_the_way(robot, leg) if self._obstructed else ""
        if not why and (self._rules is None or self._rules.take(robot, leg)):
            if leg.leads_onto in self._barriers.on_lanes or robot in self._barriers.inside:
                self._barriers.enter(robot, leg)
            return True
        self._wait(robot, leg, why)
        return False

    def sure_up_to(self, robot: Vehicle, legs: Sequence[Leg | None], number: int) -> int:
        """Return the index of the last piece of a drive up to which a vehicle need not request again.

        The vehicle may begin the piece *number* now. It requests again at and behind a barrier, and at a closed lane.
        """
        if robot in self._barriers.inside:
            return number
        for at in range(number + 1, len(legs)):
            leg = legs[at]
            if leg is not None and self._is_in_doubt(leg):
                return at - 1
        return len(legs) - 1

    def _is_in_doubt(self, leg: Leg) -> bool:
        """Return whether something other than a vehicle may block a leg."""
        lane = leg.lane
        return bool(self._barriers) if lane is None else lane in self.closures.lanes or lane in self._barriers.on_lanes

    @property
    def asking(self) -> Iterable[Vehicle]:
        """The vehicles that will request their legs again at this instant, in order."""
        return self._asking

    def soon(self, call: Callable[[], None]) -> None:
        """Call a function at this instant, after the events that happen now."""
        self._env.call_soon(call)

    def look_again(self, robots: Sequence[Vehicle]) -> None:
        """Make waiting vehicles request their legs again, at the end of this instant."""
        if not robots:
            return
        if not self._asking:
            # Not now: a vehicle that makes room has not left its slots yet.
            self._env.call_soon(self._ask)
        self._asking.update(dict.fromkeys(robots))

    def look_again_at(self, robot: Vehicle, at: float) -> None:
        """Make a vehicle request again at a simulated time, in seconds, if it still waits for the same leg then."""
        wait = self.waits.get(robot)

        def ask(_event: Event) -> None:
            if wait is not None and self._still_waits(wait):
                self._ask_again(wait)

        At(self._env, at, [ask])

    def _ask(self) -> None:
        while self._asking:
            robot = next(iter(self._asking))
            del self._asking[robot]
            wait = self.waits.get(robot)
            if wait is not None:
                self._ask_again(wait)

    def _ask_again(self, wait: Wait) -> None:
        robot, leg = wait.robot, wait.leg
        if self._obstructed and self.causes.for_good(wait) and robot.reroute(()):
            return
        wait.why = self._in_the_way(robot, leg) if self._obstructed else ""
        if not wait.why and (self._rules is None or self._rules.take(robot, leg)):
            self.release(robot)
            return
        self.decide(robot)
        if self._still_waits(wait):
            self._tell(wait)

    def _in_the_way(self, robot: Vehicle, leg: Leg) -> str:
        """Return the obstacle on a leg other than vehicles, in words; empty if there is none."""
        lane = leg.lane
        closed = self.closures.why(leg) if lane in self.closures.lanes else ""
        if closed or (lane and leg.joins is None and lane not in self._barriers.on_lanes):
            return closed
        return self._barriers.why_not(robot, leg)

    def kept_off(self, robot: Vehicle) -> Collection[Lane]:
        """Return the lanes that a vehicle can never pass, for instance because of a door that does not open for it."""
        return self._barriers.kept_off(robot)

    def shut_to(self, robot: Vehicle) -> Collection[Lane]:
        """Return the lanes along which a vehicle can't be moved: closed ones, and those that it can never pass."""
        kept_off, closed = self._barriers.kept_off(robot), self.closures.lanes
        return {*kept_off, *closed} if kept_off and closed else kept_off or closed

    def lets(self, robot: Vehicle, legs: Sequence[Leg]) -> bool:
        """Return whether only vehicles can block some legs now; otherwise the barriers on them begin to open."""
        if not self._obstructed:
            return True
        hindered = [leg for leg in legs if self._in_the_way(robot, leg)]
        for leg in hindered:
            self._barriers.summon(leg)
        return not hindered

    def opened(self, lanes: Collection[Lane]) -> None:
        """Record that a barrier on these lanes has changed; vehicles that wait there or off the lanes request again."""
        self._barriers.changed(lanes)
        if self._rules is not None:
            self._rules.opened()
        waits = self.waits.values()
        self.look_again([wait.robot for wait in waits if not wait.leg.lane or wait.leg.lane in lanes])

    def push(self, robot: Vehicle, legs: Sequence[Leg], by: Vehicle, *, rerouted: bool = False) -> None:
        """Make a vehicle make room for another by driving legs whose slots it already holds."""
        self.forget(robot)
        self._barriers.enter(robot, legs[0])
        start, wanted_by = robot.pose().point, "" if by is robot else by.name
        self.publisher.publish(lambda: MadeRoom(robot.name, start, legs[-1].end, wanted_by))
        robot.yield_along(legs, by.name, rerouted=rerouted)

    def abort(self, robot: Vehicle, why: GoalAborted) -> None:
        """Abort the motion of a waiting vehicle; its next motion starts a new wait."""
        robot.give_up(why)
        self._stopped.pop(robot, None)

    def release(self, robot: Vehicle) -> None:
        """Resume a waiting vehicle that now holds the slots of its leg."""
        wait = self.waits[robot]
        self.forget(robot)
        self._barriers.enter(robot, wait.leg)
        waited = self._env.now - wait.since
        self.publisher.publish(lambda: WentOn(robot.name, waited))
        robot.go_on()

    def try_again(self, robot: Vehicle) -> None:
        """Make a vehicle that waits or has yielded request again, at this instant."""
        if robot in self.waits:
            self.look_again([robot])
        elif robot.waits:
            self._env.call_soon(robot.ask_again)

    def became_idle(self, robot: Vehicle) -> None:
        """Record that a vehicle can make room from now on."""
        if self._rules is not None and not robot.flies:
            self._rules.stand(robot, self._rules.held(robot))

    def yielded(self, robot: Vehicle) -> None:
        """Record that a vehicle has made room; it continues if the traffic policy allows that."""
        if self._rules is not None and self._rules.stays_aside(robot):
            return
        if self._asking:
            # The vehicles for which it has made room go first.
            self._env.call_soon(robot.ask_again)
        else:
            robot.ask_again()

    def queue(self, robot: Vehicle, dock: str, holders: Callable[[], Sequence[Vehicle]]) -> None:
        """Record that a vehicle queues for a dock until one of the *holders* leaves; see `Causes.unqueue`."""
        self.causes.queue(robot, dock, self._env.now, holders)
        # Other vehicles may now wait for one that will not move by itself.
        self.became_idle(robot)

    def waits_for_barrier(self, robot: Vehicle) -> bool:
        """Return whether a vehicle waits for a door or a lift that will let it pass."""
        wait = self.waits.get(robot)
        return wait is not None and bool(wait.why) and not self.causes.for_good(wait)

    def _wait(self, robot: Vehicle, leg: Leg, why: str) -> None:
        if robot in self._barriers.inside:
            self._barriers.leave(robot)
        wait = self.waits[robot] = Wait(robot, leg, self._waits_since(robot, leg), why)
        if self._rules is not None:
            self._rules.stand(robot, self._rules.held(robot)[-1:])
        self._wait_timeout.begin(wait)
        self._tell(wait)

    def _waits_since(self, robot: Vehicle, leg: Leg) -> float:
        """Return when a wait began; a vehicle that was stopped and sent on at this instant has not stopped waiting."""
        when, before = self._stopped.pop(robot, (-1.0, None))
        return before.since if before and when == self._env.now and before.leg == leg else self._env.now

    def decide(self, robot: Vehicle) -> None:
        """Resolve the wait of a vehicle, if that is possible."""
        wait = self.waits.get(robot)
        if wait is None:
            return
        if wait.why:
            if self.causes.for_good(wait):
                robot.reroute(())
        elif self._rules is not None:
            self._rules.blocked(robot)

    def explain(self, robot: Vehicle, why: str) -> None:
        """Record why a barrier refuses a waiting vehicle, and publish that."""
        wait = self.waits.get(robot)
        if wait is not None and wait.why and not self.closures.why(wait.leg):
            wait.why = why
            self._tell(wait)

    def _tell(self, wait: Wait) -> None:
        """Publish what a vehicle waits for, unless the last event says the same."""
        if self.publisher.interest.events:
            others = self._waits_for(wait)
            last = wait.published
            if last is None or last.why != wait.why or last.for_ != others:
                event = wait.published = self._described(wait, others)
                self.publisher.publish(lambda: event)

    def _waits_for(self, wait: Wait) -> tuple[str, ...] | None:
        """Return the names of the vehicles that a vehicle waits for; None if an obstacle blocks it."""
        return None if wait.why else tuple(sorted([other.name for other in self.causes.blockers(wait.robot)]))

    def _described(self, wait: Wait, others: tuple[str, ...] | None) -> Waiting:
        robot = wait.robot
        return Waiting(robot.name, robot.pose().point, wait.leg.lane or None, wait.why, others)

    def waiting(self, robot: Vehicle) -> dict[str, Any] | None:
        """Return what a vehicle waits for, and since when, as JSON values; None if it does not wait."""
        wait = self.waits.get(robot)
        return None if wait is None else {"since": wait.since, **self._described(wait, self._waits_for(wait)).to_json()}

    def _still_waits(self, wait: Wait) -> bool:
        return self.waits.get(wait.robot) is wait

    def _hopeless_since(self, wait: Wait) -> float | None:
        """Return since when no vehicle on which a wait depends has made progress.

        Returns:
            The time in simulated seconds, but not before the wait began; infinite if one of the vehicles moves or works
            now; None if the wait is over. The vehicles are those for which this one waits, directly or through others,
            and those whose turn comes before.
        """
        if not self._still_waits(wait):
            return None
        robot = wait.robot
        seen = dict.fromkeys(self._rules.ahead_of(robot) if self._rules and not wait.why else ())
        for vehicle in (todo := [robot]):
            for other in self.causes.blockers(vehicle) or self.causes.behind_barrier(vehicle):
                if other not in seen:
                    seen[other] = None
                    todo.append(other)
        return max([wait.since, *(other.still_since for other in seen if other is not robot)])

    def _give_up(self, wait: Wait) -> None:
        """Abort the goal of a vehicle that has waited for too long."""
        robot, waited = wait.robot, self._env.now - wait.since
        chain = self.causes.give_up(robot, self._env.now)
        at, others, why = robot.pose().point, chain.links[0].held_by, str(chain)
        self.publisher.publish(lambda: GaveUpWaiting(robot.name, at, waited, others, why))
        text = f"blocked for {waited:g} s: {why}"
        self.abort(robot, GoalAborted(FollowPath.Result.PATIENCE_EXCEEDED, text, Cause.BLOCKED))

    def forget(self, robot: Vehicle) -> None:
        """End the wait of a vehicle, if it waits."""
        wait = self.waits.pop(robot, None)
        if wait is None:
            return
        if not self.waits:
            self._wait_timeout.stop()
        if self._rules is not None:
            self._rules.forget(robot, wait.leg)
