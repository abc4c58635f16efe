"""Kinds of injections: the faults, changes and disturbances that can be tried in a world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.actions import error_codes
from hmrsim.actions import registry as actions
from hmrsim.components.battery import BatterySettings
from hmrsim.faults import SUBJECTS, Spell
from hmrsim.faults import registry as faults
from hmrsim.geometry import METER
from hmrsim.world_checks.faults import read_fault

if TYPE_CHECKING:
    from hmrsim.fault_search.schedule import Moment
    from hmrsim.faults import AnyFault
    from hmrsim.world.model import World

_DROP: Final = "battery_drop"
_ABOVE: Final = 1.5
"""The charge just above low, as a multiple of the low charge."""


def faults_of(
    world: World, moments: Sequence[Moment], durations: Sequence[float], needs: Mapping[str, float]
) -> Iterator[dict[str, Any]]:
    """Yield the faults that can happen in a world, without the time at which they begin.

    Args:
        world: The world.
        moments: The moments of a run without faults, which name the robots and their actions.
        durations: The durations in seconds of faults that last.
        needs: The share of its battery's capacity that each robot needs at the start.
    """
    asked: dict[str, dict[str, None]] = {}
    for moment in moments:
        if moment.goal:
            asked.setdefault(moment.robot, {})[moment.action] = None
    for kind in faults().values():
        for subject in _subjects_of(kind, world, asked):
            for spec in _variants(kind, subject, world, asked, needs):
                for lasting in _lasting(kind, spec, durations):
                    if isinstance(read_fault(kind.name, {k: v for k, v in lasting.items() if k != "type"}), tuple):
                        yield lasting


def _subjects_of(kind: AnyFault, world: World, asked: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the subjects that a kind of fault can affect, each as the field that names it."""
    field = next((name for name in SUBJECTS if name in kind.settings.model_fields), "")
    if field == "robot":
        for name in world.robots:
            carried = world.robot_type(world.robots[name]).components
            if name in asked and (kind.component is None or kind.component in carried) and _notices(kind, carried):
                yield {"robot": name}
    elif field == "lane":
        yield from ({"lane": [lane.from_, lane.to]} for lane in world.lanes)
    elif field:
        yield from ({field: name} for name in getattr(world, f"{field}s"))


def _notices(kind: AnyFault, carried: Mapping[str, Any]) -> bool:
    """Return whether a kind of fault has an effect on a robot with these components."""
    if kind.name.startswith("battery"):
        return "battery" in carried
    return kind.name != "sensor_blind" or bool({"camera", "proximity"} & {*carried})


def _variants(
    kind: AnyFault,
    subject: dict[str, Any],
    world: World,
    asked: Mapping[str, Mapping[str, None]],
    needs: Mapping[str, float],
) -> Iterator[dict[str, Any]]:
    """Yield the faults of a kind for a subject: one for each of its actions and each strength."""
    fields = kind.settings.model_fields
    # The values in the example of a kind have an effect; the defaults alone may have none.
    strengths = {name for name, field in fields.items() if field.is_required() or name in kind.example} - {*subject}
    spec: dict[str, Any] = {"type": kind.name, **subject}
    for name in sorted(strengths):
        spec[name] = _strength(kind, name, world)
    if "count" in fields:
        spec["count"] = 1
    if "action" not in fields:
        battery = battery_of(world, subject["robot"]) if kind.name == _DROP else None
        yield from (spec,) if battery is None else _falls(spec, battery, world, needs)
        return
    for action in asked.get(subject.get("robot", ""), {}):
        if actions()[action].of_world:
            continue
        yield {**spec, "action": action}
        if "count" in fields:
            yield {**spec, "action": action, "count": 3}
        if "error_code" in fields:
            yield from ({**spec, "action": action, "error_code": code} for code in error_codes(actions()[action]))


def _strength(kind: AnyFault, name: str, world: World) -> Any:
    """Return the value of a field: that of the kind's example, which gives lengths in meters."""
    value, extra = kind.example.get(name), kind.settings.model_fields[name].json_schema_extra
    is_length = isinstance(extra, dict) and extra.get("unit") == "m"
    return value * METER[world.units] if is_length and isinstance(value, (int, float)) else value


def _falls(
    spec: Mapping[str, Any], battery: BatterySettings, world: World, needs: Mapping[str, float]
) -> Iterator[dict[str, Any]]:
    """Yield drops of a battery to each share: to the low charge, and to enough to set out but not to get far.

    The battery never drops to the critical charge, with which a robot may not reach a charger, whatever its controller
    does. Without a charger, it keeps enough for the whole mission.
    """
    least = 0.0 if has_charger(world) else needs.get(spec["robot"], 0.0)
    for share in dict.fromkeys(max(each, least) for each in (battery.low, battery.low * _ABOVE)):
        if 0.0 < share < 1.0:
            yield {**spec, "share": round(share, 6)}


def _lasting(kind: AnyFault, spec: dict[str, Any], durations: Sequence[float]) -> Iterator[dict[str, Any]]:
    """Yield a fault with each duration, if it lasts; one that counts goals ends by itself."""
    if not issubclass(kind.settings, Spell) or "count" in spec:
        yield spec
        return
    yield from ({**spec, "duration": seconds} for seconds in durations)


