"""The changes that an overlay asks for, one after the other."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import Finding, shown
from hmrsim.distributions import is_distribution
from hmrsim.world.overlays.expressions import Names, in_key, substituted
from hmrsim.world.overlays.flaw import OverlayFlaw
from hmrsim.world.overlays.steps import APPEND, Step, joined, steps_of

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.world.overlays.work import Work

REMOVE: Final = "~"
"""What a key begins with whose entry is taken away."""

_EACH: Final = re.compile(r"each (?:(?P<name>[A-Za-z_]\w*) in )?(?P<over>.+)", re.ASCII)
_RANGE: Final = re.compile(r"(-?\d{1,9})\.\.(-?\d{1,9})", re.ASCII)
_MAX_REPEATED: Final = 10_000
"""Numbers that an ``each`` runs over."""


@dataclass(frozen=True)
class Change:
    """A change of a world.

    Attributes:
        steps: Where.
        value: What is put there; nothing where it is taken away; an empty mapping leaves one that is there.
        removes: Whether it is taken away.
        path: Where an overlay says so.
    """

    steps: tuple[Step, ...]
    value: Any
    removes: bool
    path: Path


def changes(said: Mapping[str, Any], names: Names, work: Work) -> Iterator[Change | Finding]:
    """Yield the changes that an overlay asks for in its order, and what is wrong with it.

    Args:
        said: What it says: values by path. A mapping goes on with the path, ``~PATH`` takes an entry away, and
            ``each 1..6`` repeats what is below it with ``$i``.
        names: The values that its expressions ask for.
        work: Counts its lines as often as they are repeated, and the values of what they put.

    Raises:
        TooMuchWorkError: They are more than the limit.
    """
    yield from _below(said, names, (), (), work)


def _below(
    said: Mapping[str, Any], names: Names, steps: tuple[Step, ...], path: Path, work: Work
) -> Iterator[Change | Finding]:
    for key, value in said.items():
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
            there = joined(steps, steps_of(text.removeprefix(REMOVE)))
            if removes and value is not None:
                yield Finding(here, f"takes an entry away, so that it has no value; got {shown(value)}", value)
            elif removes:
                yield Change(there, None, removes=True, path=here)
            elif isinstance(value, dict) and not is_distribution(value) and there[-1] != APPEND:
                yield Change(there, {}, removes=False, path=here)
                yield from _below(value, names, there, here, work)
            else:
                work.spend(work.size(value), here)
                put = substituted(value, names)
                # Its texts may be longer.
                work.spend(work.size(put), here)
                yield Change(there, put, removes=False, path=here)
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
        yield from _below(value, {**names, name: index}, steps, path, work)


def _indices(over: str, names: Names) -> list[Any]:
    """Return what an index runs over."""
    found = substituted(over, names)
    if isinstance(found, str):
        span = _RANGE.fullmatch(found)
        if span is not None:
            first, last = int(span[1]), int(span[2])
            if last - first >= _MAX_REPEATED:
                raise OverlayFlaw(f"repeats {last - first + 1} times; at most {_MAX_REPEATED}")
            if last < first:
                raise OverlayFlaw(f"{found} runs over nothing; the first comes before the last")
            return [*range(first, last + 1)]
        found = [part.strip() for part in found.split(",")]
    if not isinstance(found, (list, dict)):
        raise OverlayFlaw(f"expected 1..6, names such as a, b or a table, got {shown(found)}")
    return [*found]
