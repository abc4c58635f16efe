"""The monitor, which checks the properties of a run while it happens, and the sink that feeds it in a simulation."""

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
    """Checks the properties of one run, given its occurrences in order of time.

    Args:
        reference: The items at the end of the run without faults; None if there is none to compare with.

    Attributes:
        violations: The violations so far, in order of time.
        wants_status: Whether a property depends on the events of goals, with their results, and not just on their
            statuses.
        timeline: The time of the run, and the handlers of its occurrences.
        observations: The state of the world, as far as a property depends on it.
    """

    def __init__(self, properties: Properties, world: World, reference: Reference | None = None) -> None:
        self.violations: list[Violation] = []
        self.timeline = Timeline()
        self._on_violation: Callable[[Violation], object] = lambda _violation: None
        self.observations = Observations(world, self.timeline, reference)
        self._built_in = built_in_watchers(properties.built_in, world, self.timeline, self._record)
        self._watchers: list[Watcher] = [*watchers_of(properties, self.observations, self._record), *self._built_in]
        self._no_vain_goals = next((each for each in self._built_in if isinstance(each, NoVainGoals)), None)
        self.wants_status = GoalStatusChanged in self.timeline.handlers
        self.timeline.derive_goals()
        self.timeline.on_reset(ResetSimulation.Request.SCOPE_ALL, self._expect_scene)
        self._scene_expected = True
        self._begun = self._over = False

    def begin(self, at: int) -> None:
        """Begin the run at a time in nanoseconds; without this call, it begins with the first occurrence."""
        self._begun = True
        if self.timeline.begin(at):
            for watcher in self._watchers:
                watcher.begin(self.timeline.now)

    def take(self, occurrence: Occurrence) -> None:
        """Process an occurrence, unless the run is over."""
        if self._over or (isinstance(occurrence.event, SceneSeen) and not self._scene_expected):
            # Later scenes repeat what the events have said, and may be late.
            return
        if not self._begun:
            self.begin(occurrence.at)
        self.timeline.take(occurrence)
        if isinstance(occurrence.event, SceneSeen):
            self._scene_expected = False

    def take_goal(self, stamp: int, seen: GoalSeen, message: Any = None) -> None:
        """Process a change of a goal, with its message when it is accepted; this is cheaper than its event."""
        if self._over:
            return
        if message is not None:
            self.take_message(seen.robot, seen.action, message)
        if not self._begun:
            self.begin(stamp)
        self.timeline.give(stamp, seen, self.timeline.handlers.get(GoalSeen, ()))

    def take_message(self, robot: str, action: str, message: Any) -> None:
        """Remember the message of the next goal that is accepted or rejected."""
        if self._no_vain_goals is not None:
            self._no_vain_goals.take_message(robot, action, message)

    def replace_controller(self) -> None:
        """Excuse the open goals of a controller that a disturbance has killed, and forget its failures."""
        if self._no_vain_goals is not None:
            self._no_vain_goals.begin_anew()
        for watcher in self._built_in:
            if isinstance(watcher, GoalsEnd):
                watcher.leave()

    def end(self, at: int | None = None, ended: Ended | None = None) -> None:
        """End the run.

        Args:
            at: The time in nanoseconds of simulated time; None for that of the last occurrence.
            ended: The ending of the run; None if it is unknown, as for a trace.
        """
        if self._over:
            return
        self.begin(0)
        self.timeline.end(at)
        self._over = True
        for watcher in self._watchers:
            watcher.end(self.timeline.now, ended)
        # A simulation sends more events while it is torn down.
        self.timeline.close()

    def subscribe(self, on_violation: Callable[[Violation], object]) -> None:
        """Call a function with each violation from now on, as soon as it is found."""
        self._on_violation = on_violation

    def verdicts(self) -> list[Verdict]:
        """Return the verdict on each property: first those of the file, then the built-in ones."""
        return [watcher.verdict() for watcher in self._watchers]

    def _record(self, violation: Violation) -> None:
        self.violations.append(violation)
        self._on_violation(violation)

    def _expect_scene(self, _at: int) -> None:
        self._scene_expected = True


class MonitorSink(SelectiveSink):
    """A sink that feeds a monitor, and computes only what its properties depend on.

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
        self._motion = MotionBegan in self._handlers
        self._batteries_sampled_at = -1
        self._statuses = monitor.wants_status
        monitor.subscribe(on_violation)
        now = stamp(simulator.now)
        monitor.begin(now)
        self._watched_batteries = monitor.observations.watched_batteries
        if simulator.now:
            # At time 0 the scene is that of the world file.
            self._take_scene(now)

    @property
    def topics(self) -> Collection[Topic]:
        """The topics to subscribe to: events, and motions if a property depends on them."""
        return (Topic.EVENTS, Topic.MOTION) if self._motion else (Topic.EVENTS,)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {
            EventStamped: self._take,
            GoalChanged: self._take_goal,
            TimeRestarted: lambda output: self._monitor.timeline.restart(output.ended),
        }
        return handlers.get(kind)

    def _take(self, output: EventStamped) -> None:
        event = output.event
        if isinstance(event, PropertyViolated):
            # The monitor's own event, which comes in the middle of an instant that is not over.
            return
        handlers = self._handlers.get(type(event))
        if handlers is None:
            self._monitor.timeline.look(output.stamp)
            return
        if self._watched_batteries:
            self._sample_batteries(output.stamp)
        self._monitor.timeline.give(output.stamp, event, handlers)
        if isinstance(event, SimulationReset | WorldLoaded):
            self._take_scene(output.stamp)

    def sample_batteries(self) -> None:
        """Pass the current charge of batteries to the monitor, as at the end of a run."""
        self._sample_batteries(stamp(self._simulator.now))

    def _take_goal(self, change: GoalChanged) -> None:
        at, robot, action, goal_id, status, message, _, cause = change
        if self._watched_batteries:
            self._sample_batteries(at)
        if self._statuses:
            if message is not None:
                self._monitor.take_message(robot, action, message)
            self._monitor.take(Occurrence(at, change.event()))
        else:
            self._monitor.take_goal(at, GoalSeen(robot, action, goal_id, int(status), cause), message)

    def _take_scene(self, at: int) -> None:
        if SceneSeen in self._handlers:
            self._monitor.take(Occurrence(at, SceneSeen(scene(self._simulator))))

    def _sample_batteries(self, at: int) -> None:
        """Pass the charge of the watched batteries to the monitor, once per instant."""
        if at == self._batteries_sampled_at:
            return
        self._batteries_sampled_at = at
        for name in [*self._watched_batteries]:
            robot = self._simulator.robots.get(name)
            if robot is not None and robot.energy is not None:
                self._monitor.take(Occurrence(at, BatterySeen(name, robot.energy.battery.share(robot.now))))

    def commanded(self, command: Command, _by: str, _now: float) -> None:
        """Pass the message of a goal to the monitor; it has no other source if the goal is rejected."""
        if isinstance(command, SendGoal):
            self._monitor.take_message(command.robot, command.action, command.goal)
