"""A running world: robots, items, the dispatcher and the events between them. It does no I/O.

What comes in is a `Command`, what goes out an event for every `Sink`; a run is a function of the world, its
seed and the commands with their times.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import simpy

from hmrsim.actions import registry as all_actions
from hmrsim.dispatcher import Dispatcher
from hmrsim.errors import GoalRejected
from hmrsim.gateway import (
    Answered,
    CancelGoal,
    ForgetResult,
    GetResult,
    InterestChanged,
    Participation,
    Read,
    Refused,
    Sampled,
    SendGoal,
    Stop,
    Topic,
)
from hmrsim.graph import WaypointGraph
from hmrsim.interest import Happenings, Interest
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time
from hmrsim.interfaces.geometry_msgs import PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.items import Item
from hmrsim.robot import Robot
from hmrsim.scripts import Scripts
from hmrsim.sim_time import nanoseconds
from hmrsim.telemetry import Telemetry

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from hmrsim.actions import AnyAction
    from hmrsim.gateway import Command, Event, Published, Sink
    from hmrsim.world.model import World


_BATCH = 1_000
"""Events that are taken in one go where nothing else wants to be done between them."""


class _Environment(simpy.Environment):
    """Simpy's environment, with a way to let time pass in which nothing happens.

    ``run(until=…)`` would do, but leaves a stale event behind, so that the schedule never looks empty.

    Attributes:
        horizon: The last instant of which `take` takes events.
    """

    horizon = math.inf

    def pass_until(self, to: float) -> None:
        """Let it be *to*; nothing may be due before."""
        self._now = to

    def take(self, most: int) -> int:
        """Take at most so many events that are due at the horizon or before; return how many there were."""
        queue, step = self._queue, self.step
        for taken in range(most):
            # The horizon may come nearer with any event.
            if not queue or queue[0][0] > self.horizon:
                return taken
            step()
        return most


class Simulator:
    """Runs one world.

    Args:
        world: What to run; its names must have been checked, as `load_world` does.
        sinks: Where events go, in this order.
        actions: What robots can be asked, by name; all that are installed if None.
        seed: Replaces the world's.
        feedback_rate: Samples of feedback a second of simulated time.
        odom_rate: Samples of odometry a second of simulated time.
        clock_rate: Samples of the clock a second of simulated time.
        keep_results: Most ended goals that a robot remembers.

    Attributes:
        taken: Events taken since the beginning. What somebody listens to does not change it, nor any clock; so
            (number of events, command) says exactly when a command came.
        record: Told of each command from outside, before it is applied, and by whom it was sent.
        limit: The time up to which time may move; infinite while the simulation is not paused.
        generation: How often the world was begun anew.
    """

    def __init__(
        self,
        world: World,
        sinks: Sequence[Sink] = (),
        *,
        actions: Mapping[str, AnyAction] | None = None,
        seed: int | None = None,
        feedback_rate: float = 10.0,
        odom_rate: float = 10.0,
        clock_rate: float = 10.0,
        keep_results: int = 1000,
    ) -> None:
        self.world = world
        self.seed = world.seed if seed is None else seed
        self.env = _Environment()
        self.graph = WaypointGraph(world)
        self.items = {name: Item(name, item.weight, world.point(item.at)) for name, item in world.items.items()}
        self._sinks = list(sinks)
        self.interest = Interest(self._sinks)
        self.telemetry = Telemetry(self.interest)
        self._told = math.nan
        self.taken = 0
        self.record: Callable[[Command, str], None] = lambda _command, _by: None
        self.limit = math.inf
        self.generation = 0
        happened = self._happened = Happenings(self.env, self.interest, self._emit)
        self.dispatcher = Dispatcher(
            self.env,
            all_actions() if actions is None else actions,
            self.telemetry,
            emit=self._emit,
            happened=happened,
            seed=self.seed,
            keep_results=keep_results,
            feedback_rate=feedback_rate,
        )
        self.robots: dict[str, Robot] = {}
        for name, spec in world.robots.items():
            robot = self.robots[name] = Robot(self.env, name, spec, world, self.graph, self.items, happened)
            self.dispatcher.servers.add(robot)
        self.telemetry.start("odom", Topic.ODOM, 0.0, odom_rate, self._emit_odom)
        self.scripts = Scripts(self.env, world, submit=self._apply, happened=happened)
        if self.scripts.all:
            self._sinks.append(self.scripts)
        self.telemetry.start("clock", Topic.CLOCK, 0.0, clock_rate, lambda: self._emit(self._clock()))

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self.env.now

    # --- commands and events --------------------------------------------------------------------------------------

    def attach(self, sink: Sink) -> None:
        """Send events to one more sink, from now on."""
        self._sinks.append(sink)
        self.submit(InterestChanged())

    def submit(self, command: Command, by: str = "") -> None:
        """Apply a command from outside at this instant; what comes of it goes to the sinks, now or later.

        Args:
            command: What to do.
            by: The participant that sent it, if it takes part in lockstep.
        """
        self.record(command, by)
        self._apply(command)

    def _apply(self, command: Command) -> None:
        match command:
            case SendGoal():
                self.dispatcher.send_goal(command)
            case GetResult():
                self.dispatcher.get_result(command)
            case CancelGoal():
                self.dispatcher.cancel_goal(command)
            case ForgetResult(robot, action, goal_id):
                self.dispatcher.forget(robot, action, goal_id)
            case Read():
                self._read(command)
            case InterestChanged():
                self.interest.refresh()
                self.dispatcher.interest_changed()
                self.telemetry.refresh(self.now)
            case Participation(participant, change, why):
                told = {"participant": participant} | ({"why": why} if why else {})
                self._happened(f"participant_{change}", lambda: told)
            case Stop(reason):
                self._stop(reason)

    def answer(self, reply_to: Any, answer: Any) -> None:
        """Send the answer to a command that was not for the world itself."""
        if reply_to is not None:
            self._emit(Answered(reply_to, answer))

    def tell(self, event: Event) -> None:
        """Send an event that is not of the world itself."""
        self._emit(event)

    def stop(self, reason: str = "the simulation was stopped") -> None:
        """Abort every goal that runs; the simulation must not be run afterwards."""
        self.submit(Stop(reason))

    def _stop(self, reason: str) -> None:
        # Nobody will tell any more who has come to listen.
        self.interest.refresh()
        interrupted = self.dispatcher.stop(reason)
        # Interrupts come before all else; robots stand still after them.
        for _ in range(interrupted):
            if self.env.peek() <= self.now:
                self.env.step()

    def _emit(self, event: Event) -> None:
        for sink in self._sinks:
            sink.emit(event)

    def _read(self, command: Read) -> None:
        answer: Published | Refused
        try:
            match command.topic:
                case Topic.STATUS:
                    answer = self.dispatcher.status(command.robot, command.action)
                case Topic.ODOM:
                    answer = self._odom(self.robots[command.robot])
                case _:
                    answer = self._clock()
        except (GoalRejected, KeyError):
            answer = Refused("robot", command.robot, f"no such robot or action: {command.robot}/{command.action}")
        self._emit(Answered(command.reply_to, answer))

    def _clock(self) -> Sampled:
        return Sampled(Topic.CLOCK, "", Clock(clock=Time.from_nanoseconds(nanoseconds(self.now))))

    def _emit_odom(self) -> None:
        for robot in self.robots.values():
            self._emit(self._odom(robot))

    def _odom(self, robot: Robot) -> Sampled:
        where = robot.pose_stamped()
        ahead, turning = robot.velocity()
        message = Odometry(
            header=where.header,
            child_frame_id=f"{robot.name}/base_link",
            pose=PoseWithCovariance(pose=where.pose),
            twist=TwistWithCovariance(twist=Twist(linear=Vector3(x=ahead), angular=Vector3(z=turning))),
        )
        return Sampled(Topic.ODOM, robot.name, message)

    # --- time -----------------------------------------------------------------------------------------------------

    @property
    def next_event(self) -> float:
        """When the next event is due; infinite when nothing is scheduled."""
        return self.env.peek()

    @property
    def next_due(self) -> float:
        """When the next event or sample is due; infinite when there is none."""
        return min(self.env.peek(), self.telemetry.next_due)

    def settle(self) -> None:
        """Tell the time to whoever listens to the clock: it stands still until something happens."""
        if self._told != self.now and self.interest.clock:
            self._told = self.now
            self._emit(self._clock())

    def take(self, until: float, most: int, *, idle: bool = True) -> bool:
        """Take some of what is due at *until* or before, events and samples; at one instant events come first.

        Args:
            until: In simulated seconds.
            most: Do not take more than so many.
            idle: Whether to take samples when no event is scheduled, too.

        Returns:
            Whether anything was due.
        """
        taken = 0
        self.env.horizon = until
        while taken < most:
            sample, event = self.telemetry.next_due, self.env.peek()
            due = min(sample, event) if idle or event < math.inf else math.inf
            if due > self.env.horizon or due == math.inf:
                break
            # Each event may bring a sample that is due before the next one; each sample may halt us.
            if sample < event:
                taken += self.telemetry.sample(event, self.env.horizon, 1, self.pass_to)
            else:
                events = self.env.take(1 if self.interest.sampled else most - taken)
                self.taken += events
                taken += events
        return taken > 0

    def halt(self) -> float:
        """End the `take` under way after this instant, of which all is taken still; return the end of the instant."""
        # An instant is a nanosecond: what is due in the same one happens at the same time.
        self.env.horizon = (nanoseconds(self.now) + 0.5) / NANOSECONDS
        return self.env.horizon

    def advance(self, until: float) -> None:
        """Take everything that is due at *until* or before, then let it be *until*."""
        while self.take(until, _BATCH):
            pass
        self.pass_to(until)

    def run(self, until: float = math.inf) -> None:
        """Run until nothing is scheduled or *until* is reached, as fast as possible."""
        while self.take(until, _BATCH, idle=False):
            pass
        if until < math.inf:
            self.advance(until)

    def run_scripts(self, until: float = math.inf) -> None:
        """Run until every script has ended, or *until* is reached."""
        while self.scripts.running and self.take(until, _BATCH, idle=False):
            pass
        if self.scripts.running and until < math.inf:
            self.advance(until)

    def pass_to(self, to: float) -> None:
        """Let it be *to*, rounded to whole nanoseconds, if it is not yet; nothing may be due before.

        So whoever knows a trace, which has whole nanoseconds, can let it be exactly the same time.
        """
        if to > self.env.now and (whole := nanoseconds(to)) > nanoseconds(self.env.now):
            self.env.pass_until(min(whole / NANOSECONDS, self.env.peek()))

    @property
    def paused(self) -> bool:
        """Whether time may not move."""
        return self.limit <= self.env.now
