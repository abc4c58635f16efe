"""The monitor of a run: it takes what happens, and says which properties hold."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.robots import MotionBegan
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.built_in import GoalsEnd, NoVainGoals
from hmrsim.properties.built_in import watchers_of as built_in
from hmrsim.properties.compiling import watchers_of
from hmrsim.properties.observing.observations import Observations
from hmrsim.properties.observing.timeline import GoalSeen, Timeline
from hmrsim.report.occurrence import SceneSeen

if TYPE_CHECKING:
    from hmrsim.properties.model.file import Properties
    from hmrsim.properties.reference import Reference
    from hmrsim.properties.results import Ended, Verdict, Violation
    from hmrsim.properties.watcher import Watcher
    from hmrsim.report.occurrence import Occurrence
    from hmrsim.world.model import World


class Monitor:
    """Watches over the properties of one run, with one occurrence after the other.

    Args:
        properties: What has to hold, as `hmrsim.properties.read_properties` returns it.
        world: The world that is run.
        reference: The items at the end of the run without faults; None if there is none to compare with.

    Attributes:
        violations: What was violated, in order of time.
        timeline: The time of the run.
        observations: The state of the world, as far as properties speak of it.
    """

    def __init__(self, properties: Properties, world: World, reference: Reference | None = None) -> None:
        self.violations: list[Violation] = []
        self.timeline = Timeline()
        self._told: Callable[[Violation], object] = lambda _violation: None
        self.observations = Observations(world, self.timeline, reference)
        self._built_in = built_in(properties.built_in, world, self.timeline, self._tell)
        self._watchers: list[Watcher] = [*watchers_of(properties, self.observations, self._tell), *self._built_in]
        self._vain = next((each for each in self._built_in if isinstance(each, NoVainGoals)), None)
        self._wants_status = GoalStatusChanged in self.timeline.handlers
        self.timeline.on(GoalStatusChanged, self._status)
        self.timeline.on_reset(ResetSimulation.Request.SCOPE_ALL, self._begin_anew)
        self._anew = True
        self._begun = self._over = False

    @property
    def wants_status(self) -> bool:
        """Whether a property speaks of the events of goals, with their results, and not just of their statuses."""
        return self._wants_status

    @property
    def wants_motion(self) -> bool:
        """Whether a property speaks of where robots are, or whether they drive."""
        return MotionBegan in self.timeline.handlers

    @property
    def wants_scene(self) -> bool:
        """Whether a property speaks of the state of the world."""
        return SceneSeen in self.timeline.handlers

    @property
    def powered(self) -> Collection[str]:
        """The robots of whose batteries a property speaks, also from now on."""
        return self.observations.powered

    def begin(self, at: int) -> None:
        """Let the run begin at a time, in nanoseconds; without this, it begins with the first occurrence."""
        self._begun = True
        if self.timeline.begin(at):
            for watcher in self._watchers:
                watcher.begin(self.timeline.now)

    def take(self, occurrence: Occurrence) -> None:
        """Take what has happened; nothing happens after the end."""
        if self._over or (isinstance(occurrence.event, SceneSeen) and not self._anew):
            # A scene may be late; only the first one says what is not known yet.
            return
        if not self._begun:
            self.begin(occurrence.at)
        self.timeline.take(occurrence)
        if isinstance(occurrence.event, SceneSeen):
            self._anew = False

    def goal(self, stamp: int, seen: GoalSeen, asked: Any = None) -> None:
        """Take the change of a goal, and when it was accepted what it asks for; cheaper than its event."""
        if self._over:
            return
        if asked is not None and self._vain is not None:
            self._vain.ask(seen.robot, seen.action, asked)
        if not self._begun:
            self.begin(stamp)
        self.timeline.give(stamp, seen, self.timeline.handlers.get(GoalSeen, ()))

    def request(self, robot: str, action: str, asked: Any) -> None:
        """Take note of what a goal asks for that may be rejected."""
        if self._vain is not None:
            self._vain.ask(robot, action, asked)

    def replace_controller(self) -> None:
        """Note that the controller was killed on purpose: it owes its goals no end, and its rows of failures end."""
        if self._vain is not None:
            self._vain.begin_anew()
        for watcher in self._built_in:
            if isinstance(watcher, GoalsEnd):
                watcher.leave()

    def end(self, at: int | None = None, ended: Ended | None = None) -> None:
        """Take the end of the run.

        Args:
            at: When, in nanoseconds of simulated time; None for the time of the last occurrence.
            ended: How; None where that is not known, as of a trace.
        """
        if self._over:
            return
        self.begin(0)
        self.timeline.end(at)
        self._over = True
        for watcher in self._watchers:
            watcher.end(self.timeline.now, ended)
        # A simulation that is torn down goes on to tell what it does.
        self.timeline.close()

    def listen(self, told: Callable[[Violation], object]) -> None:
        """Call a function with each violation from now on, as soon as it is found."""
        self._told = told

    def verdicts(self) -> list[Verdict]:
        """Return the verdict on each property, first on those of the file."""
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
