"""The menu of a search: all that can happen, each with the moments at which it can begin."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from hmrsim.fault_search.schedule import CHANGE, FAULT, Thing
from hmrsim.fault_search.space.kinds import changes_of, disturbances_of, faults_of, needs_of
from hmrsim.fault_search.space.model import OPT_IN

if TYPE_CHECKING:
    import random

    from hmrsim.fault_search.schedule import Moment
    from hmrsim.fault_search.space.kinds import Draw
    from hmrsim.fault_search.space.model import Space
    from hmrsim.world.model import World

_FEW: Final = 12
"""Moments at which something begins that is about no robot; they are spread over the run."""

_OWN: Final = 0.75
"""How often something happens to the robot of a moment, rather than to a lane, a door or the controller."""
_CHANGES: Final = 0.1
"""How often the world is changed, rather than something begins at a moment."""
_STARTS: Final = 0.05
"""How often a fault holds from the start, rather than begins at a moment."""
_UNREACHABLE: Final = "messages_lost"
"""The fault by which a robot can't be reached."""
_CODE: Final = 0.1
"""How often a goal is aborted with one particular error code, beside 1."""


class Timeline:
    """The moments of a run, and the anchors at which something can begin in it, in plain values.

    Args:
        moments: What happens in the run.
    """

    def __init__(self, moments: Sequence[Moment]) -> None:
        self.moments = moments
        self._lasted: dict[tuple[str, str, int], float] = {}
        for each in moments:
            if each.goal == "ended":
                self._lasted.setdefault((each.robot, each.action, each.nth), each.lasted)

    def anchors_of(self, moment: Moment) -> list[dict[str, Any]]:
        """Return the anchors of a moment: itself, and the middle of a goal that begins then."""
        if moment.goal == "executing":
            lasted = self._lasted.get((moment.robot, moment.action, moment.nth), 0.0)
            if lasted > 0:
                return [moment.anchor(), moment.anchor(round(lasted / 2, 3))]
        return [moment.anchor()]

    def anchors_for(self, robot: str | None) -> list[dict[str, Any]]:
        """Return the anchors of what happens to a robot; None for all."""
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
class Entry:
    """Something that can happen, at one of several moments.

    Attributes:
        thing: What happens, without an anchor.
        weight: How often it is tried, beside 1.
    """

    thing: Thing
    weight: float

    @property
    def anchored(self) -> bool:
        """Whether it begins at a moment; a change of the world holds from the start."""
        return self.thing.family != CHANGE and not self.thing.said.get("when") and "at" not in self.thing.said

    def suits(self, action: str) -> bool:
        """Return whether it can have an effect when a goal of an action begins: not on those of another action."""
        return self.thing.said.get("action") in (None, action)

    def anchors_in(self, timeline: Timeline) -> list[dict[str, Any]]:
        """Return the anchors at which it can begin in a run, in plain values.

        A thing of a robot begins at what happens to the robot, another one at moments that are spread over the run.
        """
        if not self.anchored:
            return []
        robot = self.thing.said.get("robot")
        anchors = timeline.anchors_for(robot)
        if robot is not None or len(anchors) <= _FEW:
            return anchors
        step = len(anchors) / _FEW
        return [anchors[math.floor(i * step)] for i in range(_FEW)]

    @property
    def starts(self) -> bool:
        """Whether it is also tried from the start of a run, before the controller has asked for anything: a fault is.

        The many error codes are not: the first goal is aborted with each of them as well when it begins. Nor is a robot
        out of reach: a controller whose robot is not there, such as a tree, does not begin its mission.
        """
        thing = self.thing
        own = thing.kind != _UNREACHABLE and "error_code" not in thing.said
        return self.anchored and thing.family == FAULT and own

    def things_in(self, timeline: Timeline) -> list[Thing]:
        """Return it as it begins at each moment of a run, and from the start; a change of the world as it is.

        In a run in which nothing happens, nothing can begin.
        """
        if not self.anchored:
            return [self.thing]
        starts = [self.at_start()] if self.starts and timeline.moments else []
        return [*(self.at(anchor) for anchor in self.anchors_in(timeline)), *starts]

    def at(self, anchor: Mapping[str, Any]) -> Thing:
        """Return it as it begins at an anchor."""
        return self.thing.replaced(when=dict(anchor))

    def at_start(self) -> Thing:
        """Return it as it holds when a run begins."""
        return self.thing.replaced(at=0.0)


