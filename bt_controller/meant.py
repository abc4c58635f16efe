"""What somebody wrote, and what could have been meant, as messages say it."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Collection

_LISTED: Final = 12
_SHOWN: Final = 60


def meant(wanted: str, known: Collection[str]) -> str | None:
    """Return the name that is most like the one that is wanted; None if none is like it."""
    alike = get_close_matches(wanted, known, n=1)
    return alike[0] if alike else None


def instead(wanted: str, known: Collection[str], *, verb: str = "there are", none: str = "") -> str:
    """Return what could be meant, or what there is, as the end of a message; *none* if there is nothing."""
    if alike := meant(wanted, known):
        return f"; did you mean {alike!r}?"
    if not known:
        return none
    listed = ", ".join(list(known)[:_LISTED])
    return f"; {verb} {listed}{', …' if len(known) > _LISTED else ''}"


def shown(text: str) -> str:
    """Return a text in quotes, its beginning only if it is long."""
    return repr(shortened(text))


def shortened(text: str) -> str:
    """Return a text, its beginning only if it is long."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"
