"""Writing worlds as readable native files: one entity per line, without default values.

Reading such a file gives the same world again, with the same hash.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any, Final

from hmrsim.world.model import PlainLanes, World

_WIDTH: Final = 110
_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*( [A-Za-z0-9_./-]+)*")
_RESERVED: Final = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}
"""Words with a special meaning in YAML 1.2 or earlier versions."""

_MINUS_ZERO: Final = "-0.0"

_HEAD: Final = ("name", "units", "bounds", "seed")


def native_data(world: World) -> dict[str, Any]:
    """Return a world as the plain values of a native file."""
    dumped = world.model_dump(mode="json", by_alias=True, exclude_defaults=True, exclude={"lanes"})
    data: dict[str, Any] = {"name": world.name, "units": world.units, **dumped}
    for name, robot in world.robots.items():
        # A setting of a robot's base overrides its type's, even with the default value.
        if base := robot.base.model_dump(mode="json", exclude_unset=True):
            data["robots"][name]["base"] = base
    for key, field in (("robots", "yaw"), ("items", "weight")):
        for name, thing in getattr(world, key).items():
            # It equals the default 0.0 and was left out, but the hash of the world differs.
            if str(getattr(thing, field)) == _MINUS_ZERO:
                data[key][name][field] = -0.0
    if world.lanes:
        data["lanes"] = _lanes(world)
        data = {key: data[key] for key in World.model_fields if key in data}
    return {key: value if key in ("faults", "traffic") else _tidy(value) for key, value in _ordered(data).items()}


def _lanes(world: World) -> list[Any]:
    """Return the lanes in their shortest form: pairs of waypoints where a lane has no other settings."""
    if isinstance(world.lanes, PlainLanes):
        return [[*pair] for pair in world.lanes.pairs]
    lanes = world.model_dump(mode="json", by_alias=True, exclude_defaults=True, include={"lanes"})["lanes"]
    return [[*lane.values()] if lane.keys() == {"from", "to"} else lane for lane in lanes]


def to_yaml(world: World, *, schema: str | None = None) -> str:
    """Return a world as YAML; *schema* is the path of the schema for editors, relative to the file."""
    lines = [f"# yaml-language-server: $schema={schema}"] if schema else []
    for key, value in native_data(world).items():
        if key in _HEAD or not isinstance(value, (dict, list)):
            lines.append(f"{key}: {_flow(value)}")
        else:
            lines += ["", *block(key, value)]
    return "\n".join(lines) + "\n"


def block(key: str, value: Any, pad: str = "") -> Iterator[str]:
    """Yield the lines of a key and its plain value as readable YAML, with each entry on one line if it fits."""
    if not isinstance(value, (dict, list)) or not value:
        yield f"{pad}{key}: {_flow(value)}"
        return
    yield f"{pad}{key}:"
    yield from _block(value, f"{pad}  ")


def to_json(world: World) -> str:
    """Return a world as JSON."""
    sections = (f"  {json.dumps(key)}: {_section(value)}" for key, value in native_data(world).items())
    return "{\n" + ",\n".join(sections) + "\n}\n"


def _ordered(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data with the keys that describe the whole world first."""
    return {key: data[key] for key in (*_HEAD, *data) if key in data}


def _tidy(value: Any) -> Any:
    """Return a value with whole floats as integers, except in the settings of components."""
    if isinstance(value, dict):
        return {key: part if key == "components" else _tidy(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_tidy(part) for part in value]
    whole = isinstance(value, float) and value.is_integer() and str(value) != _MINUS_ZERO
    return int(value) if whole else value


def _section(value: Any) -> str:
    if isinstance(value, dict) and value:
        return "{\n" + ",\n".join(f"    {json.dumps(key)}: {json.dumps(part)}" for key, part in value.items()) + "\n  }"
    if isinstance(value, list) and any(isinstance(part, (dict, list)) for part in value):
        return "[\n" + ",\n".join(f"    {json.dumps(part)}" for part in value) + "\n  ]"
    return json.dumps(value)


def _block(value: dict[str, Any] | list[Any], pad: str) -> Iterator[str]:
    """Yield the lines of the values of a mapping or list."""
    for head, part in _entries(value, pad):
        text = f"{head} {_flow(part)}"
        if len(text) <= _WIDTH or not isinstance(part, (dict, list)):
            yield text
        elif _is_outline(part):
            yield from _wrapped(text, pad + "   ")
        else:
            yield head
            yield from _block(part, pad + "  ")


def _entries(value: dict[str, Any] | list[Any], pad: str) -> Iterator[tuple[str, Any]]:
    """Yield the text before each value, and the value."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield f"{pad}{_scalar(key)}:", part
        return
    for part in value:
        if isinstance(part, dict) and len(part) == 1:
            yield from _entries(part, f"{pad}- ")
        else:
            yield f"{pad}-", part


def _is_outline(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(part, list) for part in value)


def _wrapped(text: str, pad: str) -> Iterator[str]:
    """Yield the text of a list of points, wrapped to lines of the maximum width."""
    line, *points = text.split(", [")
    for point in points:
        if len(line) + len(point) + len(", [,") > _WIDTH:
            yield f"{line},"
            line = f"{pad}[{point}"
        else:
            line = f"{line}, [{point}"
    yield line


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_scalar(key)}: {_flow(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_flow(part) for part in value) + "]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    """Return a scalar in YAML: text that needs no quotes as it is, and everything else as JSON."""
    if not isinstance(value, str):
        return json.dumps(value)
    if _PLAIN.fullmatch(value) and value.lower() not in _RESERVED:
        return value
    text = json.dumps(value, ensure_ascii=False)
    return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in text)
