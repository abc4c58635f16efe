"""The length of texts in requests: they come back in answers, in the log and in the trace."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from pydantic import BaseModel

from hmrsim_zenoh.wire.envelopes import unreadable_at

if TYPE_CHECKING:
    from collections.abc import Iterator

MAX_TEXT: Final = 4096
"""Characters of a text in a request, such as a name."""

_LONG: Final = frozenset({"resource_string", "settings", "goal_id"})
"""The fields that hold a file, such as a world, and ids, which are checked as such."""


def check_texts(message: object, size: int) -> None:
    """Check the texts of a message that came in a payload of *size* bytes.

    Raises:
        UnreadableError: One is too long.
    """
    if size <= MAX_TEXT:
        return
    for path, text in _texts(message):
        if len(text) > MAX_TEXT:
            raise unreadable_at(path, f"a text of {len(text)} characters; at most {MAX_TEXT} are taken", text)


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
