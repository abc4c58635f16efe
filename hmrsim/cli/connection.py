"""The connection of a command to a simulator, and its requests."""

from __future__ import annotations

import argparse
import json
import logging
import os
import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Any, Final, TypeVar

from hmrsim.cli.options import Refused
from hmrsim.program.log_options import logging_to_stderr
from hmrsim_zenoh.errors import SimulatorGone
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from hmrsim_zenoh.client.client import Client, ClockChoice

Info = dict[str, Any]
"""The message of ``_world/info``, which describes a simulator."""

VIEWER: Final = "viewer"
"""The role of commands that only read."""
OPERATOR: Final = "operator"
"""The role of commands that change something."""

_RUN: Final = "HMRSIM_RUN"
"""The environment variable that is set in controllers that were started for a run."""
_MIN_WAIT: Final = 0.1
_LOOK: Final = 0.5
"""Wall seconds between checks whether the simulator is still there."""
_GRACE: Final = 3.0
"""Wall seconds that a simulator may be unreachable, as when a router is restarted."""
_OK: Final = 1

T = TypeVar("T")

_log = logging.getLogger(__name__)


@contextmanager
def connected(args: argparse.Namespace, role: str = VIEWER, *, name: str = "") -> Iterator[tuple[Client, Info]]:
    """Connect to a simulator within ``--timeout``, and yield the client and the simulator's description.

    Args:
        args: The command line.
        role: The role to use with ``--secure`` without ``--role``.
        name: The participant's name in lockstep, if the command runs as part of a controller that was started for a
            run; empty to take no part.

    Raises:
        SimulatorNotFound: No simulator answers.
    """
    from hmrsim_zenoh.client.client import Client

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
    """Return whether this process belongs to the controller of an experiment's run or of a search for faults."""
    return _RUN in os.environ


def received(client: Client, items: queue.SimpleQueue[T], period: float = _LOOK) -> Iterator[T | None]:
    """Yield items as they arrive, and None after each *period* of wall seconds without one.

    Raises:
        SimulatorGone: The simulator has been away for too long.
    """
    seen = time.monotonic()
    while True:
        try:
            item = items.get(timeout=period)
        except queue.Empty:
            if client.alive:
                seen = time.monotonic()
            elif (away := time.monotonic() - seen) > _GRACE:
                raise SimulatorGone("the simulator is gone") from None
            else:
                _log.debug("the simulator's token has been away for %.1f s", away)
            yield None
        else:
            yield item


def value_of(client: Client, name: str) -> Any:
    """Return a value of the world, such as ``scene``."""
    return json.loads(client.get(client.keys.world(name)))


def call(client: Client, service: str, **request: Any) -> dict[str, Any]:
    """Call a service of the world and return its response.

    Raises:
        Refused: The result is not success.
        HmrsimError: As `Client.get`.
    """
    answer = client.get(client.keys.world(service), payload=json.dumps(request).encode())
    response: dict[str, Any] = json.loads(answer)
    result = response.get("result", {"result": _OK})
    if result["result"] != _OK:
        raise Refused(result["error_message"] or f"{service} failed with result {result['result']}")
    return response
