"""Texts of events: templates that Python and the page fill in alike.

A template is text with fields of an event's JSON in it:

- ``{item}`` is the field's value; ``{at:point}`` has it formatted, and names one of `FORMATS` or of a caller's;
- ``[ by {by}]`` is an optional part: it is left out unless every field in it is given. A field is not given when it is
  missing, null, or formatted as an empty text; one whose format is not known is not given either;
- ``[: {why}| for {for:and}| for its turn]`` has alternatives: the first whose fields are all given counts;
- ``{status=6}`` is a condition: nothing is shown for it, and it is given if the field has that value.

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
    """Return a template filled in.

    *fields* are as in JSON; *formats* are further ones, or others for the same names.
    """
    known = FORMATS if formats is None else {**FORMATS, **formats}
    texts = []
    for optional, rest in _PART.findall(template):
        filled = (_filled(each, fields, known) for each in ([rest] if rest else optional.split("|")))
        texts.append(next((text for text in filled if text is not None), ""))
    return "".join(texts)


def fields_in(template: str) -> list[tuple[str, str]]:
    """Return the fields of a template with their formats, in order; a condition's is empty."""
    return [(name, more if sign == ":" else "") for name, sign, more in _FIELD.findall(template)]


def _filled(alternative: str, fields: Mapping[str, Any], formats: Mapping[str, Format]) -> str | None:
    """Return an alternative filled in; None if one of its fields is not given."""
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
    """Return text as it is, a number with two decimals at most, true or false, and what is in a list, by commas."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.2f}".rstrip("0").rstrip(".")
    if isinstance(value, (list, tuple)):
        return ", ".join(plain(each) for each in value)
    return str(value)


def _and(value: Any) -> str:
    names = [plain(each) for each in value]
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def _point(value: Any) -> str:
    x, y, *_ = value
    return f"({plain(float(x))}, {plain(float(y))})"


def _percent(value: Any) -> str:
    return f"{value:.0%}"


def _lane(value: Any) -> str:
    return "-".join(value)


def _error(value: Any) -> str:
    """Return what a result says of an error, in Nav2's field, MoveIt's or that of the simulation's services."""
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
"""``and`` joins names; ``point`` is x and y, ``end`` the last point of some; ``percent`` is of a share; ``lane`` is its
two waypoints; ``error`` is of an action's result, in plain values."""
