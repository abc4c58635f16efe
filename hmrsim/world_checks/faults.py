"""The checks of faults: their settings, and whether their subjects exist."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import error_codes
from hmrsim.actions import registry as actions
from hmrsim.components import SensorSettings
from hmrsim.components import registry as components
from hmrsim.diagnostics import Finding, instead
from hmrsim.distributions import latest
from hmrsim.documents.valid_parts import valid_parts
from hmrsim.faults import SUBJECTS, registry
from hmrsim.protocol.goal import WORLD
from hmrsim.world.model import BUILT_IN_TYPES
from hmrsim.world_checks.robots import components_lost, valid_battery

if TYPE_CHECKING:
    from hmrsim.documents.valid_parts import Lost
    from hmrsim.events import EventPattern
    from hmrsim.faults import AnyFault, Occurrence
    from hmrsim.world.model import World


_NAMED: Final = tuple(subject for subject in SUBJECTS if subject != "lane")
"""The subjects of faults that have a name."""

_OF_COMPONENTS: Final = ("robot", "sensor", "cell", "action", "error_code")
"""The fields whose errors depend on the components of a robot."""


@dataclass(frozen=True)
class There:
    """The possible subjects of faults.

    Attributes:
        robots: The components of each robot, by its name.
        lanes: Its keys are the waypoints where each lane begins and ends, in each direction in which it can be driven.
        doors: The names of the doors.
        docks: Those of the docks.
        lifts: Those of the lifts.
        items: Those of the items.
        made: The base names of the items that orders will create.
        cells: How many cells the battery of a robot has, by its name; None if it has no battery.
    """

    robots: Mapping[str, Collection[str]]
    lanes: Mapping[tuple[str, str], object]
    doors: Collection[str]
    docks: Collection[str]
    lifts: Collection[str]
    items: Collection[str]
    cells: Mapping[str, int | None]
    made: Collection[str] = ()

    def named(self, field: str) -> Collection[str]:
        """Return the names of the subjects that a field of a fault can have."""
        names: Collection[str] = getattr(self, f"{field}s")
        return names

    def will_have(self, item: str) -> bool:
        """Return whether an order may create an item of this name."""
        kind, _, number = item.rpartition("_")
        return kind in self.made and number.isdecimal()


def check_faults(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of the faults of a world."""
    if not world.faults:
        return
    there = there_in(world)
    names: dict[str, int] = {}
    for i, fault in enumerate(world.faults):
        found, flawed = read_valid_fault(fault.type, fault.model_extra or {})
        if found is not None:
            kind, settings = found
            further = flaws(kind, settings, there, names=names)
            flawed += [flaw for flaw in further if not _may_be_lost(flaw, settings, world, lost)]
            names.setdefault(settings.name or "", i)
        for flaw in flawed:
            yield flaw.within("faults", i)


def read_fault(name: str, values: Mapping[str, Any]) -> tuple[AnyFault, Occurrence] | list[Finding]:
    """Return a kind of fault and its settings from plain values, or the errors."""
    found, flawed = read_valid_fault(name, values)
    return flawed if flawed or found is None else found


def read_valid_fault(name: str, values: Mapping[str, Any]) -> tuple[tuple[AnyFault, Occurrence] | None, list[Finding]]:
    """Return a kind of fault and the valid part of its settings, and the errors; None if no part can be read."""
    fault = registry().get(name)
    if fault is None:
        return None, [Finding(("type",), f"no fault type {name!r}{instead(name, registry())}", name)]
    valid = valid_parts(values, fault.settings)
    return None if valid.value is None else (fault, valid.value), [*valid.findings]


def flaws(
    fault: AnyFault, settings: Occurrence, there: There, *, now: float = 0.0, names: Collection[str] = ()
) -> Iterator[Finding]:
    """Yield the reasons why a fault can't be scheduled.

    It must begin, and end, later than *now*; *names* are the names that are taken.
    """
    yield from missing(fault, settings, there)
    if settings.name in names:
        yield Finding(("name",), f"there is a fault {settings.name!r} already; give another name", settings.name)
    for field in ("at", "until"):
        time = getattr(settings, field, None)
        if time is not None and latest(time) < now:
            yield Finding((field,), f"{latest(time):g} s is over; it is {now:g} s now", time)
    if settings.when is not None:
        for flaw in check_pattern(settings.when, there):
            yield flaw.within("when")


def missing(fault: AnyFault, settings: Occurrence, there: There) -> Iterator[Finding]:
    """Yield the errors of subjects and components that a fault needs and the world lacks."""
    # Not by `getattr`, which is slow for attributes that a model lacks.
    said = settings.__dict__
    for field in _NAMED:
        name = said.get(field)
        if name is None or name in (known := there.named(field)):
            continue
        if not (field == "item" and there.will_have(name)):
            yield Finding((field,), f"no {field} {name!r}{instead(name, known)}", name)
    robot: str = said.get("robot", "")
    if robot in there.robots:
        yield from _check_component(fault, settings, there.robots[robot])
        yield from _check_cell(settings, there.cells.get(robot))
        yield from _check_action(settings, there.robots[robot])
    lane = said.get("lane")
    if lane is not None and lane not in there.lanes and lane[::-1] not in there.lanes:
        known = [f"{a}-{b}" for a, b in there.lanes]
        yield Finding(("lane",), f"no lane {'-'.join(lane)!r}{instead('-'.join(lane), known)}", list(lane))


