"""The candidates of a search: the possible injections, each with the moments at which it can begin."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.fault_search.check import OPT_IN
from hmrsim.fault_search.kinds import changes_of, disturbances_of, faults_of, needs_of
from hmrsim.fault_search.schedule import CHANGE, FAULT, Injection

if TYPE_CHECKING:
    import random

    from hmrsim.fault_search.check import Space
    from hmrsim.fault_search.kinds import Draw
    from hmrsim.fault_search.schedule import Moment
    from hmrsim.world.model import World

_FEW: Final = 12
"""The number of moments for an injection that affects no robot, spread over the run."""

_OWN: Final = 0.75
"""The probability that an injection affects the robot of a moment, and not a lane, a door or the controller."""
_CHANGES: Final = 0.1
"""The probability of a change of the world, and not of an injection at a moment."""
_STARTS: Final = 0.05
"""The probability that a fault holds from the start."""
_UNREACHABLE: Final = "messages_lost"
"""The fault with which a robot can't be reached."""
_CODE: Final = 0.1
"""The weight of each particular error code, relative to 1."""


class Timeline:
    """The moments of a run, and the anchors at which injections can begin, in plain values."""

    def __init__(self, moments: Sequence[Moment]) -> None:
        self.moments = moments
        self._lasted: dict[tuple[str, str, int], float] = {}
        for each in moments:
            if each.goal == "ended":
                self._lasted.setdefault((each.robot, each.action, each.nth), each.lasted)

    def anchors_of(self, moment: Moment) -> list[dict[str, Any]]:
        """Return the anchors of a moment: the moment, and the middle of a goal that begins then."""
        if moment.goal == "executing":
            lasted = self._lasted.get((moment.robot, moment.action, moment.nth), 0.0)
            if lasted > 0:
                return [moment.anchor(), moment.anchor(round(lasted / 2, 3))]
        return [moment.anchor()]

    def anchors_for(self, robot: str | None) -> list[dict[str, Any]]:
        """Return the anchors of a robot; None for all."""
        return self._by_robot.get(robot, [])

    @cached_property
    def _by_robot(self) -> dict[str | None, list[dict[str, Any]]]:
        found: dict[str | None, list[dict[str, Any]]] = {None: []}
        for each in self.moments:
            anchors = self.anchors_of(each)
            found[None] += anchors
            found.setdefault(each.robot, []).extend(anchors)
        return found


@dataclass(frozen=True)
class Candidate:
    """An injection that can begin at one of several moments.

    Attributes:
        injection: The injection, without an anchor.
        weight: Its frequency, relative to 1.
    """

    injection: Injection
    weight: float

    @property
    def anchored(self) -> bool:
        """True if it begins at a moment; a change of the world holds from the start."""
        return (
            self.injection.family != CHANGE and not self.injection.spec.get("when") and "at" not in self.injection.spec
        )

    def suits(self, action: str) -> bool:
        """Return whether it can affect goals of an action."""
        return self.injection.spec.get("action") in (None, action)

    def anchors_in(self, timeline: Timeline) -> list[dict[str, Any]]:
        """Return the anchors at which it can begin: moments of its robot, or moments spread over the run."""
        if not self.anchored:
            return []
        robot = self.injection.spec.get("robot")
        anchors = timeline.anchors_for(robot)
        if robot is not None or len(anchors) <= _FEW:
            return anchors
        step = len(anchors) / _FEW
        return [anchors[math.floor(i * step)] for i in range(_FEW)]

    @property
    def starts(self) -> bool:
        """True if it is also tried from the start of a run, before the controller sends a goal, as most faults are.

        Not with each error code, since the first goal is aborted with each of them when it begins. Not with a robot out
        of reach, since a controller, such as a tree, does not begin its mission without its robot.
        """
        injection = self.injection
        own = injection.kind != _UNREACHABLE and "error_code" not in injection.spec
        return self.anchored and injection.family == FAULT and own

    def singles_in(self, timeline: Timeline) -> list[Single]:
        """Return the injection at each moment of a run and from the start; a change of the world as it is."""
        if not self.anchored:
            return [Single(self)]
        starts = [Single(self)] if self.starts and timeline.moments else []
        return [*(Single(self, anchor) for anchor in self.anchors_in(timeline)), *starts]

    def at(self, anchor: Mapping[str, Any]) -> Injection:
        """Return the injection at an anchor."""
        return self.injection.replaced(when=dict(anchor))

    def at_start(self) -> Injection:
        """Return the injection from the start of the run."""
        return self.injection.replaced(at=0.0)


