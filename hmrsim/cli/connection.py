"""Reaching a simulator from a command."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.client import Client
from hmrsim_zenoh.errors import SimulatorGone
from hmrsim_zenoh.options import session_options

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Iterator

    from hmrsim.cli.names import Info

_LEAST_WAIT: Final = 0.1
_GRACE: Final = 3.0
"""Wall seconds that a simulator may be out of reach, as when a router is restarted."""


@contextmanager
def connected(args: argparse.Namespace) -> Iterator[tuple[Client, Info]]:
    """Connect to a simulator and ask what it has; all within ``--timeout``.

    Raises:
        NobodyThere: None answers.
    """
    options = session_options(args)
    until = time.monotonic() + options.timeout

    def left() -> float:
        return max(_LEAST_WAIT, round(until - time.monotonic(), 1))

    with Client(options, acknowledge_timeout=options.timeout) as client:
        client.wait_for_simulator(left())
        yield client, client.info(left())


def look_for_simulator(client: Client) -> Callable[[], None]:
    """Return what to call now and then: it raises `SimulatorGone` once the simulator has been away for too long."""
    seen = time.monotonic()

    def look() -> None:
        nonlocal seen
        if client.alive:
            seen = time.monotonic()
        elif time.monotonic() - seen > _GRACE:
            raise SimulatorGone("the simulator is gone")

    return look
