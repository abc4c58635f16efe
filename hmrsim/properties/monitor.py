"""The monitor of a run, which takes its occurrences and judges properties, and the sink that feeds it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import stamp
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.robots import MotionBegan
from hmrsim.events.simulation import PropertyViolated, SimulationReset, WorldLoaded
from hmrsim.history.occurrence import BatterySeen, Occurrence, SceneSeen
from hmrsim.history.timeline import GoalSeen, Timeline
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.compiler import built_in_watchers, watchers_of
from hmrsim.properties.controller_properties import GoalsEnd, NoVainGoals
from hmrsim.properties.observations import Observations
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.snapshot import scene

if TYPE_CHECKING:
    from hmrsim.properties.model.file import Properties
    from hmrsim.properties.results import Ended, Reference, Verdict, Violation
    from hmrsim.properties.watcher import Watcher
    from hmrsim.protocol.commands import Command
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


class Monitor:
    """Watches the properties of one run, with one occurrence after the other.

    Args:
        properties: The properties, as `hmrsim.properties.read_properties` returns them.
        world: The world of the run.
        reference: The items at the end of the run without faults; None if there is none to compare with.

    Attributes:
        violations: The violations so far, in order of time.
        timeline: The time of the run.
        observations: The state of the world, as far as a property depends on it.
    """

    def __init__(self, properties: Properties, world: World, reference: Reference | None = None) -> None:
        self.violations: list[Violation] = []
        self.timeline = Timeline()
        self._told: Callable[[Violation], object] = lambda _violation: None
        self.observations = Observations(world, self.timeline, reference)
        self._built_in = built_in_watchers(properties.built_in, world, self.timeline, self._tell)
        self._watchers: list[Watcher] = [*watchers_of(properties, self.observations, self._tell), *self._built_in]
        self._vain = next((each for each in self._built_in if isinstance(each, NoVainGoals)), None)
        self._wants_status = GoalStatusChanged in self.timeline.handlers
        self.timeline.on(GoalStatusChanged, self._status)
        self.timeline.on_reset(ResetSimulation.Request.SCOPE_ALL, self._begin_anew)
        self._anew = True
        self._begun = self._over = False

    @property
    def wants_status(self) -> bool:
        """Whether a property depends on the events of goals, with their results, and not just on their statuses."""
        return self._wants_status

    @property
    def wants_motion(self) -> bool:
        """Whether a property depends on where robots are, or whether they drive."""
        return MotionBegan in self.timeline.handlers

    @property
    def wants_scene(self) -> bool:
        """Whether a property depends on the state of the world."""
        return SceneSeen in self.timeline.handlers

    @property
    def powered(self) -> Collection[str]:
        """The robots on whose batteries a property depends, also from now on."""
        return self.observations.powered

    def begin(self, at: int) -> None:
        """Begin the run at a time in nanoseconds; it begins with the first occurrence otherwise."""
        self._begun = True
        if self.timeline.begin(at):
            for watcher in self._watchers:
                watcher.begin(self.timeline.now)

    def take(self, occurrence: Occurrence) -> None:
        """Take an occurrence; those after the end are ignored."""
        if self._over or (isinstance(occurrence.event, SceneSeen) and not self._anew):
            # A scene may be late; only the first one is news.
            return
        if not self._begun:
            self.begin(occurrence.at)
        self.timeline.take(occurrence)
        if isinstance(occurrence.event, SceneSeen):
            self._anew = False

    def goal(self, stamp: int, seen: GoalSeen, asked: Any = None) -> None:
        """Take the change of a goal, with its message when it is accepted; this is cheaper than its event."""
        if self._over:
            return
        if asked is not None and self._vain is not None:
            self._vain.ask(seen.robot, seen.action, asked)
        if not self._begun:
            self.begin(stamp)
        self.timeline.give(stamp, seen, self.timeline.handlers.get(GoalSeen, ()))

    def request(self, robot: str, action: str, asked: Any) -> None:
        """Take the message of a goal that may be rejected."""
        if self._vain is not None:
            self._vain.ask(robot, action, asked)

    def replace_controller(self) -> None:
        """Excuse the running goals of a controller that was killed on purpose, and end its rows of failures."""
        if self._vain is not None:
            self._vain.begin_anew()
        for watcher in self._built_in:
            if isinstance(watcher, GoalsEnd):
                watcher.leave()

    def end(self, at: int | None = None, ended: Ended | None = None) -> None:
        """End the run.

        Args:
            at: The time in nanoseconds of simulated time; None for that of the last occurrence.
            ended: How it has ended; None where that is unknown, as of a trace.
        """
        if self._over:
            return
        self.begin(0)
        self.timeline.end(at)
        self._over = True
        for watcher in self._watchers:
            watcher.end(self.timeline.now, ended)
        # A simulation that is torn down still sends events.
        self.timeline.close()

    def listen(self, told: Callable[[Violation], object]) -> None:
        """Call a function with each violation from now on, as soon as it is found."""
        self._told = told

    def verdicts(self) -> list[Verdict]:
        """Return the verdict on each property, those of the file first."""
        return [watcher.verdict() for watcher in self._watchers]

    def _tell(self, violation: Violation) -> None:
        self.violations.append(violation)
        self._told(violation)

    def _begin_anew(self, _at: int) -> None:
        self._anew = True

    def _status(self, at: int, event: GoalStatusChanged) -> None:
        seen = GoalSeen(event.robot, event.action, event.goal_id, event.status, event.cause or "")
        for handler in self.timeline.handlers.get(GoalSeen, ()):
            handler(at, seen)


class MonitorSink(SelectiveSink):
    """A sink that feeds a monitor with what its properties depend on, and computes no more.

    Args:
        simulator: The simulator, before it starts.
        on_violation: Called with each violation as soon as it is found, in the thread of the simulation.
    """

    def __init__(
        self,
        simulator: Simulator,
        monitor: Monitor,
        on_violation: Callable[[Violation], object] = lambda _violation: None,
    ) -> None:
        self._simulator = simulator
        self._monitor = monitor
        self._handlers = monitor.timeline.handlers
        self._motion = monitor.wants_motion
        self._weighed = -1
        self._statuses = monitor.wants_status
        monitor.listen(on_violation)
        now = stamp(simulator.now)
        monitor.begin(now)
        self._powered = monitor.powered
        if simulator.now:
            # At time 0 the scene is that of the world, which is known.
            self._see(now)

    @property
    def topics(self) -> Collection[Topic]:
        """The topics that it wants: events, and motions if a property depends on them."""
        return (Topic.EVENTS, Topic.MOTION) if self._motion else (Topic.EVENTS,)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {
            EventStamped: self._take,
            GoalChanged: self._change,
            TimeRestarted: self._restart,
        }
        return handlers.get(kind)

    def _take(self, output: EventStamped) -> None:
        event = output.event
        if isinstance(event, PropertyViolated):
            # It comes in the middle of an instant, in which time must not go on.
            return
        handlers = self._handlers.get(type(event))
        if handlers is None:
            self._monitor.timeline.look(output.stamp)
            return
        self._weigh(output.stamp)
        self._monitor.timeline.give(output.stamp, event, handlers)
        if isinstance(event, SimulationReset | WorldLoaded):
            self._see(output.stamp)

    def _restart(self, output: TimeRestarted) -> None:
        self._monitor.timeline.restart(output.ended)

    def weigh(self) -> None:
        """Pass on the charge of batteries, as at the end of a run."""
        self._weigh(stamp(self._simulator.now))

    def _change(self, change: GoalChanged) -> None:
        at, robot, action, goal_id, status, asked, _, cause = change
        self._weigh(at)
        if self._statuses:
            if asked is not None:
                self._monitor.request(robot, action, asked)
            self._monitor.take(Occurrence(at, change.event()))
        else:
            self._monitor.goal(at, GoalSeen(robot, action, goal_id, int(status), cause), asked)

    def _see(self, at: int) -> None:
        if self._monitor.wants_scene:
            self._monitor.take(Occurrence(at, SceneSeen(scene(self._simulator))))

    def _weigh(self, at: int) -> None:
        """Pass on the charge of the batteries that properties depend on, once an instant."""
        if not self._powered or at == self._weighed:
            return
        self._weighed = at
        for name in [*self._powered]:
            robot = self._simulator.robots.get(name)
            if robot is not None and robot.energy is not None:
                self._monitor.take(Occurrence(at, BatterySeen(name, robot.energy.battery.share(robot.now))))

    def commanded(self, command: Command, _by: str, _now: float) -> None:
        """Take the message of a goal, as it may be rejected."""
        if isinstance(command, SendGoal):
            self._monitor.request(command.robot, command.action, command.goal)
