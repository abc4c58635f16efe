"""The watchers of properties: those of a file, and the built-in ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.events import EventPattern
from hmrsim.properties import arrivals
from hmrsim.properties.arrivals import Patrol, Visit
from hmrsim.properties.controller_properties import ControllerLives, GoalsEnd, MissionEnds, NoVainGoals, Recovers
from hmrsim.properties.fleet_properties import NobodyStranded, NoDeadlock, OrdersInTime
from hmrsim.properties.formulas import Windows
from hmrsim.properties.model.conditions import BatteryCondition, ItemsCondition
from hmrsim.properties.model.part import BOUND, EACH, bound_names, for_robot, key_of, speaks_of_each, walk
from hmrsim.properties.model.property import KINDS, Sometimes
from hmrsim.properties.operators import Always, Eventually, Instance, Never, Reports
from hmrsim.properties.operators import Sometimes as Happening
from hmrsim.properties.patterns import AvoidedAfter, Counted, DelayedReaction, HeldUntil, Reaction, Whenever
from hmrsim.properties.terms import prepare
from hmrsim.properties.watcher import Each, Incomparable

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.history.timeline import Timeline
    from hmrsim.properties.model.file import BuiltIn, Properties
    from hmrsim.properties.observations import Observations
    from hmrsim.properties.results import OnViolation
    from hmrsim.properties.watcher import Watcher
    from hmrsim.world.model import World


def watchers_of(properties: Properties, observations: Observations, on_violation: OnViolation) -> list[Watcher]:
    """Return the watchers of the properties of a file, in its order."""
    return [_watcher(name, part, observations, on_violation) for name, part in properties.properties.items()]


def built_in_watchers(settings: BuiltIn, world: World, timeline: Timeline, on_violation: OnViolation) -> list[Watcher]:
    """Return the watchers of the properties that are switched on, in the order of their settings."""
    found: list[Watcher] = []
    if settings.goals_end:
        found.append(GoalsEnd(timeline, on_violation))
    if settings.no_deadlock:
        found.append(NoDeadlock(settings.no_deadlock, timeline, on_violation))
    if settings.nobody_stranded:
        batteries = any("battery" in world.robot_type(robot).components for robot in world.robots.values())
        found.append(NobodyStranded(settings.nobody_stranded, timeline, on_violation, batteries=batteries))
    if settings.orders_in_time:
        found.append(OrdersInTime(timeline, on_violation))
    if settings.controller_lives:
        found.append(ControllerLives(timeline, on_violation))
    if settings.no_vain_goals:
        found.append(NoVainGoals(settings.no_vain_goals, timeline, on_violation))
    if settings.mission_ends:
        found.append(MissionEnds(on_violation))
    if settings.recovers:
        found.append(Recovers(settings.recovers.within, timeline, on_violation))
    return found


def compares(part: BaseModel) -> bool:
    """Return whether a property, or a file of them, compares a run with the one without faults."""
    return any(isinstance(each, ItemsCondition) for _, each in walk(part))


def robots_of(part: BaseModel, world: World) -> list[str]:
    """Return the robots that a property about each robot is about."""
    powered = any(isinstance(each, BatteryCondition) and each.battery == EACH for _, each in walk(part))
    robots = world.robots
    return [name for name, spec in robots.items() if not powered or "battery" in world.robot_type(spec).components]


def _watcher(name: str, part: BaseModel, observations: Observations, on_violation: OnViolation) -> Watcher:
    if observations.reference is None and compares(part):
        return Incomparable(name, on_violation)
    make = _MAKERS[key_of(part, KINDS) or ""]
    if not speaks_of_each(part):
        return make(Instance(name, part, part, _subject(part), observations, on_violation))

    def for_each(robot: str) -> Watcher:
        return make(Instance(name, for_robot(part, robot), part, robot, observations, on_violation))

    # A robot may be spawned in a world that has none yet.
    prepare(part, observations)
    robots = robots_of(part, observations.world)
    return Each(name, robots, for_each, observations.timeline, on_violation, all_count=isinstance(part, Sometimes))


def _subject(part: BaseModel) -> str:
    """Return the only robot that a property is about; empty if it is about none, or several."""
    names = {
        value
        for _, each in walk(part)
        for field in ("robot", "battery")
        if isinstance(value := vars(each).get(field), str) and not value.startswith(BOUND)
    }
    return names.pop() if len(names) == 1 else ""


def _instantaneous(of: Instance) -> Watcher:
    field = "instantaneous_reaction"
    return Whenever(of, field, 0.0) if _binds(of, field) else Reaction(of, field)


def _delayed(of: Instance) -> Watcher:
    field = "delayed_reaction"
    return Whenever(of, field, of.part.within) if _binds(of, field) else DelayedReaction(of)


def _binds(of: Instance, field: str) -> bool:
    return isinstance(getattr(of.part, field), EventPattern) and bool(bound_names(of.part.then))


_Maker = Callable[[Instance], "Watcher"]

_ORDERS: Final = {
    "visit": arrivals.in_any_order,
    "sequenced_visit": arrivals.in_any_order,
    "ordered_visit": arrivals.in_order,
    "strict_ordered_visit": arrivals.in_strict_order,
    "fair_visit": arrivals.fair,
    "patrolling": arrivals.in_any_order,
    "sequenced_patrolling": arrivals.in_any_order,
    "ordered_patrolling": arrivals.in_rounds,
    "strict_ordered_patrolling": arrivals.in_strict_rounds,
    "fair_patrolling": arrivals.fair,
}
_IN_ANY_SEQUENCE: Final = ("visit", "fair_visit", "patrolling", "fair_patrolling")


def _of_arrivals(field: str) -> _Maker:
    kind, limit = (Visit, "within") if field.endswith("visit") else (Patrol, "every")
    return partial(kind, field=field, limit=limit, order=_ORDERS[field], in_sequence=field not in _IN_ANY_SEQUENCE)


_MAKERS: Final[Mapping[str, _Maker]] = MappingProxyType(
    {
        "always": Always,
        "never": Never,
        "eventually": Eventually,
        "sometimes": Happening,
        "whenever": lambda of: Whenever(of, "whenever", of.part.within),
        "reports": Reports,
        "formula": Windows,
        **{field: _of_arrivals(field) for field in _ORDERS},
        "past_avoidance": partial(HeldUntil, field="past_avoidance", avoided=True),
        "global_avoidance": partial(Never, field="global_avoidance"),
        "future_avoidance": AvoidedAfter,
        "upper_restricted_avoidance": partial(Counted, field="upper_restricted_avoidance", most=True),
        "exact_restricted_avoidance": partial(Counted, field="exact_restricted_avoidance", least=True, most=True),
        "lower_restricted_avoidance": partial(Counted, field="lower_restricted_avoidance", least=True),
        "wait": partial(HeldUntil, field="wait", avoided=False),
        "instantaneous_reaction": _instantaneous,
        "delayed_reaction": _delayed,
        "prompt_reaction": partial(Reaction, field="prompt_reaction"),
        "bound_reaction": partial(Reaction, field="bound_reaction"),
        "bound_delay": partial(Reaction, field="bound_delay"),
    }
)
"""By the key of a property."""
