"""Paths of overlays: ``robots.*.components.battery.capacity``."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterator, Sequence
from typing import Any, Final, Self

from hmrsim.world.overlays.flaw import OverlayFlaw

APPEND: Final = "+"
"""The step that adds entries at the end of a list."""

MAX_STEPS: Final = 50
"""The steps of a path, as many as a file may be nested."""

_STEP: Final = re.compile(r""""(?P<double>[^"]*)"|'(?P<single>[^']*)'|(?P<plain>[^."']+)""")


class Step(str):
    """A step of a path: a key, an index, or a pattern with ``*`` unless it was quoted."""

    __slots__ = ("quoted",)

    quoted: bool

    def __new__(cls, text: str, *, quoted: bool = False) -> Self:
        """Make a step."""
        step = super().__new__(cls, text)
        step.quoted = quoted
        return step

    @property
    def is_pattern(self) -> bool:
        """Whether it stands for several entries."""
        return not self.quoted and "*" in self


def steps_of(path: str) -> tuple[Step, ...]:
    """Return the steps of a path; names with dots are quoted: ``places."ward.1".at``.

    Raises:
        OverlayFlaw: It is none; the text says why.
    """
    steps, at = [], 0
    while True:
        match = _STEP.match(path, at)
        if match is None:
            raise OverlayFlaw(
                f"{path!r} is no path; expected names with dots between them, such as robots.*.base.speed"
            )
        steps.append(Step(match[match.lastgroup or 0].strip(), quoted=match.lastgroup != "plain"))
        at = match.end()
        if at == len(path):
            return tuple(steps)
        if path[at] != ".":
            raise OverlayFlaw(f"{path!r} is no path; expected a dot after {path[:at]!r}")
        at += 1


def joined(steps: tuple[Step, ...], further: tuple[Step, ...]) -> tuple[Step, ...]:
    """Return a path that goes on.

    Raises:
        OverlayFlaw: It has too many steps.
    """
    number = len(steps) + len(further)
    if number > MAX_STEPS:
        raise OverlayFlaw(f"leads through {number} entries; at most {MAX_STEPS}")
    return (*steps, *further)


def matching(step: Step, parts: dict[str, Any] | list[Any]) -> Iterator[str | int]:
    """Yield the keys or indices of the entries that a pattern stands for."""
    if isinstance(parts, list):
        yield from (i for i in range(len(parts)) if fnmatch.fnmatchcase(str(i), step))
    else:
        yield from [key for key in parts if fnmatch.fnmatchcase(key, step)]


def index_of(step: str, entries: Sequence[object]) -> int | None:
    """Return the index that a step is in a list; None if it is none."""
    index = int(step) if step.isdecimal() and len(step) < 10 else -1  # noqa: PLR2004
    return index if 0 <= index < len(entries) else None
