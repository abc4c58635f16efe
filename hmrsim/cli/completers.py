"""The completers of ``hmrsim``'s arguments, by program and metavar; loaded only for shell completion."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Final

from argcomplete.completers import FilesCompleter

from hmrsim.cli import names
from hmrsim.cli.services import services
from hmrsim.cli.topics import topics
from hmrsim.cli.worlds import read_world
from hmrsim.errors import HmrsimError
from hmrsim.world.files import find, shipped_maps
from hmrsim.world.formats import registry as formats
from hmrsim.world.includes import read_document
from hmrsim_zenoh.client.completion import running

if TYPE_CHECKING:
    from hmrsim.program.command_line import Completer


_WITH_WORLD: Final = ("run", "simulate", "check", "map validate", "map info", "map plan", "map convert", "map render")


def _worlds(prefix: str, **_unused: object) -> Iterable[str]:
    suffixes = [suffix.removeprefix(".") for kind in formats().values() for suffix in kind.suffixes]
    files = FilesCompleter(suffixes)(prefix)
    return [*shipped_maps(), *files]


def _points(parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    """Return the names of points in the world that is on the command line."""
    try:
        world = read_world(parsed_args, argument="file").world
    except (HmrsimError, AttributeError):
        return ()
    return [*world.places, *world.docks, *world.waypoints, *world.robots, *world.items]


def _robots_of_file(parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    try:
        return list(read_world(parsed_args, argument="file").world.robots)
    except (HmrsimError, AttributeError):
        return ()


def _pages(parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    """Return the pages of the drawing that is on the command line, whatever its argument is called."""
    name = next((getattr(parsed_args, key) for key in ("world", "file", "in") if hasattr(parsed_args, key)), None)
    try:
        return read_document(find(name or ""), name or "").pages
    except HmrsimError:
        return ()


def _actions(prefix: str, parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    return _as_typed(prefix, (one.name for one in names.actions(running(parsed_args))))


def _topics(prefix: str, parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    info = running(parsed_args)
    return _as_typed(prefix, (one.name for one in topics(info))) if info else ()


def _services(prefix: str, parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    info = running(parsed_args)
    return _as_typed(prefix, (one.name for one in services(info))) if info else ()


def _as_typed(prefix: str, found: Iterable[str]) -> Iterable[str]:
    """Return names without their first slash if it was not typed."""
    return found if prefix.startswith("/") or not prefix else [name.removeprefix("/") for name in found]


COMPLETERS: Final[Mapping[str, Completer]] = {
    "WORLD": _worlds,
    "FILE": _worlds,
    "IN": _worlds,
    "hmrsim map plan FROM": _points,
    "hmrsim map plan TO": _points,
    "hmrsim map plan ROBOT": _robots_of_file,
    **{f"hmrsim {command} PAGE": _pages for command in _WITH_WORLD},
    "hmrsim action info NAME": _actions,
    "hmrsim action send-goal NAME": _actions,
    "hmrsim action send_goal NAME": _actions,
    "hmrsim topic echo NAME": _topics,
    "hmrsim topic hz NAME": _topics,
    "hmrsim topic info NAME": _topics,
    "hmrsim topic type NAME": _topics,
    "hmrsim service call NAME": _services,
    "hmrsim service type NAME": _services,
}
