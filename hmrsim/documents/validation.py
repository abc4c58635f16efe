"""Pydantic's errors as findings: messages with the value, the expected one and a suggestion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, TypeGuard, Union, get_args, get_origin

from pydantic import BaseModel, Tag

from hmrsim.diagnostics import MAX_FINDINGS, Finding, Path, dotted, instead, shown

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

_EXPECTED = {
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
"""The minimum of values that must be positive; messages call it "greater than 0" instead."""

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


def explain(error: ValidationError, data: object, model: type[BaseModel]) -> list[Finding]:
    """Return the errors of *data*, one finding per field and at most `MAX_FINDINGS`.

    *model* provides the known keys, for suggestions about unknown ones.
    """
    findings: dict[Path, Finding] = {}
    for details in error.errors(include_url=False, include_input=False)[:MAX_FINDINGS]:
        path, value = _follow(data, details["loc"], missing=details["type"] == "missing")
        if path not in findings:
            findings[path] = Finding(path, _message(details, path, value, model), value)
    # Pydantic counts the entries of a list without the invalid ones, and tries other types for a mapping with errors.
    parents = {path[:i] for path in findings for i in range(len(path))}
    return [finding for path, finding in findings.items() if path not in parents]


def _follow(data: object, loc: tuple[str | int, ...], *, missing: bool) -> tuple[Path, object]:
    """Return the path in the file and the value there, without pydantic's names of alternatives."""
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


def _message(details: ErrorDetails, path: Path, value: object, model: type[BaseModel]) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind == "extra_forbidden":
        known = _known_keys(details["loc"][:-1], model)
        text = f"unknown key {path[-1]!r}{_split(str(path[-1]), value) or instead(str(path[-1]), known)}"
    elif kind == "missing" and isinstance(value, (list, tuple)):
        text = f"expected {_count(details, path)}, got {len(value)}"
    elif kind == "missing":
        text = f"is missing{_example(path)}"
    elif kind in _LIMITS:
        text = f"must be {_limit(kind, context, value)}, got {shown(value)}"
    elif kind in _EXPECTED:
        text = f"expected {_expected(kind, path, value)}"
    elif kind in _PHRASES:
        text = _PHRASES[kind](context, value)
    elif kind == "string_pattern_mismatch":
        name = path[-1] if "[key]" in details["loc"] else value
        text = f"{shown(name)} is not a ROS name; use a letter, then letters, digits and _"
        if str(name).startswith("-"):
            text += f"; in an overlay, ~{dotted((*path[:-1], str(name)[1:]))} takes it away"
    else:
        text = f"{details['msg'][:1].lower()}{details['msg'][1:]}, got {shown(value)}"
    return text


def _split(key: str, value: object) -> str:
    """Return the remedy for a key that is the rest of a text with a comma; empty for other keys."""
    if value is None and any(key.count(end) > key.count(begin) for begin, end in ("()", "[]")):
        return "; within { } a comma begins another key; put the text before it, with all of this, in quotes"
    return ""


def _limit(kind: str, context: Mapping[str, Any], value: object) -> str:
    words, key = _LIMITS[kind]
    bound = context[key]
    if key == "ge" and 0 < bound <= _TINY and isinstance(value, (int, float)) and value <= 0:
        return "greater than 0"
    return f"{words} {bound:g}"


def _expected(kind: str, path: Path, value: object) -> str:
    if kind in ("tuple_type", "string_type") and path and path[-1] == "at":
        expected = "[x, y]" if path[0] == "places" else "[x, y] or a name"
        return f"{expected}, got {shown(value)}"
    quotes = "; put it in quotes" if kind == "string_type" and isinstance(value, (int, float)) else ""
    return f"{_EXPECTED[kind]}, got {shown(value)}{quotes}"


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


def _known_keys(loc: tuple[str | int, ...], model: type[BaseModel]) -> Iterable[str]:
    """Return the keys that the mapping at pydantic's path of an error may have."""
    kinds: list[Any] = [model]
    for step in loc:
        options = [option for kind in kinds for option in _alternatives(kind)]
        tagged = [kind for kind, tag in options if tag == step]
        kinds = tagged or [inner for kind, _ in options for inner in _below(kind, step)]
    found = next((kind for each in kinds for kind, _ in _alternatives(each) if _is_model(kind)), None)
    return [] if found is None else [field.alias or name for name, field in found.model_fields.items()]


def _alternatives(kind: Any, tag: str = "") -> Iterator[tuple[Any, str]]:
    """Yield the types of which a value may be, each with its tag in a union."""
    inner, *about = get_args(kind) or (None,)
    if get_origin(kind) is Annotated:
        yield from _alternatives(inner, next((each.tag for each in about if isinstance(each, Tag)), tag))
    elif get_origin(kind) in (Union, UnionType):
        for each in (inner, *about):
            yield from _alternatives(each)
    else:
        yield kind, tag or (kind.__name__ if _is_model(kind) else "")


def _below(kind: Any, step: str | int) -> Iterable[Any]:
    """Return the types of a part of a value: a field of a model, or the values of a mapping or list."""
    if _is_model(kind):
        return [field.annotation for name, field in kind.model_fields.items() if step in (name, field.alias)]
    return [inner for inner in get_args(kind) if inner is not Ellipsis][-1:]


def _is_model(kind: Any) -> TypeGuard[type[BaseModel]]:
    return isinstance(kind, type) and issubclass(kind, BaseModel)