class Single(NamedTuple):
    """A candidate at one moment; its injection is made when it is tried, since there are tens of thousands.

    Attributes:
        anchor: The anchor, in plain values; None for the start of the run.
    """

    candidate: Candidate
    anchor: Mapping[str, Any] | None = None

    @property
    def injection(self) -> Injection:
        """The injection with the time or the anchor that was chosen for it."""
        if self.anchor is not None:
            return self.candidate.at(self.anchor)
        return self.candidate.at_start() if self.candidate.anchored else self.candidate.injection

    @property
    def at_start(self) -> bool:
        """True for a fault that holds from the start of the run."""
        return self.anchor is None and (self.candidate.anchored or self.candidate.injection.at_start)


class Singles:
    """The single injections of a search: each candidate at each moment of a run.

    Args:
        rng: Decides their order.

    Attributes:
        in_order: First every candidate once, then every candidate at another moment, and so on.
    """

    def __init__(self, candidates: Sequence[Candidate], moments: Sequence[Moment], rng: random.Random) -> None:
        self._timeline = Timeline(moments)
        self._candidates = {candidate.injection.key: candidate for candidate in candidates}
        ranked: list[tuple[float, float, Single]] = []
        for candidate in candidates:
            singles = candidate.singles_in(self._timeline)
            rng.shuffle(singles)
            ranked += [(rank / candidate.weight, rng.random(), single) for rank, single in enumerate(singles)]
        ranked.sort(key=lambda each: each[:2])
        self.in_order = [single for _, _, single in ranked]

    def __len__(self) -> int:
        """Return the number of different injections."""
        as_they_are = (each.injection for each in self._candidates.values() if not each.anchored)
        return len(self.in_order) - sum(map(self._in_time, as_they_are))

    def __contains__(self, injection: Injection) -> bool:
        """Return whether an injection is one of them."""
        candidate = self._candidates.get(injection.key)
        return (candidate is not None and not candidate.anchored) or self._in_time(injection)

    def _in_time(self, injection: Injection) -> bool:
        """Return whether an injection is a candidate at one of its moments."""
        candidate = self._candidates.get(injection.replaced(when=None, at=None).key)
        if candidate is None or not candidate.anchored:
            return False
        singles = candidate.singles_in(self._timeline)
        return injection in (single.injection for single in singles if single.anchor in (None, injection.anchor))


