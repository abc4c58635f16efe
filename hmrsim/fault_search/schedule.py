"""The injections of a schedule: a fault, a change of the world, or a disturbance of the wire or the controller."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from pydantic import ValidationError

from hmrsim.actions import error_codes
from hmrsim.actions import registry as actions
from hmrsim.diagnostics import Finding, instead, shown
from hmrsim.documents.validation import explain
from hmrsim.events import registry as events
from hmrsim.faults import SUBJECTS, Anchor
from hmrsim.faults import registry as faults
from hmrsim.trials.disturbances import Disturbance
from hmrsim.world.model import FaultEntry
from hmrsim.world.overlays.overlay import Overlay, overlay_of
from hmrsim.world_checks.faults import read_fault

if TYPE_CHECKING:
    from hmrsim.world.model import World

FAULT, CHANGE, DISTURBANCE = "type", "change", "disturbance"
"""The key by which an injection is a fault, a change or a disturbance."""

_KEYS: Final = (FAULT, CHANGE, DISTURBANCE)


@dataclass(frozen=True)
class Injection:
    """An injection of a schedule: a fault, a change of the world, or a disturbance.

    Attributes:
        spec: As in a file: an entry of a world's ``faults``, ``{"change": {PATH: VALUE}}`` or
            ``{"disturbance": KIND, …}``.
    """

    spec: Mapping[str, Any]

    @cached_property
    def key(self) -> str:
        """The injection in canonical JSON; equal injections have equal keys."""
        return json.dumps(self.spec, sort_keys=True, separators=(",", ":"))

    def __hash__(self) -> int:
        """Return the hash of its key."""
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        """Return whether another injection is equal."""
        return isinstance(other, Injection) and other.key == self.key

    @cached_property
    def family(self) -> str:
        """``type`` for a fault, ``change`` or ``disturbance``."""
        return next(key for key in _KEYS if key in self.spec)

    @cached_property
    def kind(self) -> str:
        """The type of a fault, the kind of a disturbance, or the last step of a change's paths."""
        if self.family == CHANGE:
            first = next(iter(self.spec[CHANGE]), "")
            return "absent" if first.startswith("~") else first.rpartition(".")[2] or CHANGE
        return str(self.spec[self.family])

    @property
    def subject(self) -> str:
        """The object that it affects: a robot, door, dock, item or lane; may be empty."""
        for name in SUBJECTS:
            value = self.spec.get(name)
            if value:
                return "-".join(value) if isinstance(value, (list, tuple)) else str(value)
        if self.family == CHANGE:
            first = next(iter(self.spec[CHANGE]), "")
            parts = first.lstrip("~").split(".")
            return parts[1] if len(parts) > 1 else parts[0]
        return ""

    @property
    def anchor(self) -> Mapping[str, Any]:
        """The anchor, in plain values; empty if it has none."""
        return self.spec.get("when") or {}

    @cached_property
    def awaited(self) -> What:
        """The moment that it is anchored to; one that never comes if it has no anchor."""
        anchor = self.anchor
        goal, event, robot, action = (str(anchor.get(field, "")) for field in ("goal", "event", "robot", "action"))
        return goal, event, robot, action, anchor.get("nth", 1)

    @property
    def transient(self) -> bool:
        """True for a fault that ends by itself, after some seconds or goals."""
        return self.family == FAULT and ("duration" in self.spec or "count" in self.spec)

    @property
    def at_start(self) -> bool:
        """True for a fault that holds from the start of the run."""
        return self.family == FAULT and self.spec.get("at") == 0.0

    def replaced(self, **values: Any) -> Injection:
        """Return a copy with some values replaced, or removed if None."""
        spec = {**self.spec, **values}
        return Injection({key: value for key, value in spec.items() if value is not None})

    def describe(self) -> str:
        """Return it in words, such as ``claw_misses of wall_e for 20 s, when pickup of wall_e is executing``."""
        if self.family == CHANGE:
            return ", ".join(_change(path, value) for path, value in self.spec[CHANGE].items())
        if self.kind in _OF_GOALS and self.spec.get("action") and "count" in self.spec:
            return self._goals()
        fault = faults().get(self.kind) if self.family == FAULT else None
        if fault is not None and fault.text:
            return f"{fault.text.format_map(self.spec)}{self._when()}"
        parts = [self.kind + (f" of {self.subject}" if self.subject else "")]
        further = {key: value for key, value in self.spec.items() if key not in _TOLD}
        if further:
            parts.append("(" + ", ".join(f"{key} {_plain(value)}" for key, value in further.items()) + ")")
        if "duration" in self.spec:
            parts.append(f"for {_plain(self.spec['duration'])} s")
        return f"{' '.join(parts)}{self._when()}"

    def _goals(self) -> str:
        """Return what happens to goals, such as ``the 2nd pickup of eve is aborted``."""
        action, count, anchor, becomes = self.spec["action"], self.spec["count"], self.anchor, _OF_GOALS[self.kind]
        code = f" with code {self._code()}" if "error_code" in self.spec else ""
        own = (anchor.get("goal"), anchor.get("robot"), anchor.get("action")) == ("executing", self.subject, action)
        known = self.at_start or (own and not anchor.get("after") and self.kind == "goals_aborted")
        which = _ordinal(anchor.get("nth", 1)) if known else "next"
        if count == 1:
            what = f"the {which} {action} of {self.subject} is {becomes}{code}"
        elif known:
            what = f"{count} times in a row a {action} of {self.subject} is {becomes}{code}, from the {which} on"
        else:
            what = f"the next {count} times a {action} of {self.subject} is {becomes}{code}"
        return what if known else f"{what}{self._when()}"

    def _code(self) -> str:
        """Return the error code with its name, such as ``-7 (PREEMPTED)``."""
        code, action = self.spec["error_code"], actions().get(self.spec["action"])
        name = error_codes(action).get(code) if action is not None else None
        return f"{code} ({name})" if name else str(code)

    def _when(self) -> str:
        if self.anchor:
            return f", {described(Anchor.model_validate(self.anchor))}"
        at = self.spec.get("at")
        return "" if at is None else ", from the start" if self.at_start else f", at {_plain(at)} s"


