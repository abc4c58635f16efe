"""``hmrsim completion``: completion scripts for shells, and the completers of ``hmrsim``'s arguments."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode
from hmrsim.cli.output import show
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from hmrsim.program.command_line import Completer
    from hmrsim.world import World

_PROGRAMS: Final = ("hmrsim", "bt-controller")

_EXAMPLES: Final = """\
examples:
  hmrsim completion bash >> ~/.bashrc
  eval "$(hmrsim completion zsh)"         # in ~/.zshrc, after: autoload -U compinit && compinit
  hmrsim completion fish > ~/.config/fish/completions/hmrsim.fish

Names of robots, actions, topics and services come from the running simulator, if one answers at once at
HMRSIM_CONNECT or at the default endpoint."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim completion``."""
    parser.description = "Print a script that makes a shell complete `hmrsim` and `bt-controller`."
    parser.epilog = _EXAMPLES
    parser.add_argument("shell", metavar="SHELL", choices=("bash", "zsh", "fish"), help="bash, zsh or fish")
    parser.set_defaults(function=_print_script)


def _print_script(args: argparse.Namespace) -> int:
    from argcomplete.shell_integration import shellcode

    show(shellcode(_PROGRAMS, shell=args.shell).rstrip("\n"))
    return ExitCode.DONE


def _worlds(prefix: str, **_unused: object) -> Iterable[str]:
    from argcomplete.completers import FilesCompleter

    from hmrsim.world.files import shipped_maps
    from hmrsim.world.formats import registry

    suffixes = [suffix.removeprefix(".") for kind in registry().values() for suffix in kind.suffixes]
    return [*shipped_maps(), *FilesCompleter(suffixes)(prefix)]


def _world_of(args: argparse.Namespace) -> World | None:
    """Return the world on the command line; None if it can't be read."""
    from hmrsim.cli.worlds import read_world

    try:
        return read_world(args).world
    except (HmrsimError, AttributeError):
        return None


def _points(parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    world = _world_of(parsed_args)
    return [*world.places, *world.docks, *world.waypoints, *world.robots, *world.items] if world else ()


def _robots(parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    world = _world_of(parsed_args)
    return list(world.robots) if world else ()


def _pages(parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    from hmrsim.world.files import find
    from hmrsim.world.includes import read_document

    name = parsed_args.world or ""
    try:
        return read_document(find(name), name).pages
    except HmrsimError:
        return ()


def _actions(prefix: str, parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    from hmrsim.cli.names import actions

    return _as_typed(prefix, (action.name for action in actions(_running(parsed_args))))


def _topics(prefix: str, parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    from hmrsim.cli.names import topics

    info = _running(parsed_args)
    return _as_typed(prefix, (topic.name for topic in topics(info))) if info else ()


def _services(prefix: str, parsed_args: argparse.Namespace, **_unused: object) -> Iterable[str]:
    from hmrsim.cli.names import services

    info = _running(parsed_args)
    return _as_typed(prefix, (service.name for service in services(info))) if info else ()


def _running(args: argparse.Namespace) -> dict[str, Any]:
    """Return the description of the running simulator; empty if none answers at once."""
    from hmrsim_zenoh.client.completion import running

    return running(args)


def _as_typed(prefix: str, names: Iterable[str]) -> Iterable[str]:
    """Return names without the leading slash if the user is typing one without."""
    return names if prefix.startswith("/") or not prefix else [name.removeprefix("/") for name in names]


_WITH_WORLD: Final = ("run", "simulate", "check", "map validate", "map info", "map plan", "map convert", "map render")

COMPLETERS: Final[Mapping[str, Completer]] = {
    **dict.fromkeys(("WORLD", "FILE", "IN"), _worlds),
    **dict.fromkeys(("hmrsim map plan FROM", "hmrsim map plan TO"), _points),
    "hmrsim map plan ROBOT": _robots,
    **{f"hmrsim {command} PAGE": _pages for command in _WITH_WORLD},
    **{f"hmrsim action {command} NAME": _actions for command in ("info", "send-goal", "send_goal")},
    **{f"hmrsim topic {command} NAME": _topics for command in ("echo", "hz", "info", "type")},
    **{f"hmrsim service {command} NAME": _services for command in ("call", "type")},
}