class Menu:
    """All that can happen in a check's world.

    Args:
        world: The world, without a schedule.
        space: What the check says of it.
        moments: What happens in a run without faults.
        draws: What each robot takes from its battery in it.

    Attributes:
        entries: What can happen; the order means nothing.
    """

    def __init__(
        self, world: World, space: Space, moments: Sequence[Moment], draws: Mapping[str, Draw] | None = None
    ) -> None:
        self._world, self._space, self._robots = world, space, world.robots
        self._needs = needs_of(world, draws or {})
        asked = [name for name in world.robots if any(moment.robot == name for moment in moments)]
        said: list[dict[str, Any]] = []
        if "faults" in space.families:
            said += faults_of(world, moments, space.durations, self._needs)
        if "changes" in space.families:
            said += changes_of(world, asked, self._needs)
        if "disturbances" in space.families:
            said += disturbances_of(space.durations)
        things = [thing for thing in map(Thing, said) if self._allowed(thing)]
        things += [Thing(each) for template in space.further for each in expanded(template, [*world.robots])]
        self.entries: list[Entry] = []
        self._asked = dict.fromkeys((moment.robot, moment.action) for moment in moments if moment.goal)
        self._of_robots: dict[str, list[Entry]] = {}
        # What holds from the start, and what begins at a moment and is about no robot.
        self._changes: list[Entry] = []
        self._general: list[Entry] = []
        self._known: dict[str, None] = {}
        self._enter(things)

    def _add(self, said: Iterable[dict[str, Any]]) -> None:
        self._enter([thing for thing in map(Thing, said) if self._allowed(thing)])

    def _enter(self, things: Iterable[Thing]) -> None:
        """Enter things that are not on the menu yet."""
        for thing in things:
            if thing.key in self._known:
                continue
            self._known[thing.key] = None
            entry = Entry(thing, self._weight(thing))
            robot = thing.said.get("robot")
            self.entries.append(entry)
            if not entry.anchored:
                self._changes.append(entry)
            else:
                (self._of_robots.setdefault(robot, []) if robot else self._general).append(entry)

    def _weight(self, thing: Thing) -> float:
        """Return how often a thing is tried; each of the many error codes of an action less often."""
        return self._space.weights.get(thing.kind, 1.0) * (_CODE if "error_code" in thing.said else 1.0)

    def allows(self, thing: Thing) -> bool:
        """Return whether a fault of a robot can happen, as the check says."""
        return "faults" in self._space.families and self._allowed(thing) and thing.said.get("robot") in self._robots

    def _allowed(self, thing: Thing) -> bool:
        space = self._space
        if space.only is not None and thing.kind not in space.only:
            return False
        if thing.kind in OPT_IN and thing.kind not in (*space.also, *(space.only or ())):
            return False
        return thing.kind not in space.without and thing.subject not in space.spare

    def singles(self, moments: Sequence[Moment], rng: random.Random) -> list[Thing]:
        """Return each thing at each moment: first everything once, then everything at another moment, and so on."""
        ranked: list[tuple[float, float, Thing]] = []
        timeline = Timeline(moments)
        for entry in self.entries:
            things = entry.things_in(timeline)
            rng.shuffle(things)
            ranked += [(rank / entry.weight, rng.random(), thing) for rank, thing in enumerate(things)]
        ranked.sort(key=lambda each: each[:2])
        return [thing for _, _, thing in ranked]

    def note(self, moments: Sequence[Moment]) -> None:
        """Add what can happen to robots that are asked for something new, as in a recovery.

        Args:
            moments: What has happened in a run.
        """
        new = [moment for moment in moments if moment.goal and (moment.robot, moment.action) not in self._asked]
        if new and "faults" in self._space.families:
            self._asked |= dict.fromkeys((moment.robot, moment.action) for moment in new)
            self._add(faults_of(self._world, new, self._space.durations, self._needs))

    def any(self, moments: Sequence[Moment], rng: random.Random) -> Thing | None:
        """Return something at some moment, by the weights; rather something that happens to the robot of that moment.

        None if nothing can happen.
        """
        changes, others = self._changes, self._general
        if changes and (rng.random() < _CHANGES or not moments):
            return _chosen(changes, rng).thing
        if not moments:
            return None
        moment = rng.choice(moments)
        own = self._of_robots.get(moment.robot, [])
        if moment.goal == "executing":
            own = [entry for entry in own if entry.suits(moment.action)]
        entries = own if own and (not others or rng.random() < _OWN) else others
        if not entries:
            return _chosen(changes, rng).thing if changes else None
        entry = _chosen(entries, rng)
        if entry.starts and rng.random() < _STARTS:
            return entry.at_start()
        return entry.at(rng.choice(Timeline(moments).anchors_of(moment)))


def _chosen(entries: Sequence[Entry], rng: random.Random) -> Entry:
    return rng.choices(entries, [entry.weight for entry in entries])[0]


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