_OF_GOALS: Final = {"goals_aborted": "aborted", "goals_rejected": "rejected"}


def _ordinal(number: int) -> str:
    last = 0 if number // 10 % 10 == 1 else number % 10
    return f"{number}{('th', 'st', 'nd', 'rd')[last] if last <= 3 else 'th'}"  # noqa: PLR2004 - as in 4th


_TOLD: Final = (FAULT, DISTURBANCE, "when", "at", "duration", "name", *SUBJECTS)


def described(anchor: Anchor) -> str:
    """Return an anchor in words, such as ``0.5 s after pickup of eve is executing (number 2)``."""
    if anchor.event and anchor.robot and not anchor.where and (happens := _meaning_of(anchor.event)):
        when = f"{anchor.after:g} s after" if anchor.after else "when"
        number = f", number {anchor.nth}" if anchor.nth > 1 else ""
        return f"{when} {anchor.robot} {happens} (event {anchor.event}{number})"
    return anchor.describe() if anchor.after else f"when {anchor.describe()}"


def _meaning_of(event: str) -> str:
    """Return what a robot does at an event, such as ``picks up an item``; empty if it is about something else."""
    kind = events().get(event)
    text = " ".join((kind.__doc__ or "").split()) if kind else ""
    return re.split(r"[.,;:]", text.removeprefix(_A_ROBOT))[0] if text.startswith(_A_ROBOT) else ""


_A_ROBOT: Final = "A robot "
"""The beginning of the descriptions of events that are about one robot."""


def _change(path: str, value: Any) -> str:
    return f"{path[1:]} removed" if path.startswith("~") else f"{path} = {_plain(value)}"


def _plain(value: Any) -> str:
    return (
        f"{value:g}" if isinstance(value, float) else str(value) if not isinstance(value, dict) else json.dumps(value)
    )


Schedule = tuple[Injection, ...]
"""The injections of a run; their order only decides between two at the same instant."""


def read_injections(values: object) -> tuple[Schedule, list[Finding]]:
    """Return the injections that plain values describe, and all flaws, with paths that begin at the list."""
    if not isinstance(values, (list, tuple)):
        return (), [Finding((), f"expected a list of faults, changes and disturbances, got {shown(values)}", values)]
    injections: list[Injection] = []
    findings: list[Finding] = []
    for i, spec in enumerate(values):
        found = [*_flaws(spec)]
        findings += [each.within(i) for each in found]
        if not found:
            injections.append(Injection(spec))
    return tuple(injections), findings


def _flaws(spec: object) -> Iterator[Finding]:
    if not isinstance(spec, dict):
        yield Finding((), f"expected a mapping with {', '.join(_KEYS[:-1])} or {_KEYS[-1]}, got {shown(spec)}", spec)
        return
    families = [key for key in _KEYS if key in spec]
    if len(families) != 1:
        unknown = next((key for key in spec if key not in _KEYS), "")
        hint = instead(unknown, _KEYS) if unknown and not families else ""
        yield Finding((), f"expected one of {', '.join(_KEYS[:-1])} and {_KEYS[-1]}{hint}", spec)
        return
    yield from _READERS[families[0]](spec)