_SLOW: Final = 0.3
"""The speed of a slow robot, as a share."""
_QUICK: Final = 1e4
"""The speed factor with which a robot's goals end almost at once."""
_SMALL: Final = 0.5
"""The capacity of a small battery, as a share."""
_HARDLY: Final = 0.95
"""A change to this share or more is not worth a run."""
_BURST: Final = 0.01
"""Seconds between the orders of a burst."""
_INSTANT: Final = 1e-9
"""Seconds between orders that arrive at practically the same instant."""

CHANGES: Final[Mapping[str, str]] = {
    "speed": "robots that are slow, or so quick that their goals end almost at once",
    "capacity": "batteries with half of their capacity, or as much more as the mission needs",
    "arrives": "orders that come in a burst",
    "absent": "no orders at all",
}
"""The kinds of changes, each with its description."""


def changes_of(world: World, robots: Sequence[str], needs: Mapping[str, float]) -> Iterator[dict[str, Any]]:
    """Yield the changes that can be tried, in plain values, for the robots that the controller uses.

    *needs* has the share of its battery's capacity that each robot needs at the start.
    """
    for name in robots:
        speed, battery = world.speed(world.robot_type(world.robots[name]).base), battery_of(world, name)
        # A slow robot uses its battery for longer, at most by the factor by which it is slower.
        least = 0.0 if battery is None else needs.get(name, 0.0) / (share_at_start(battery) or 1.0)
        slow = max(_SLOW, least)
        for factor in (slow, _QUICK) if slow < _HARDLY else (_QUICK,):
            yield _change(f"robots.{_quoted(name)}.base.speed", _plain(speed * factor))
        if battery is not None and max(_SMALL, least) < _HARDLY:
            yield _small_battery(name, battery, max(_SMALL, least))
    for i, demand in enumerate(world.demand):
        path = f"demand.{i if demand.name.isdecimal() else _quoted(demand.name)}"
        yield _change(f"{path}.arrives", _BURST)
        if demand.count is not None and demand.count > 1:
            yield {"change": {f"{path}.arrives": _INSTANT, f"{path}.first": 0.0}}
        yield {"change": {f"~{path}": None}}


def _small_battery(name: str, battery: BatterySettings, factor: float) -> dict[str, Any]:
    path = f"robots.{_quoted(name)}.components.battery"
    change: dict[str, Any] = {f"{path}.capacity": _plain(battery.capacity * factor)}
    if battery.initial_charge is not None:
        change[f"{path}.initial_charge"] = min(change[f"{path}.capacity"], _plain(battery.initial_charge * factor))
    return {"change": change}


def _plain(number: float) -> float:
    """Return a number with few digits."""
    return float(f"{number:.4g}")


def _change(path: str, value: Any) -> dict[str, Any]:
    return {"change": {path: value}}


def _quoted(name: str) -> str:
    return f'"{name}"' if "." in name else name


_LASTING: Final = ("controller_stalled",)
_RESTART: Final = 5.0
"""Simulated seconds until a killed controller is restarted."""

DISTURBANCES: Final = (
    "controller_stalled",
    "controller_killed",
    "reply_lost",
    "request_repeated",
    "second_controller",
    "simulation_reset",
)
"""The kinds of disturbances, the mildest first."""


def disturbances_of(durations: Sequence[float]) -> Iterator[dict[str, Any]]:
    """Yield the disturbances that can be tried, without the time at which they begin.

    Those that last do so for each of *durations*, in simulated seconds.
    """
    for kind in DISTURBANCES:
        spec: dict[str, Any] = {"disturbance": kind}
        if kind in _LASTING:
            yield from ({**spec, "duration": seconds} for seconds in durations)
        elif kind == "controller_killed":
            yield {**spec, "restart_after": _RESTART}
        else:
            yield spec


_RESERVE: Final = 1.5
"""The energy that a robot keeps, relative to its use without faults: waits and detours take more."""


class Draw(NamedTuple):
    """The battery draw of a robot, in shares of the capacity.

    Attributes:
        whole: The most from one charge to the next.
        goal: The most while one goal is executed.
    """

    whole: float = 0.0
    goal: float = 0.0


def battery_of(world: World, robot: str) -> BatterySettings | None:
    """Return the settings of a robot's battery; None if it has none."""
    settings = world.robot_type(world.robots[robot]).components.get("battery")
    return None if settings is None else BatterySettings.model_validate(settings)


def share_at_start(battery: BatterySettings) -> float:
    """Return the share of its capacity that a battery has at the start."""
    return 1.0 if battery.initial_charge is None else battery.initial_charge / battery.capacity


def has_charger(world: World) -> bool:
    """Return whether batteries can be charged in a world."""
    return any(dock.charges for dock in world.docks.values())


def needs_of(world: World, draws: Mapping[str, Draw]) -> dict[str, float]:
    """Return the share of its capacity that each robot with a battery needs at the start.

    With less, no controller could do the mission. If there is a charger, a controller can send the robot there between
    any two goals: a full battery has to last for the longest goal and the way back, and a low one for the longest goal.
    Without a charger, it has to last for the whole mission. *draws* are those of the run without faults.
    """
    needs = {}
    for name in world.robots:
        battery = battery_of(world, name)
        draw = draws.get(name)
        if battery is not None and draw is not None:
            low = draw.goal / battery.low if battery.low else 0.0
            used = max(2 * draw.goal, low) if has_charger(world) else draw.whole
            needs[name] = battery.stops_below + used * _RESERVE
    return needs
