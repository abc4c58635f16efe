"""The hospital's mission as users run it: the simulator and bt-controller, each a process, watched from outside."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import zenoh

from benchmarks._processes import HMRSIM, PATIENCE, command, line_of
from benchmarks._wire import ask
from hmrsim.world_checks import load_world
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client

_BT_CONTROLLER = (sys.executable, "-m", "bt_controller")


@dataclass
class Mission:
    """The cost of one run of the mission.

    Attributes:
        wall: Wall seconds, from the moment when the controller began to the moment when it was done.
        simulated: Simulated seconds.
        round_trips: Grants, in lockstep.
    """

    wall: float
    simulated: float
    round_trips: int


def in_lockstep() -> Mission:
    """Run the mission in lockstep: it takes from the controller's joining to its leaving, as its token shows."""
    return _run("hmrsim/_participant/*", "--clock", "lockstep")


def in_real_time(factor: float) -> Mission:
    """Run the mission in real time: it takes from the first to the last event."""
    return _run("hmrsim/_world/events", "--real-time-factor", str(factor))


def _run(watched: str, *options: str) -> Mission:
    with command(*HMRSIM, "run", "hospital", *options, "--listen", "tcp/127.0.0.1:0") as simulator:
        endpoint = line_of(simulator).split()[1]
        with open_client(SessionOptions(connect=(endpoint,))) as session:
            times: list[float] = []
            subscriber = _watch(session, watched, lambda: times.append(time.perf_counter()))
            words = ("run", "bt_controller.examples.hospital:mission", "--robot", *load_world("hospital").world.robots)
            with command(*_BT_CONTROLLER, *words, "--connect", endpoint) as controller:
                out, _ = controller.communicate(timeout=PATIENCE)
                if controller.returncode:
                    raise RuntimeError(f"bt-controller ended with {controller.returncode}: {out}")
            state: dict[str, Any] = json.loads(ask(session, "hmrsim/_world/time/state", b""))
            subscriber.undeclare()
    return Mission(times[-1] - times[0], state["now"], state["epoch"])


def _watch(session: zenoh.Session, key: str, note: Callable[[], None]) -> zenoh.Subscriber[None]:
    """Call *note* whenever something is published, or a liveliness token comes or goes."""
    handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(lambda _sample: note(), indirect=False)
    if "_participant" in key:
        return session.liveliness().declare_subscriber(key, handler)
    return session.declare_subscriber(key, handler)
