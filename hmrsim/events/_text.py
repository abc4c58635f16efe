"""Templates for the texts of events, which Python and the page fill in alike.

A template is text with fields of an event's JSON in it:

- ``{item}`` is the field's value. ``{at:point}`` is formatted by one of `FORMATS` or of the caller's formats.
- ``[ by {by}]`` is an optional part, which is omitted unless all of its fields are present. A field is absent if it is
  missing or null, if its formatted text is empty, or if its format is unknown.
- ``[: {why}| for {for:and}| for its turn]`` has alternatives: the first one with all fields present is shown.
- ``{status=6}`` is a condition: it shows nothing, and is present if the field has that value.

Parts do not nest. ``hmrsim_zenoh/view/page/model/texts.js`` is the same in JavaScript.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    Format = Callable[[Any], str]

_PART: Final = re.compile(r"\[([^\]]*)\]|(\{[^}]*\}|[^\[{]+)")
_FIELD: Final = re.compile(r"\{(\w+)(?:([:=])([^}]*))?\}")


def render(template: str, fields: Mapping[str, Any], formats: Mapping[str, Format] | None = None) -> str:
    """Return a filled-in template; *fields* are as in JSON, and *formats* extend or override `FORMATS`."""
    known = FORMATS if formats is None else {**FORMATS, **formats}
    texts = []
    for optional, rest in _PART.findall(template):
        filled = (_filled(option, fields, known) for option in ([rest] if rest else optional.split("|")))
        texts.append(next((text for text in filled if text is not None), ""))
    return "".join(texts)


def fields_in(template: str) -> list[tuple[str, str]]:
    """Return the fields of a template with their formats, in order; a condition has an empty format."""
    return [(name, more if sign == ":" else "") for name, sign, more in _FIELD.findall(template)]


def _filled(alternative: str, fields: Mapping[str, Any], formats: Mapping[str, Format]) -> str | None:
    """Return a filled-in alternative, or None if a field is absent."""
    given = True

    def fill(match: re.Match[str]) -> str:
        nonlocal given
        name, sign, more = match.groups()
        value = fields.get(name)
        if sign == "=":
            given &= value is not None and plain(value) == more
            return ""
        form = formats.get(more or "")
        text = form(value) if form is not None and value is not None else ""
        given &= text != ""
        return text

    text = _FIELD.sub(fill, alternative)
    return text if given else None


def plain(value: Any) -> str:
    """Return a value as text: numbers with at most two decimals, lists separated by commas."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.2f}".rstrip("0").rstrip(".")
    if isinstance(value, (list, tuple)):
        return ", ".join(plain(item) for item in value)
    return str(value)


def _and(value: Any) -> str:
    names = [plain(item) for item in value]
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def _point(value: Any) -> str:
    x, y, *_ = value
    return f"({plain(float(x))}, {plain(float(y))})"


def _percent(value: Any) -> str:
    return f"{value:.0%}"


def _lane(value: Any) -> str:
    return "-".join(value)


def _error(value: Any) -> str:
    """Return the error message of a result, from Nav2's field, MoveIt's or that of simulation_interfaces."""
    code, result = value.get("error_code"), value.get("result")
    nested = code.get("message") if isinstance(code, dict) else ""
    message = value.get("error_msg") or nested or (result.get("error_message") if isinstance(result, dict) else "")
    return str(message or "")


FORMATS: Final[Mapping[str, Format]] = {
    "": plain,
    "and": _and,
    "point": _point,
    "percent": _percent,
    "end": lambda points: _point(points[-1]) if points else "",
    "lane": _lane,
    "error": _error,
}
"""The formats of fields: names joined by "and", a point, the last of several points, a share in percent, the two
waypoints of a lane, and the error of an action's result."""
