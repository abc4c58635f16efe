"""The faults that can happen in a world: for each kind and each subject, what a file would say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import error_codes
from hmrsim.actions import registry as actions
from hmrsim.fault_search.space.energy import battery_of, has_charger
from hmrsim.faults import SUBJECTS, Spell
from hmrsim.faults import registry as faults
from hmrsim.geometry import METER
from hmrsim.world_checks.faults import read_fault

if TYPE_CHECKING:
    from hmrsim.components.battery import BatterySettings
    from hmrsim.fault_search.schedules.moment import Moment
    from hmrsim.faults import AnyFault
    from hmrsim.world.model import World

_DROP: Final = "battery_drop"
_ABOVE: Final = 1.5
"""How much more than what is low a battery has that falls to a little above that."""


def faults_of(
    world: World, moments: Sequence[Moment], durations: Sequence[float], needs: Mapping[str, float]
) -> Iterator[dict[str, Any]]:
    """Yield the faults that can happen in a world, without the time at which they begin.

    Args:
        world: The world.
        moments: What happens in a run without faults: which robots are asked for what.
        durations: Seconds that those last that last.
        needs: The share of its battery's capacity that each robot needs at the start.
    """
    asked: dict[str, dict[str, None]] = {}
    for moment in moments:
        if moment.goal:
            asked.setdefault(moment.robot, {})[moment.action] = None
    for kind in faults().values():
        for subject in _subjects_of(kind, world, asked):
            for said in _variants(kind, subject, world, asked, needs):
                for lasting in _lasting(kind, said, durations):
                    if isinstance(read_fault(kind.name, {k: v for k, v in lasting.items() if k != "type"}), tuple):
                        yield lasting


def _subjects_of(kind: AnyFault, world: World, asked: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield what a kind of fault can happen to, as the field that names it."""
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
    """Return whether a robot with these components can be hit by a kind of fault."""
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
    """Yield what a fault of a kind says of a subject: each action that it is asked for, and how strong it is."""
    fields = kind.settings.model_fields
    # What a kind's example sets makes it do something; with its defaults alone it may do nothing.
    strengths = {name for name, field in fields.items() if field.is_required() or name in kind.example} - {*subject}
    said: dict[str, Any] = {"type": kind.name, **subject}
    for name in sorted(strengths):
        said[name] = _strength(kind, name, world)
    if "count" in fields:
        said["count"] = 1
    if "action" not in fields:
        battery = battery_of(world, subject["robot"]) if kind.name == _DROP else None
        yield from (said,) if battery is None else _falls(said, battery, world, needs)
        return
    for action in asked.get(subject.get("robot", ""), {}):
        if actions()[action].of_world:
            continue
        yield {**said, "action": action}
        if "count" in fields:
            yield {**said, "action": action, "count": 3}
        if "error_code" in fields:
            yield from ({**said, "action": action, "error_code": code} for code in error_codes(actions()[action]))


def _strength(kind: AnyFault, name: str, world: World) -> Any:
    """Return the value of a field: that of the kind's example, which gives lengths in meters."""
    value, extra = kind.example.get(name), kind.settings.model_fields[name].json_schema_extra
    is_length = isinstance(extra, dict) and extra.get("unit") == "m"
    return value * METER[world.units] if is_length and isinstance(value, (int, float)) else value


def _falls(
    said: Mapping[str, Any], battery: BatterySettings, world: World, needs: Mapping[str, float]
) -> Iterator[dict[str, Any]]:
    """Yield the fall of a battery to each share: to what is low, and to enough to set out but not to come far.

    Not to what is critical: then a robot may have too little to reach a charger, whatever its controller does. Where
    there is no charger, it keeps what it needs for the whole mission.
    """
    least = 0.0 if has_charger(world) else needs.get(said["robot"], 0.0)
    for share in dict.fromkeys(max(each, least) for each in (battery.low, battery.low * _ABOVE)):
        if 0.0 < share < 1.0:
            yield {**said, "share": round(share, 6)}


def _lasting(kind: AnyFault, said: dict[str, Any], durations: Sequence[float]) -> Iterator[dict[str, Any]]:
    """Yield a fault with each duration, if it lasts; one that counts goals ends by itself."""
    if not issubclass(kind.settings, Spell) or "count" in said:
        yield said
        return
    yield from ({**said, "duration": seconds} for seconds in durations)
