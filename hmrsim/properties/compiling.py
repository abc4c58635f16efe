"""Making what watches over each property of a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.events import EventPattern
from hmrsim.properties.conditions.binding import bound_names, for_robot, speaks_of_each
from hmrsim.properties.conditions.expressions import prepare
from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.model import operators as said
from hmrsim.properties.model import patterns as pattern
from hmrsim.properties.model.conditions import BatteryCondition, ItemsCondition
from hmrsim.properties.model.formulas import Formula
from hmrsim.properties.model.part import EACH, walk
from hmrsim.properties.operators.coming import Coming, Happening
from hmrsim.properties.operators.each import Each
from hmrsim.properties.operators.formulas import Following, in_words
from hmrsim.properties.operators.holding import Holding
from hmrsim.properties.operators.incomparable import Incomparable
from hmrsim.properties.operators.reporting import Reporting
from hmrsim.properties.operators.whenever import Whenever
from hmrsim.properties.patterns import orders
from hmrsim.properties.patterns.avoidance import AvoidedAfter, Counted, HeldUntil
from hmrsim.properties.patterns.patrols import Patrolling
from hmrsim.properties.patterns.reactions import Bound, BoundLater, Delayed, Instantaneous, Prompt
from hmrsim.properties.patterns.visits import Visiting

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.model.file import Properties
    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Tell
    from hmrsim.properties.watcher import Watcher
    from hmrsim.world.model import World


@dataclass(frozen=True)
class _Making:
    """What all watchers of a property have in common.

    Attributes:
        part: The property for one robot, if it is about each.
        whole: The property as the file has it.
        subject: The robot; empty for none.
    """

    name: str
    part: Any
    whole: Any
    subject: str
    observations: Observations
    tell: Tell

    @property
    def whom(self) -> tuple[str, str]:
        """The first arguments of each watcher."""
        return self.name, self.subject

    @property
    def what(self) -> tuple[Observations, Tell]:
        """The last ones."""
        return self.observations, self.tell


def watchers_of(properties: Properties, observations: Observations, tell: Tell) -> list[Watcher]:
    """Return what watches over the properties of a file, in its order."""
    return [_watcher(name, part, observations, tell) for name, part in properties.properties.items()]


def compares(part: BaseModel) -> bool:
    """Return whether a property, or a file of them, compares a run with the one without faults."""
    return any(isinstance(each, ItemsCondition) for _, each in walk(part))


def robots_of(part: BaseModel, world: World) -> list[str]:
    """Return the robots that a property about each robot is about."""
    powered = any(isinstance(each, BatteryCondition) and each.battery == EACH for _, each in walk(part))
    robots = world.robots
    return [name for name, spec in robots.items() if not powered or "battery" in world.robot_type(spec).components]


def _watcher(name: str, part: BaseModel, observations: Observations, tell: Tell) -> Watcher:
    if observations.reference is None and compares(part):
        return Incomparable(name, tell)
    if not speaks_of_each(part):
        return _made(_Making(name, part, part, _subject(part), observations, tell))

    def make(robot: str) -> Watcher:
        return _made(_Making(name, for_robot(part, robot), part, robot, observations, tell))

    # A robot may come to a world that has none yet.
    prepare(part, observations)
    robots = robots_of(part, observations.world)
    return Each(name, robots, make, observations.timeline, tell, all_count=isinstance(part, said.Sometimes))


def _subject(part: BaseModel) -> str:
    """Return the only robot that a property speaks of; empty if it speaks of none, or of several."""
    named = {
        value
        for _, each in walk(part)
        for field in ("robot", "battery")
        if isinstance(value := getattr(each, field, None), str) and not value.startswith("$")
    }
    return named.pop() if len(named) == 1 else ""


def _made(making: _Making) -> Watcher:
    return _KINDS[type(making.part)](making)


def _always(making: _Making) -> Watcher:
    part, whole = making.part.always, making.whole.always
    return Holding(*making.whom, part, describe(whole), *making.what)


def _never(making: _Making, field: str = "never") -> Watcher:
    part, whole = getattr(making.part, field), getattr(making.whole, field)
    return Holding(*making.whom, part, describe(whole), *making.what, never=True)


def _eventually(making: _Making) -> Watcher:
    words = describe(making.whole.eventually)
    return Coming(*making.whom, making.part.eventually, words, *making.what, within=making.part.within)


def _reports(making: _Making) -> Watcher:
    part, words = making.part, describe(making.whole.then)
    return Reporting(*making.whom, part.reports, part.then, words, *making.what)


def _sometimes(making: _Making) -> Watcher:
    return Happening(*making.whom, making.part.sometimes, *making.what)


def _formula(making: _Making) -> Watcher:
    return Following(*making.whom, making.part.formula, in_words(making.whole.formula), *making.what)


def _whenever(making: _Making, trigger: str = "whenever", within: float | None = None) -> Watcher:
    part = making.part
    within = getattr(part, "within", within)
    conditions = getattr(part, trigger), part.then
    return Whenever(*making.whom, conditions, describe(making.whole.then), *making.what, within=within)


def _visits(field: str, order: orders.Made, *, in_sequence: bool) -> Callable[[_Making], Watcher]:
    def make(making: _Making) -> Watcher:
        part = making.part
        places = getattr(part, field)
        return Visiting(
            making.name, part.robot, places, order, *making.what, in_sequence=in_sequence, within=part.within
        )

    return make


def _patrols(field: str, order: orders.Made, *, in_sequence: bool) -> Callable[[_Making], Watcher]:
    def make(making: _Making) -> Watcher:
        part = making.part
        places = getattr(part, field)
        return Patrolling(
            making.name, part.robot, places, order, *making.what, in_sequence=in_sequence, every=part.every
        )

    return make


def _pair(making: _Making, fields: tuple[str, str]) -> tuple[Any, tuple[str, str]]:
    first, second = ((getattr(part, fields[0]), getattr(part, fields[1])) for part in (making.part, making.whole))
    return first, (describe(second[0]), describe(second[1]))


def _held_until(field: str, *, avoided: bool) -> Callable[[_Making], Watcher]:
    def make(making: _Making) -> Watcher:
        return HeldUntil(*making.whom, *_pair(making, (field, "until")), *making.what, avoided=avoided)

    return make


def _avoided_after(making: _Making) -> Watcher:
    return AvoidedAfter(*making.whom, *_pair(making, ("future_avoidance", "after")), *making.what)


def _counted(field: str, *, least: bool = False, most: bool = False) -> Callable[[_Making], Watcher]:
    def make(making: _Making) -> Watcher:
        condition, words = getattr(making.part, field), describe(getattr(making.whole, field))
        count = making.part.count
        limits = {**({"least": count} if least else {}), **({"most": count} if most else {})}
        return Counted(*making.whom, condition, words, *making.what, **limits)

    return make


def _reaction(field: str, kind: type[Instantaneous | Bound | Prompt]) -> Callable[[_Making], Watcher]:
    return lambda making: kind(*making.whom, *_pair(making, (field, "then")), *making.what)


def _instantaneous(making: _Making) -> Watcher:
    if _binds(making.part.instantaneous_reaction, making.part.then):
        return _whenever(making, "instantaneous_reaction", within=0.0)
    return _reaction("instantaneous_reaction", Instantaneous)(making)


def _delayed(making: _Making) -> Watcher:
    if _binds(making.part.delayed_reaction, making.part.then):
        return _whenever(making, "delayed_reaction")
    return Delayed(*making.whom, *_pair(making, ("delayed_reaction", "then")), *making.what, within=making.part.within)


def _binds(trigger: BaseModel, then: BaseModel) -> bool:
    return isinstance(trigger, EventPattern) and bool(bound_names(then))


_KINDS: Final[Mapping[type, Callable[[_Making], Watcher]]] = MappingProxyType(
    {
        said.Always: _always,
        said.Never: _never,
        said.Eventually: _eventually,
        said.Sometimes: _sometimes,
        said.Whenever: _whenever,
        said.Reports: _reports,
        Formula: _formula,
        pattern.Visit: _visits("visit", orders.AnyOrder, in_sequence=False),
        pattern.SequencedVisit: _visits("sequenced_visit", orders.AnyOrder, in_sequence=True),
        pattern.OrderedVisit: _visits("ordered_visit", orders.FirstInOrder, in_sequence=True),
        pattern.StrictOrderedVisit: _visits("strict_ordered_visit", orders.FirstInStrictOrder, in_sequence=True),
        pattern.FairVisit: _visits("fair_visit", orders.Fair, in_sequence=False),
        pattern.Patrolling: _patrols("patrolling", orders.AnyOrder, in_sequence=False),
        pattern.SequencedPatrolling: _patrols("sequenced_patrolling", orders.AnyOrder, in_sequence=True),
        pattern.OrderedPatrolling: _patrols("ordered_patrolling", orders.RoundsInOrder, in_sequence=True),
        pattern.StrictOrderedPatrolling: _patrols(
            "strict_ordered_patrolling", orders.RoundsInStrictOrder, in_sequence=True
        ),
        pattern.FairPatrolling: _patrols("fair_patrolling", orders.Fair, in_sequence=False),
        pattern.PastAvoidance: _held_until("past_avoidance", avoided=True),
        pattern.GlobalAvoidance: lambda making: _never(making, "global_avoidance"),
        pattern.FutureAvoidance: _avoided_after,
        pattern.UpperRestrictedAvoidance: _counted("upper_restricted_avoidance", most=True),
        pattern.ExactRestrictedAvoidance: _counted("exact_restricted_avoidance", least=True, most=True),
        pattern.LowerRestrictedAvoidance: _counted("lower_restricted_avoidance", least=True),
        pattern.Wait: _held_until("wait", avoided=False),
        pattern.InstantaneousReaction: _instantaneous,
        pattern.DelayedReaction: _delayed,
        pattern.PromptReaction: _reaction("prompt_reaction", Prompt),
        pattern.BoundReaction: _reaction("bound_reaction", Bound),
        pattern.BoundDelay: _reaction("bound_delay", BoundLater),
    }
)