def check_pattern(pattern: EventPattern, there: There) -> Iterator[Finding]:
    """Yield the reasons why no event of this world can match; orders create items, so item names are not checked."""
    flawed = [*pattern.flaws()]
    yield from flawed
    known: Mapping[str, tuple[str, Collection[str]]] = {
        **{field: (field, there.named(field)) for field in _NAMED if field != "item"},
        "action": ("action", actions()),
        "fault": ("fault type", registry()),
    }
    told = {flaw.path for flaw in flawed}
    asked: list[tuple[tuple[str, ...], Any]] = [(("robot",), pattern.robot), (("action",), pattern.action)]
    asked += [(("where", field), value) for field, value in pattern.where.items()]
    for path, name in asked:
        noun, names = known.get(path[-1], ("", ()))
        if isinstance(name, str) and noun and path not in told and name not in names and name != WORLD:
            yield Finding(path, f"no {noun} {name!r}{instead(name, names)}", name)
    if pattern.robot is not None and pattern.robot in there.robots:
        yield from _check_served(pattern.robot, pattern.action or "", there.robots[pattern.robot])


def _check_served(robot: str, action: str, carried: Collection[str]) -> Iterator[Finding]:
    """Yield an error if a robot lacks the component for an action."""
    known = actions().get(action)
    if known is not None and known.component is not None and known.component not in carried:
        yield Finding(("action",), f"{robot} does not serve {action}: it has no {known.component}", action)


def _check_component(fault: AnyFault, settings: Occurrence, carried: Collection[str]) -> Iterator[Finding]:
    robot, sensor, known = settings.subject, settings.__dict__.get("sensor"), components()
    if any(name not in known for name in carried):
        # Of that there is an error; it may be the one that is looked for.
        return
    if fault.component is not None and fault.component not in carried:
        yield Finding(("robot",), f"{robot} has no {fault.component}{instead(fault.component, carried)}", robot)
    sensors = [name for name in carried if issubclass(known[name].settings, SensorSettings)]
    if sensor is not None and sensor not in sensors:
        yield Finding(("sensor",), f"{robot} has no sensor {sensor!r}{instead(sensor, sensors)}", sensor)


def _check_cell(settings: Occurrence, cells: int | None) -> Iterator[Finding]:
    cell = settings.__dict__.get("cell")
    if cell is not None and cells is not None and cell >= cells:
        yield Finding(("cell",), f"{settings.subject} has no cell {cell}; its battery has {cells}, from 0 on", cell)


def _check_action(settings: Occurrence, carried: Collection[str]) -> Iterator[Finding]:
    """Yield the errors of the action whose goals a fault hits, and of their error code."""
    name, code = settings.__dict__.get("action"), settings.__dict__.get("error_code")
    if name is None:
        if code is not None:
            text = f"each action has its own codes; give action for {code}, or leave error_code out"
            yield Finding(("error_code",), text, code)
        return
    served = [each for each, action in actions().items() if not action.of_world]
    if name not in served:
        yield Finding(("action",), f"no action {name!r}{instead(name, served)}", name)
        return
    yield from _check_served(settings.subject, name, carried)
    codes = error_codes(actions()[name])
    if code is not None and code not in codes:
        known = ", ".join(f"{number} {words}" for number, words in codes.items())
        yield Finding(("error_code",), f"{name} has no error code {code}; there are {known}", code)


def _may_be_lost(flaw: Finding, settings: Occurrence, world: World, lost: Lost) -> bool:
    """Return whether a flaw may follow from another error: something of this name, or a component, may be missing."""
    if flaw.path == ("lane",):
        return lost.touches("lanes") or any(lost.has(name, "waypoints") for name in getattr(settings, "lane", ()))
    field = flaw.path[-1]
    robot = settings.subject if settings.when is None or flaw.path[0] != "when" else settings.when.robot or ""
    if field in _OF_COMPONENTS and robot in world.robots:
        return components_lost(world.robots[robot], robot, lost)
    return field in _NAMED and lost.has(str(flaw.value), f"{field}s", *(["demand"] if field == "item" else []))


def there_in(world: World) -> There:
    """Return the possible subjects of faults, and of the events that trigger them."""
    types = {**BUILT_IN_TYPES, **world.robot_types}
    lanes = {(lane.from_, lane.to) for lane in world.lanes}
    robots = {
        # The components of a robot of an unknown type are not known: it is taken to have all of them.
        name: world.robot_type(robot).components if robot.type in types else components()
        for name, robot in world.robots.items()
    }
    batteries = {name: valid_battery(carried.get("battery")) for name, carried in robots.items()}
    return There(
        robots=robots,
        lanes=dict.fromkeys(sorted(lanes | {(b, a) for a, b in lanes})),
        doors=world.doors,
        docks=world.docks,
        lifts=world.lifts,
        items=world.items,
        cells={name: battery.cells for name, battery in batteries.items() if battery},
        made=[demand.item or demand.name for demand in world.demand],
    )
