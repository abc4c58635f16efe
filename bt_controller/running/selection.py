"""Selectors of robots: ``all``, ``type:nurse``, ``action:pickup``, ``component:claw``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Final

from bt_controller.world.directory import Directory, NotServed
from hmrsim.diagnostics import instead, meant

ALL: Final = "all"

_WHAT: Final[Mapping[str, Callable[[Directory, str], tuple[str, ...]]]] = {
    "type": lambda directory, robot: (directory.types[robot],),
    "action": lambda directory, robot: directory.actions[robot],
    "component": lambda directory, robot: directory.components[robot],
}
"""The attributes of a robot by the word before the colon."""


def check_selector(selector: str) -> None:
    """Check the syntax of a selector.

    Raises:
        ValueError: It is invalid.
    """
    kind, _, wanted = selector.partition(":")
    if selector != ALL and not (kind in _WHAT and wanted):
        forms = ", ".join(f"{kind}:NAME" for kind in _WHAT)
        raise ValueError(f"{selector!r} selects no robots; expected {ALL}, {forms}")


def selected(directory: Directory, selectors: Iterable[str]) -> list[str]:
    """Return the names of the robots that match any of the selectors, each once.

    Raises:
        NotServed: A selector matches no robot; the text lists the valid ones.
    """
    return sorted({robot for selector in selectors for robot in _chosen(directory, selector)})


def completions(directory: Directory) -> list[str]:
    """Return all selectors that match a robot."""
    found = {f"{kind}:{name}" for kind in _WHAT for name in _names(directory, kind)}
    return [ALL, *sorted(found)]


def _chosen(directory: Directory, selector: str) -> list[str]:
    if selector == ALL:
        if not directory.actions:
            raise NotServed("there are no robots")
        return list(directory.actions)
    kind, _, wanted = selector.partition(":")
    chosen = [robot for robot in directory.actions if wanted in _WHAT[kind](directory, robot)]
    if not chosen:
        names = _names(directory, kind)
        alike = meant(wanted, names)
        hint = f"; did you mean {kind}:{alike}?" if alike else instead(wanted, names)
        raise NotServed(f"no robot has {kind} {wanted!r}{hint}")
    return chosen


def _names(directory: Directory, kind: str) -> list[str]:
    return sorted({name for robot in directory.actions for name in _WHAT[kind](directory, robot)} - {""})
