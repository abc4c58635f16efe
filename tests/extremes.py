"""Requests with extreme numbers and texts, generated from the types of messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, get_args, get_origin

from hypothesis import strategies as st

from hmrsim.interfaces.message import Message

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


Choose = Callable[[Sequence[Any]], Any]
"""Returns one of the given values."""


def bodies(kind: type[Message], names: Sequence[str] = ()) -> st.SearchStrategy[dict[str, Any]]:
    """Return requests of a type in plain values; most are valid, and *names* are names of existing entities."""

    @st.composite
    def made(draw: Any) -> dict[str, Any]:
        return body(kind, names, lambda values: draw(st.sampled_from(values)))

    return made()


def body(kind: type[Message], names: Sequence[str], choose: Choose) -> dict[str, Any]:
    """Return one request of a type; *choose* makes every choice."""
    return {
        name: _value(field.annotation, tuple(field.metadata), names, choose)
        for name, field in kind.model_fields.items()
        if choose((True, True, False))
    }


def _value(annotation: Any, metadata: tuple[Any, ...], names: Sequence[str], choose: Choose) -> Any:
    if get_origin(annotation) is list:
        of = _plain(get_args(annotation)[0])
        return [_value(of, (), names, choose) for _ in range(choose((0, 1, 1, 2, 3)))]
    kind = _plain(annotation)
    if isinstance(kind, type) and issubclass(kind, Message):
        return body(kind, names, choose)
    if kind is bool:
        return choose((True, False))
    if kind is int:
        least = next((each.ge for each in metadata if hasattr(each, "ge")), -math.inf)
        greatest = next((each.le for each in metadata if hasattr(each, "le")), math.inf)
        return choose([n for n in WHOLE if least <= n <= greatest])
    if kind is float:
        return choose(NUMBERS)
    return choose((*names, *names, *TEXTS))


def _plain(annotation: Any) -> Any:
    """Return a type without its annotations."""
    return get_args(annotation)[0] if hasattr(annotation, "__metadata__") else annotation