class Candidates:
    """The candidates for injections in a check's world.

    Args:
        world: The world, without a schedule.
        moments: The moments of the run without faults.
        draws: The battery draw of each robot in this run.

    Attributes:
        entries: The candidates, in no particular order.
    """

    def __init__(
        self, world: World, space: Space, moments: Sequence[Moment], draws: Mapping[str, Draw] | None = None
    ) -> None:
        self._world, self._space, self._robots = world, space, world.robots
        self._needs = needs_of(world, draws or {})
        asked = [name for name in world.robots if any(moment.robot == name for moment in moments)]
        spec: list[dict[str, Any]] = []
        if "faults" in space.families:
            spec += faults_of(world, moments, space.durations, self._needs)
        if "changes" in space.families:
            spec += changes_of(world, asked, self._needs)
        if "disturbances" in space.families:
            spec += disturbances_of(space.durations)
        injections = [injection for injection in map(Injection, spec) if self._allowed(injection)]
        injections += [Injection(each) for template in space.further for each in expanded(template, [*world.robots])]
        self.entries: list[Candidate] = []
        self._asked = dict.fromkeys((moment.robot, moment.action) for moment in moments if moment.goal)
        self._of_robots: dict[str, list[Candidate]] = {}
        # Candidates that hold from the start, and those that begin at a moment and concern no robot.
        self._changes: list[Candidate] = []
        self._general: list[Candidate] = []
        self._known: dict[str, None] = {}
        self._enter(injections)

    def _add(self, spec: Iterable[dict[str, Any]]) -> None:
        self._enter([injection for injection in map(Injection, spec) if self._allowed(injection)])

    def _enter(self, injections: Iterable[Injection]) -> None:
        """Enter injections that are not candidates yet."""
        for injection in injections:
            if injection.key in self._known:
                continue
            self._known[injection.key] = None
            candidate = Candidate(injection, self._weight(injection))
            robot = injection.spec.get("robot")
            self.entries.append(candidate)
            if not candidate.anchored:
                self._changes.append(candidate)
            else:
                (self._of_robots.setdefault(robot, []) if robot else self._general).append(candidate)

    def _weight(self, injection: Injection) -> float:
        """Return the weight of an injection, which is less for each of the many error codes of an action."""
        return self._space.weights.get(injection.kind, 1.0) * (_CODE if "error_code" in injection.spec else 1.0)

    def allows(self, injection: Injection) -> bool:
        """Return whether a fault of a robot can happen, as the check says."""
        return (
            "faults" in self._space.families
            and self._allowed(injection)
            and injection.spec.get("robot") in self._robots
        )

    def _allowed(self, injection: Injection) -> bool:
        space = self._space
        if space.only is not None and injection.kind not in space.only:
            return False
        if injection.kind in OPT_IN and injection.kind not in (*space.also, *(space.only or ())):
            return False
        return injection.kind not in space.without and injection.subject not in space.spare

    def singles(self, moments: Sequence[Moment], rng: random.Random) -> Singles:
        """Return each injection at each moment of a run."""
        return Singles(self.entries, moments, rng)

    def note(self, moments: Sequence[Moment]) -> None:
        """Add what can happen to robots that are asked for something new in a run, as in a recovery."""
        new = [moment for moment in moments if moment.goal and (moment.robot, moment.action) not in self._asked]
        if new and "faults" in self._space.families:
            self._asked |= dict.fromkeys((moment.robot, moment.action) for moment in new)
            self._add(faults_of(self._world, new, self._space.durations, self._needs))

    def any(self, moments: Sequence[Moment], rng: random.Random) -> Injection | None:
        """Return something at some moment, by the weights; rather something that happens to the robot of that moment.

        None if nothing can happen.
        """
        changes, others = self._changes, self._general
        if changes and (rng.random() < _CHANGES or not moments):
            return _chosen(changes, rng).injection
        if not moments:
            return None
        moment = rng.choice(moments)
        own = self._of_robots.get(moment.robot, [])
        if moment.goal == "executing":
            own = [candidate for candidate in own if candidate.suits(moment.action)]
        entries = own if own and (not others or rng.random() < _OWN) else others
        if not entries:
            return _chosen(changes, rng).injection if changes else None
        candidate = _chosen(entries, rng)
        if candidate.starts and rng.random() < _STARTS:
            return candidate.at_start()
        return candidate.at(rng.choice(Timeline(moments).anchors_of(moment)))


def _chosen(entries: Sequence[Candidate], rng: random.Random) -> Candidate:
    return rng.choices(entries, [candidate.weight for candidate in entries])[0]


def expanded(template: Mapping[str, Any], robots: Sequence[str]) -> list[dict[str, Any]]:
    """Return what a template of a file stands for: each combination of the values in its lists.

    A robot ``*`` stands for each robot. A lane, and what is inside of a mapping, is no list of values.
    """
    fields = {
        name: [*robots] if (name, value) == ("robot", "*") else value if _several(name, value) else [value]
        for name, value in template.items()
    }
    return [dict(zip(fields, values, strict=True)) for values in itertools.product(*fields.values())]


def _several(name: str, value: object) -> bool:
    return isinstance(value, list) and (name != "lane" or all(isinstance(each, list) for each in value))
