"""Pydantic's errors as messages with the value and the expected one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeGuard, get_args

from pydantic import BaseModel

from hmrsim.diagnostics import MAX_FINDINGS, Finding, Path, dotted, instead, shown
from hmrsim.distributions import Distribution
from hmrsim.world.model import (
    Base,
    Demand,
    Dock,
    Door,
    FaultEntry,
    Item,
    Lane,
    Lift,
    Place,
    RobotSpec,
    RobotType,
    Solid,
    Waypoint,
    World,
)

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

_PARTS: dict[tuple[str, ...], type[BaseModel]] = {
    (): World,
    ("lanes", "*"): Lane,
    ("walls", "*"): Solid,
    ("waypoints", "*"): Waypoint,
    ("places", "*"): Place,
    ("docks", "*"): Dock,
    ("doors", "*"): Door,
    ("lifts", "*"): Lift,
    ("items", "*"): Item,
    ("robot_types", "*"): RobotType,
    ("robot_types", "*", "base"): Base,
    ("robots", "*"): RobotSpec,
    ("robots", "*", "base"): Base,
    ("faults", "*"): FaultEntry,
    ("demand", "*"): Demand,
}

_DISTRIBUTION = "distribution"
"""What pydantic's paths have where a value is validated as a distribution."""

_WANTED = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "string_type": "text",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "tuple_type": "a list",
    "list_type": "a list",
    "is_instance_of": "a path",
    "finite_number": "a finite number",
}

_TINY = 1e-9
"""The least value of what has to be greater than 0: who gives a negative one need not hear of it."""

_LIMITS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}

_PHRASES: dict[str, Callable[[Mapping[str, Any], object], str]] = {
    "literal_error": lambda context, value: f"expected {context['expected']}, got {shown(value)}",
    "too_short": lambda context, value: f"expected at least {context['min_length']} values, got {_length(value)}",
    "too_long": lambda context, value: f"expected {context['max_length']} values, got {_length(value)}",
    "string_too_short": lambda _context, _value: "is empty; give it a name",
    "string_too_long": lambda context, _value: f"is longer than {context['max_length']} characters",
    "value_error": lambda context, _value: str(context["error"]),
}


Parts = Mapping[tuple[str, ...], type[BaseModel]]
"""The models of the parts of a file by their paths, in which ``*`` is any key or index."""


def explain(
    error: ValidationError, data: object, model: type[BaseModel] | None = None, parts: Parts = _PARTS
) -> list[Finding]:
    """Return the errors of *data*, one finding a field; of hopeless data the first.

    *model* is what it was validated as, if that is neither a world nor another file with *parts*.
    """
    found: dict[Path, Finding] = {}
    too_short: set[Path] = set()
    for details in error.errors(include_url=False, include_input=False)[:MAX_FINDINGS]:
        path, value = _follow(data, details["loc"], missing=details["type"] == "missing")
        if path not in found:
            found[path] = Finding(path, _message(details, path, value, (model, parts)), value)
        if details["type"] in ("too_short", "too_long"):
            too_short.add(_follow(data, details["loc"], missing=False)[0])
    # Pydantic counts the parts that are left after the bad ones were taken out, which says nothing new.
    deeper = {path[:i] for path in found for i in range(len(path))}
    return [finding for path, finding in found.items() if path not in too_short & deeper]


def _follow(data: object, loc: tuple[str | int, ...], *, missing: bool) -> tuple[Path, object]:
    """Return the path in the file and the value there; pydantic puts the names of alternatives between."""
    path: list[str | int] = []
    value = data
    for i, step in enumerate(loc):
        if (isinstance(value, dict) and step in value) or (
            isinstance(value, (list, tuple)) and isinstance(step, int) and step < len(value)
        ):
            path.append(step)
            value = value[step]  # type: ignore[index]
        elif isinstance(value, (list, tuple)) and step in ("from", "to") and len(value) == 2:  # noqa: PLR2004
            path.append(step)
            value = value[step == "to"]
        elif missing and i == len(loc) - 1 and isinstance(value, dict):
            path.append(step)
            value = None
    return tuple(path), value


