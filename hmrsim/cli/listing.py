"""The ``list`` of actions, topics and services: one name a line, with ROS types on request."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.cli.connection import connected
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json

if TYPE_CHECKING:
    from hmrsim.cli.names import Info


def configure(
    parser: argparse.ArgumentParser, find: Callable[[argparse.Namespace, Info], Iterable[Mapping[str, Any]]]
) -> None:
    """Add the arguments of a ``list``.

    Args:
        parser: Of the command.
        find: Returns the entries of a running simulator, each as in ``--json``: ``name``, ``type`` and more.
    """
    parser.add_argument("-t", "--show-types", action="store_true", help="show the ROS type after each name")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(function=lambda args: _list(args, find))
    add_connection_options(parser)


def _list(args: argparse.Namespace, find: Callable[[argparse.Namespace, Info], Iterable[Mapping[str, Any]]]) -> int:
    with connected(args) as (_, info):
        found = [dict(one) for one in find(args, info)]
    if args.json:
        show_json(found)
        return ExitCode.DONE
    for one in found:
        show(f"{one['name']} [{one['type']}]" if args.show_types else one["name"])
    return ExitCode.DONE
