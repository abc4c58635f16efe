"""The connection of a command to a simulator."""

from __future__ import annotations

import argparse
import logging
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Final

from hmrsim.program.log_options import logging_to_stderr
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.errors import SimulatorGone
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from hmrsim.cli.names import Info
    from hmrsim_zenoh.client.client import ClockChoice

VIEWER: Final = "viewer"
"""The role of commands that only read."""
OPERATOR: Final = "operator"
"""The role of commands that change something."""

_RUN: Final = "HMRSIM_RUN"
"""The variable that a controller has which was started for a run."""
_MIN_WAIT: Final = 0.1
_GRACE: Final = 3.0
"""Wall seconds that a simulator may be out of reach, as when a router is restarted."""

_log = logging.getLogger(__name__)


@contextmanager
def connected(args: argparse.Namespace, role: str = VIEWER, *, name: str = "") -> Iterator[tuple[Client, Info]]:
    """Connect to a simulator and get its description, within ``--timeout``.

    *role* is that of the command, where ``--secure`` is given without ``--role``. With a *name* it takes part in
    lockstep where it is a part of the controller of a run, as the environment says.

    Raises:
        SimulatorNotFound: No simulator answers.
    """
    options = session_options(args, role)
    begin = time.monotonic()

    def left() -> float:
        return max(_MIN_WAIT, round(begin + options.timeout - time.monotonic(), 1))

    with logging_to_stderr(args) if "log_level" in args else nullcontext():
        where = ", ".join(options.connect or options.listen) or "the default endpoint"
        _log.debug("connecting to %s, prefix %r, for up to %g s", where, options.prefix, options.timeout)
        clock: ClockChoice = "auto" if name and in_run() else "realtime"
        with Client(options, clock=clock, name=name or "cli", acknowledge_timeout=options.timeout) as client:
            _log.debug("session open after %.3f s; waiting for the simulator's token", time.monotonic() - begin)
            client.wait_for_simulator(left())
            info = client.info(left())
            world = info.get("world", {})
            _log.info("connected to hmrsim %s, world %r", info.get("hmrsim"), world.get("name"))
            yield client, info


def in_run() -> bool:
    """Return whether this is a process of the controller of an experiment's run, or of a search for faults."""
    return _RUN in os.environ


def look_for_simulator(client: Client) -> Callable[[], None]:
    """Return a function to call periodically; it raises `SimulatorGone` if the simulator has been away for too long."""
    seen = time.monotonic()

    def look() -> None:
        nonlocal seen
        if client.alive:
            seen = time.monotonic()
            return
        _log.debug("the simulator's token has been away for %.1f s", time.monotonic() - seen)
        if time.monotonic() - seen > _GRACE:
            raise SimulatorGone("the simulator is gone")

    return look
