"""Pydantic's errors as findings: messages with the value, the expected one and a suggestion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeGuard, get_args

from pydantic import BaseModel

from hmrsim.diagnostics import MAX_FINDINGS, Finding, Path, dotted, instead, shown
from hmrsim.distributions import Distribution

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

_DISTRIBUTION = "distribution"
"""The step in pydantic's paths where a value is validated as a distribution."""

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


Models = type[BaseModel] | Mapping[tuple[str, ...], type[BaseModel]]
"""The model of a document, or the models of its parts by their paths, in which ``*`` is any key or index."""


def explain(error: ValidationError, data: object, models: Models) -> list[Finding]:
    """Return the errors of *data*, one finding per field and at most `MAX_FINDINGS`.

    *models* provide the known keys, for suggestions about unknown ones.
    """
    findings: dict[Path, Finding] = {}
    too_short: set[Path] = set()
    for details in error.errors(include_url=False, include_input=False)[:MAX_FINDINGS]:
        path, value = _follow(data, details["loc"], missing=details["type"] == "missing")
        if path not in findings:
            findings[path] = Finding(path, _message(details, path, value, models), value)
        if details["type"] in ("too_short", "too_long"):
            too_short.add(_follow(data, details["loc"], missing=False)[0])
    # Pydantic counts the entries of a list without the invalid ones, which are reported already.
    parents = {path[:i] for path in findings for i in range(len(path))}
    return [finding for path, finding in findings.items() if path not in too_short & parents]


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


def _message(details: ErrorDetails, path: Path, value: object, models: Models) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind == "extra_forbidden":
        loc = details["loc"]
        known = _keys_of_distribution(loc) if _DISTRIBUTION in loc else _known_keys(path[:-1], models)
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


def _keys_of_distribution(loc: tuple[str | int, ...]) -> Iterable[str]:
    *below, _ = loc[loc.index(_DISTRIBUTION) + 1 :]
    kind: Any = Distribution.model_fields[str(below[0])].annotation if below else Distribution
    return [*(get_args(kind) or (kind,))[0].model_fields]


def matches(pattern: tuple[str, ...], path: Path) -> bool:
    """Return whether a path has the form of a pattern, in which ``*`` is any key or index."""
    return len(pattern) == len(path) and all(
        expected in {"*", step} for expected, step in zip(pattern, path, strict=True)
    )


def _is_model(part: object) -> TypeGuard[type[BaseModel]]:
    return isinstance(part, type) and issubclass(part, BaseModel)


def _known_keys(path: Path, models: Models) -> Iterable[str]:
    if isinstance(models, Mapping):
        fitting = (part for part in models if matches(part, path))
        model = models.get(min(fitting, key=lambda part: part.count("*"), default=("",)))
        return () if model is None else _keys_of(model)
    model = models
    for step in path:
        # A part of a component's settings may be a model.
        annotation = model.model_fields[str(step)].annotation
        inner = next((kind for kind in (annotation, *get_args(annotation)) if _is_model(kind)), None)
        if inner is None:
            return ()
        model = inner
    return _keys_of(model)


def _keys_of(model: type[BaseModel]) -> Iterable[str]:
    return [field.alias or name for name, field in model.model_fields.items()]
