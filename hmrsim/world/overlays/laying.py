"""Laying changes over what world files say."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import instead
from hmrsim.distributions import is_distribution
from hmrsim.world.merging import own
from hmrsim.world.overlays.flaw import OverlayFlaw
from hmrsim.world.overlays.steps import APPEND, Step, index_of, matching
from hmrsim.world.pairs import Pairs

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.world.overlays.changes import Change
    from hmrsim.world.overlays.work import Work

_NAMED: Final = ("waypoints", "places", "docks", "doors", "lifts", "items", "robot_types", "robots")
"""The mappings of a world whose keys are names of things: a path leads only through things that are there."""

_SHORT: Final = {"lanes": ("from", "to"), "waypoints": ("at",)}
"""The keys of entries that a file may also write as a list: a lane ``[from, to]``, a waypoint ``[x, y]``."""


def lay(data: dict[str, Any], change: Change, work: Work) -> list[Path]:
    """Make a change; return where, so that what is wrong there can be told with the overlay's line.

    The mappings and lists of *data* that change must not be shared with anybody else.

    Raises:
        OverlayFlaw: There is no such place; the text says why.
        TooMuchWorkError: It changes more than the limit allows.
    """
    *way, last = change.steps
    changed: list[Path] = []
    appends = last == APPEND and not last.quoted and not change.removes
    several = any(step.is_pattern for step in way)
    size = work.size(change.value)
    compare = partial(work.compare, path=change.path)
    for holder, path in _holders(data, tuple(way), (), [] if appends else {}, compare):
        if last.is_pattern:
            compare(last, holder)
        # What is put is a copy each time.
        work.spend(size * (len(holder) if last.is_pattern else 1), change.path)
        if change.removes:
            if not several or last.is_pattern or last in holder:
                _take_away(holder, path, last)
        elif isinstance(holder, list) and appends:
            changed += _added(holder, path, change.value)
        else:
            changed += _put(holder, path, last, change.value)
    return changed


def _holders(
    holder: Any,
    way: tuple[Step, ...],
    path: Path,
    empty: dict[str, Any] | list[Any],
    compare: Callable[[str, Any], None],
) -> Iterator[tuple[dict[str, Any] | list[Any], Path]]:
    """Yield the mappings and lists that a way leads to; where there is none, *empty*, and mappings on the way."""
    if not way:
        yield holder, path
        return
    step, *rest = way
    if step.is_pattern:
        compare(step, holder)
    for key in [*_keys(holder, path, step)]:
        part = _opened(holder, key, path, {} if rest else own(empty))
        yield from _holders(part, tuple(rest), (*path, key), empty, compare)


def _opened(holder: Any, key: str | int, path: Path, empty: dict[str, Any] | list[Any]) -> Any:
    """Return the entry of a mapping or list through which a path leads."""
    part = holder.get(key) if isinstance(holder, dict) else holder[key]
    if isinstance(part, list) and len(path) == 1 and path[0] in _SHORT:
        keys = _SHORT[str(path[0])]
        part = dict(zip(keys, part if len(keys) > 1 else [part], strict=False))
    elif part is None or is_distribution(part):
        part = empty
    elif isinstance(part, Pairs):
        part = [*part]
    elif not isinstance(part, (dict, list)):
        part = {}
    holder[key] = part
    return part


def _keys(holder: dict[str, Any] | list[Any], path: Path, step: Step) -> Iterator[str | int]:
    """Yield the keys or indices of the entries that a step leads through, or puts a value at."""
    if step.is_pattern:
        found = [*matching(step, holder)]
        if not found:
            raise OverlayFlaw(f"{_said(path)} has nothing that {step} stands for{_entries(holder)}")
        yield from found
    elif isinstance(holder, list):
        index = index_of(step, holder)
        if index is None:
            raise OverlayFlaw(
                f"{_said(path)} is a list of {len(holder)}, in which {step!r} is no index; expected 0 to "
                f"{len(holder) - 1}, or {APPEND} to add entries"
            )
        yield index
    elif len(path) == 1 and path[0] in _NAMED and step not in holder:
        raise OverlayFlaw(f"there is no {step!r} among the {path[0]}{instead(step, holder)}")
    else:
        yield str(step)


def _added(entries: list[Any], path: Path, value: Any) -> list[Path]:
    more = own(value) if isinstance(value, list) else [own(value)]
    before = len(entries)
    entries.extend(more)
    return [(*path, before + i) for i in range(len(more))]


def _put(holder: Any, path: Path, last: Step, value: Any) -> Iterator[Path]:
    if isinstance(holder, list) or last.is_pattern:
        for key in _keys(holder, path, last):
            if value != {} or not isinstance(holder[key], (dict, list)):
                holder[key] = own(value)
                yield (*path, key)
        return
    key = str(last)
    if value == {} and isinstance(holder.get(key), (dict, list)):
        return  # other changes go on from there
    holder[key] = own(value)
    yield (*path, key)


def _take_away(holder: Any, path: Path, last: Step) -> None:
    if isinstance(holder, dict) and not last.is_pattern and last not in holder:
        raise OverlayFlaw(f"{_said(path)} has no {str(last)!r} to take away{_entries(holder)}")
    for key in reversed([*_keys(holder, path, last)]):
        del holder[key]


def _said(path: Path) -> str:
    return ".".join(str(step) for step in path) or "the world"


def _entries(holder: dict[str, Any] | list[Any]) -> str:
    if isinstance(holder, dict):
        return instead("", holder, verb="it has")
    return f"; it has {len(holder)} entries"