def _fault(spec: dict[str, Any]) -> Iterator[Finding]:
    found = read_fault(str(spec[FAULT]), {key: value for key, value in spec.items() if key != FAULT})
    if isinstance(found, list):
        yield from found
    elif found[1].when is not None:
        yield from _of_anchor(found[1].when)


def _change_flaws(spec: dict[str, Any]) -> Iterator[Finding]:
    if not isinstance(spec[CHANGE], dict) or not spec[CHANGE]:
        message = "expected a mapping of paths to values such as robots.eve.base.speed: 0.2"
        yield Finding((CHANGE,), f"{message}, got {shown(spec[CHANGE])}", spec[CHANGE])
    for key, value in spec.items():
        if key != CHANGE:
            yield Finding((key,), f"a change has no key {key!r}; it holds from the start", value)


def _disturbance(spec: dict[str, Any]) -> Iterator[Finding]:
    try:
        disturbance = Disturbance.model_validate(spec)
    except ValidationError as error:
        yield from explain(error, spec, Disturbance)
        return
    if disturbance.when is not None:
        yield from _of_anchor(disturbance.when)


def _of_anchor(anchor: Anchor) -> Iterator[Finding]:
    for flaw in anchor.flaws():
        yield flaw.within("when")


_READERS: Final[Mapping[str, Callable[[dict[str, Any]], Iterator[Finding]]]] = {
    FAULT: _fault,
    CHANGE: _change_flaws,
    DISTURBANCE: _disturbance,
}


What = tuple[str, str, str, str, int]
"""The change of a goal, the kind of event, the robot, the action, and the number among equal ones."""


class Moment(NamedTuple):
    """The nth change of a goal, or the nth event of a kind.

    Attributes:
        at: The time in simulated seconds.
        goal: The change of a goal: ``executing`` or ``ended``; empty for an event.
        event: The kind of event; empty for a goal.
        robot: The robot; empty for none.
        action: The goal's action; empty for an event.
        nth: The number among equal ones, from 1.
        lasted: The execution time of a goal that has ended, in simulated seconds.
    """

    at: float
    goal: str
    event: str
    robot: str
    action: str
    nth: int
    lasted: float = 0.0

    @property
    def what(self) -> What:
        """The moment without its time."""
        return self[1:6]

    def anchor(self, after: float = 0.0) -> dict[str, Any]:
        """Return the anchor for it, in plain values; *after* is in simulated seconds."""
        spec: dict[str, Any] = {"goal": self.goal} if self.goal else {"event": self.event}
        spec |= {"robot": self.robot} if self.robot else {}
        spec |= {"action": self.action} if self.action else {}
        spec |= {"nth": self.nth} if self.nth > 1 else {}
        return spec | ({"after": after} if after else {})


@dataclass(frozen=True)
class Case:
    """The input of one run besides the controller.

    Attributes:
        definition: The world as a native file has it, without the schedule; None for the world of the check.
    """

    schedule: Schedule = ()
    definition: Mapping[str, Any] | None = None

    @cached_property
    def key(self) -> str:
        """SHA-256 of both, as 64 hex digits; equal cases have equal keys."""
        world = "" if self.definition is None else json.dumps(self.definition, sort_keys=True)
        schedule = ",".join(injection.key for injection in self.schedule)
        return hashlib.sha256(f"[{schedule}]{world}".encode()).hexdigest()

    def with_schedule(self, schedule: Schedule) -> Case:
        """Return the same world with another schedule."""
        return replace(self, schedule=schedule)


def changes_in(schedule: Iterable[Injection]) -> list[Injection]:
    """Return the changes of the world in a schedule."""
    return [injection for injection in schedule if injection.family == CHANGE]


def overlays_of(schedule: Iterable[Injection]) -> list[Overlay]:
    """Return the changes of a schedule as overlays of a world."""
    return [overlay_of(injection.spec[CHANGE], "the schedule") for injection in changes_in(schedule)]


def with_faults(world: World, schedule: Sequence[Injection]) -> World:
    """Return a world to whose faults those of a schedule are added."""
    faults = [FaultEntry.model_validate(dict(injection.spec)) for injection in schedule if injection.family == FAULT]
    return world.with_faults(faults) if faults else world
