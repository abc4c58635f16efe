"""The length of texts in requests: they come back in answers, in the log and in the trace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel

from hmrsim_zenoh.wire.envelopes import unreadable_at

if TYPE_CHECKING:
    from collections.abc import Iterator

MAX_TEXT: Final = 4096
"""Characters of a text in a request, such as a name."""

_TEXT: Final = frozenset({str, str | None})
"""The types of fields that hold one."""

_SHORT: Final = frozenset({bool, int, float})
"""The types of fields that hold no text."""

_LONG: Final = frozenset({"resource_string", "settings", "goal_id"})
"""The fields that hold a file, such as a world, and ids, which are checked as such."""


def check_texts(message: object, size: int) -> None:
    """Check the texts of a message that came in a payload of *size* bytes.

    Raises:
        UnreadableError: One is too long.
    """
    if size > MAX_TEXT:
        check_texts_of(message)


def check_texts_of(message: object) -> None:
    """Check the texts of a message that did not come in a payload.

    Raises:
        UnreadableError: One is too long.
    """
    kind: Any = type(message)
    texts_in = _texts_in(kind)
    if texts_in is not None and max(map(len, filter(None, texts_in(message))), default=0) <= MAX_TEXT:
        return
    for path, text in _texts(message):
        if len(text) > MAX_TEXT:
            raise unreadable_at(path, f"a text of {len(text)} characters; at most {MAX_TEXT} are taken", text)


@cache
def _texts_in(kind: type[Any]) -> Callable[[object], Sequence[str | None]] | None:
    """Return what finds the texts in messages of a type without lists; None for one with lists, which are walked."""
    paths = _paths(kind)
    if paths is None:
        return None
    return attrgetter(*paths) if len(paths) > 1 else lambda message: [attrgetter(path)(message) for path in paths]


def _paths(kind: Any) -> list[str] | None:
    found: list[str] = []
    for name, field in getattr(kind, "model_fields", {}).items():
        of = field.annotation
        if name in _LONG or of in _SHORT:
            continue
        inner = [""] if of in _TEXT else _paths(of) if isinstance(of, type) and issubclass(of, BaseModel) else None
        if inner is None:
            return None
        found += [f"{name}.{path}".rstrip(".") for path in inner]
    return found


def _texts(value: object) -> Iterator[tuple[str, str]]:
    """Yield the path of each text in a message, and the text."""
    if isinstance(value, str):
        yield "", value
    elif isinstance(value, BaseModel):
        for name, each in value:
            if name not in _LONG:
                yield from ((f"{name}.{path}".rstrip("."), text) for path, text in _texts(each))
    elif isinstance(value, list):
        for number, each in enumerate(value):
            yield from ((f"{number}.{path}".rstrip("."), text) for path, text in _texts(each))
