"""Changes of a world by path, such as ``robots.*.components.battery.capacity``, and the limit of their work."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self

from hmrsim.diagnostics import Finding, shown
from hmrsim.distributions import is_distribution
from hmrsim.world.overlays.expressions import Names, OverlayFlaw, in_key, substituted

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

MAX_WORK: Final = 1_000_000
"""Maximum work of all overlays of a world, as a short overlay can ask for much: lines, entries that patterns are
compared with, and values that are set."""

FLAW: Final = 200
"""The work of an error, whose message searches for similar names."""

_CHARACTERS: Final = 16
"""Characters of a text that count as one value."""

_COMPARED: Final = 1024
"""Characters of a pattern, times those of the keys, that count as one value, as comparing takes so many steps."""


class TooMuchWorkError(Exception):
    """The overlays of a world exceed the limit of work.

    Attributes:
        path: The line of the overlay that exceeds it, as a path.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(
            f"the overlays of a world ask for more than {MAX_WORK:,} changes in all, with every repetition, every entry"
            " that a pattern is compared with and every value that is put; repeat less, or write the values into the "
            "world itself"
        )
        self.path = path


class Work:
    """The work of all overlays of a world, counted."""

    def __init__(self) -> None:
        self._left = MAX_WORK

    def spend(self, amount: int, path: Path) -> None:
        """Count work of the line at *path*, before it is done.

        Raises:
            TooMuchWorkError: The limit is exceeded.
        """
        self._left -= amount
        if self._left < 0:
            raise TooMuchWorkError(path)

    def compare(self, pattern: str, parts: dict[str, Any] | list[Any], path: Path) -> None:
        """Count the comparison of a pattern with the keys or indices of all entries.

        Raises:
            TooMuchWorkError: The limit is exceeded.
        """
        letters = sum(map(len, parts)) if isinstance(parts, dict) else 0
        self.spend(len(parts) + letters * len(pattern) // _COMPARED, path)

    def size(self, value: Any) -> int:
        """Return the number of values in a value, counted no further than the work that is left."""
        size, parts = 0, [value]
        while parts and size <= self._left:
            part = parts.pop()
            size += 1
            if isinstance(part, dict):
                parts += part.values()
                size += sum(map(len, part)) // _CHARACTERS
            elif isinstance(part, list):
                parts += part
            elif isinstance(part, str):
                size += len(part) // _CHARACTERS
        return size


APPEND: Final = "+"
"""The step that appends entries to a list."""

MAX_STEPS: Final = 50
"""Maximum steps of a path, the same as the nesting of a file."""

_STEP: Final = re.compile(r""""(?P<double>[^"]*)"|'(?P<single>[^']*)'|(?P<plain>[^."']+)""")


class Step(str):
    """A step of a path: a key, an index, the name of a list's entry, or a pattern with ``*`` unless it was quoted."""

    __slots__ = ("quoted",)

    quoted: bool

    def __new__(cls, text: str, *, quoted: bool = False) -> Self:
        """Create a step of a path."""
        step = super().__new__(cls, text)
        step.quoted = quoted
        return step

    def searches(self, parts: dict[str, Any] | list[Any]) -> bool:
        """Return whether the step is compared with all entries."""
        return self.is_pattern or (isinstance(parts, list) and not self.isdecimal())

    @property
    def is_pattern(self) -> bool:
        """True if the step matches several entries."""
        return not self.quoted and "*" in self


def steps_of(path: str) -> tuple[Step, ...]:
    """Return the steps of a path; names with dots are quoted: ``places."ward.1".at``.

    Raises:
        OverlayFlaw: The path is invalid.
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
    """Return a path continued by further steps.

    Raises:
        OverlayFlaw: The path has too many steps.
    """
    number = len(steps) + len(further)
    if number > MAX_STEPS:
        raise OverlayFlaw(f"leads through {number} entries; at most {MAX_STEPS}")
    return (*steps, *further)


def matching(step: Step, parts: dict[str, Any] | list[Any]) -> Iterator[str | int]:
    """Yield the keys or indices of the entries that a pattern matches."""
    if isinstance(parts, list):
        yield from (i for i in range(len(parts)) if fnmatch.fnmatchcase(str(i), step))
    else:
        yield from [key for key in parts if fnmatch.fnmatchcase(key, step)]


def index_of(step: str, entries: Sequence[object]) -> int | None:
    """Return the index of the entry that a step refers to by its index or name, or None if there is none."""
    if not step.isdecimal():
        named = (i for i, entry in enumerate(entries) if isinstance(entry, dict) and entry.get("name") == step)
        return next(named, None)
    index = int(step) if len(step) < 10 else -1  # noqa: PLR2004
    return index if 0 <= index < len(entries) else None


REMOVE: Final = "~"
"""The first character of a key that removes an entry."""

_EACH: Final = re.compile(r"each (?:(?P<name>[A-Za-z_]\w*) in )?(?P<over>.+)", re.ASCII)
_RANGE: Final = re.compile(r"(-?\d{1,9})\.\.(-?\d{1,9})", re.ASCII)
_MAX_REPEATED: Final = 10_000
"""Maximum repetitions of an ``each``."""


@dataclass(frozen=True)
class Change:
    """A change of a world.

    Attributes:
        steps: The path in the world.
        value: The new value; None if the entry is removed. An empty mapping keeps an existing mapping.
        removes: Whether the entry is removed.
        path: The path of the change in the overlay.
    """

    steps: tuple[Step, ...]
    value: Any
    removes: bool
    path: Path


def changes(
    entries: Mapping[str, Any], names: Names, work: Work, steps: tuple[Step, ...] = (), path: Path = ()
) -> Iterator[Change | Finding]:
    """Yield the changes of an overlay in order, and its errors.

    Args:
        entries: Values by path. A mapping continues the path, ``~PATH`` removes an entry, and ``each 1..6`` repeats the
            entries below it with ``$i``.
        names: The values that expressions can use.
        work: Counts every repeated line and the values that are set.
        steps: The path in the world to which *entries* belong.
        path: The path of *entries* in the overlay.

    Raises:
        TooMuchWorkError: The limit is exceeded.
    """
    for key, value in entries.items():
        here = (*path, key)
        work.spend(1, here)
        try:
            each = _EACH.fullmatch(key)
            if each is not None:
                yield from _repeated(each, value, names, steps, here, work)
                continue
            text = in_key(key, names)
            work.spend(work.size(text), here)
            removes = text.startswith(REMOVE)
            target = joined(steps, steps_of(text.removeprefix(REMOVE)))
            if removes and value is not None:
                yield Finding(here, f"takes an entry away, so that it has no value; got {shown(value)}", value)
            elif removes:
                yield Change(target, None, removes=True, path=here)
            elif isinstance(value, dict) and not is_distribution(value) and target[-1] != APPEND:
                yield Change(target, {}, removes=False, path=here)
                yield from changes(value, names, work, target, here)
            else:
                work.spend(work.size(value), here)
                result = substituted(value, names)
                # Expressions may have made its texts longer.
                work.spend(work.size(result), here)
                yield Change(target, result, removes=False, path=here)
        except OverlayFlaw as error:
            yield Finding(here, str(error), value)


def _repeated(
    each: re.Match[str], value: object, names: Names, steps: tuple[Step, ...], path: Path, work: Work
) -> Iterator[Change | Finding]:
    if not isinstance(value, dict):
        raise OverlayFlaw(f"expected a mapping to repeat, got {shown(value)}")
    name = each["name"] or "i"
    for index in _indices(each["over"].strip(), names):
        work.spend(1, path)
        yield from changes(value, {**names, name: index}, work, steps, path)


def _indices(over: str, names: Names) -> list[Any]:
    """Return the values of the index of an ``each``."""
    values = substituted(over, names)
    if isinstance(values, str):
        span = _RANGE.fullmatch(values)
        if span is not None:
            first, last = int(span[1]), int(span[2])
            if last - first >= _MAX_REPEATED:
                raise OverlayFlaw(f"repeats {last - first + 1} times; at most {_MAX_REPEATED}")
            if last < first:
                raise OverlayFlaw(f"{values} runs over nothing; the first comes before the last")
            return [*range(first, last + 1)]
        values = [part.strip() for part in values.split(",")]
    if not isinstance(values, (list, dict)):
        raise OverlayFlaw(f"expected 1..6, names such as a, b or a table, got {shown(values)}")
    return [*values]