def _message(details: ErrorDetails, path: Path, value: object, models: tuple[type[BaseModel] | None, Parts]) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind == "extra_forbidden":
        loc = details["loc"]
        known = _keys_of_distribution(loc) if _DISTRIBUTION in loc else _known_keys(path[:-1], *models)
        text = f"unknown key {path[-1]!r}{_split(str(path[-1]), value) or instead(str(path[-1]), known)}"
    elif kind == "missing" and isinstance(value, (list, tuple)):
        text = f"expected {_count(details, path)}, got {len(value)}"
    elif kind == "missing":
        text = f"is missing{_example(path)}"
    elif kind in _LIMITS:
        text = f"must be {_limit(kind, context, value)}, got {shown(value)}"
    elif kind in _WANTED:
        text = f"expected {_wanted(kind, path, value)}"
    elif kind in _PHRASES:
        text = _PHRASES[kind](context, value)
    elif kind == "string_pattern_mismatch":
        wrong = path[-1] if "[key]" in details["loc"] else value
        text = f"{shown(wrong)} is not a ROS name; use a letter, then letters, digits and _"
        if str(wrong).startswith("-"):
            text += f"; in an overlay, ~{dotted((*path[:-1], str(wrong)[1:]))} takes it away"
    else:
        text = f"{details['msg'][:1].lower()}{details['msg'][1:]}, got {shown(value)}"
    return text


def _split(key: str, value: object) -> str:
    """Return what to do about a key that is the rest of a text with a comma; nothing for other keys."""
    if value is None and any(key.count(end) > key.count(begin) for begin, end in ("()", "[]")):
        return "; within { } a comma begins another key; put the text before it, with all of this, in quotes"
    return ""


def _limit(kind: str, context: Mapping[str, Any], value: object) -> str:
    words, key = _LIMITS[kind]
    bound = context[key]
    if key == "ge" and 0 < bound <= _TINY and isinstance(value, (int, float)) and value <= 0:
        return "greater than 0"
    return f"{words} {bound:g}"


def _wanted(kind: str, path: Path, value: object) -> str:
    if kind in ("tuple_type", "string_type") and path and path[-1] == "at":
        wanted = "[x, y]" if path[0] == "places" else "[x, y] or a name"
        return f"{wanted}, got {shown(value)}"
    quotes = "; put it in quotes" if kind == "string_type" and isinstance(value, (int, float)) else ""
    return f"{_WANTED[kind]}, got {shown(value)}{quotes}"


def _count(details: ErrorDetails, path: Path) -> str:
    if path == ("bounds",):
        return "[least x, least y, greatest x, greatest y]"
    return "[x, y]" if details["loc"][-1] in (0, 1) else "more values"


def _length(value: object) -> object:
    return len(value) if isinstance(value, (list, tuple, dict, str)) else shown(value)


def _example(path: Path) -> str:
    if path[-1] == "at":
        return "; expected [x, y] or a name" if path[0] in ("items", "robots", "docks") else "; expected [x, y]"
    return "; expected the name of a waypoint" if path[0] == "lanes" else ""


def _keys_of_distribution(loc: tuple[str | int, ...]) -> Iterable[str]:
    *below, _ = loc[loc.index(_DISTRIBUTION) + 1 :]
    kind: Any = Distribution.model_fields[str(below[0])].annotation if below else Distribution
    return [*(get_args(kind) or (kind,))[0].model_fields]


def _fits(pattern: str, step: str | int) -> bool:
    return pattern in {"*", step}


def _is_model(part: object) -> TypeGuard[type[BaseModel]]:
    return isinstance(part, type) and issubclass(part, BaseModel)


def _known_keys(path: Path, model: type[BaseModel] | None, parts: Parts) -> Iterable[str]:
    if model is None:
        fits = (part for part in parts if len(part) == len(path) and all(map(_fits, part, path)))
        model = parts.get(min(fits, key=lambda part: part.count("*"), default=("",)))
    else:
        for step in path:
            # A part of a component's settings may be a model of its own.
            part = model.model_fields[str(step)].annotation
            found = next((each for each in (part, *get_args(part)) if _is_model(each)), None)
            if found is None:
                return ()
            model = found
    if model is None:
        return ()
    return [field.alias or name for name, field in model.model_fields.items()]
