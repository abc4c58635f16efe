"""Requests with numbers and texts at the ends of what they may be, made from the types of messages."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, get_args, get_origin

from hypothesis import strategies as st

from hmrsim.interfaces.message import Message

if TYPE_CHECKING:
    from collections.abc import Sequence

_MAGNITUDES = (0.0, 5e-324, 2.2e-308, 1e-45, 1e-9, 1e-3, 0.5, 1.0, math.pi, 9.0, 1e3, 1e7, 1e9, 2.0**31, 1e16, 3.4e38)
_BEYOND = (1e154, 1.3e154, 1e300, 1.7e308, 1.7976931348623157e308)
NUMBERS = [sign * size for size in (*_MAGNITUDES, *_BEYOND) for sign in (1.0, -1.0)]
WHOLE = [0, 1, -1, 2, 255, 2**15, 2**31 - 1, -(2**31), 2**32 - 1, 2**53, 2**63 - 1, -(2**63), 2**64 - 1]
TEXTS = [
    "",
    "map",
    "x" * 5_000,
    "\x00",
    "\n",
    "\x1b[2J",
    "💥",
    "../../etc/passwd",
    "**",
    "a/b",
    "{}",
    "[",
    "%s",
    "1e308",
]


def bodies(kind: type[Message], names: Sequence[str] = ()) -> st.SearchStrategy[dict[str, Any]]:
    """Return requests of a type, in plain values; most are valid, and *names* are names of what there is."""
    fields = {
        name: _values(field.annotation, tuple(field.metadata), tuple(names))
        for name, field in kind.model_fields.items()
    }
    return st.fixed_dictionaries({}, optional=fields)


def _values(annotation: Any, metadata: tuple[Any, ...], names: tuple[str, ...]) -> st.SearchStrategy[Any]:
    if get_origin(annotation) is list:
        return st.lists(_values(_plain(get_args(annotation)[0]), (), names), max_size=3)
    kind = _plain(annotation)
    if isinstance(kind, type) and issubclass(kind, Message):
        return st.deferred(lambda: bodies(kind, names))
    if kind is bool:
        return st.booleans()
    if kind is int:
        least = next((each.ge for each in metadata if hasattr(each, "ge")), None)
        greatest = next((each.le for each in metadata if hasattr(each, "le")), None)
        return st.sampled_from(
            [n for n in WHOLE if (least is None or n >= least) and (greatest is None or n <= greatest)]
        )
    if kind is float:
        return st.sampled_from(NUMBERS) | st.floats(allow_nan=False, allow_infinity=False)
    return st.sampled_from([*names, *names, *TEXTS]) | st.text(max_size=20)


def _plain(annotation: Any) -> Any:
    """Return a type without its annotations."""
    return get_args(annotation)[0] if hasattr(annotation, "__metadata__") else annotation
