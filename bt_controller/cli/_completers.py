"""Shell completion with names of the running simulator."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from bt_controller.core.robots import Directory, completions
from hmrsim_zenoh.client.completion import robots, running

if TYPE_CHECKING:
    from hmrsim.program.command_line import Completer


def _selectors(parsed_args: argparse.Namespace, **_unused: object) -> list[str]:
    return completions(Directory.from_info(running(parsed_args)))


COMPLETERS: Final[Mapping[str, Completer]] = {
    "bt-controller run NAME": robots,
    "bt-controller run SELECTOR": _selectors,
}
