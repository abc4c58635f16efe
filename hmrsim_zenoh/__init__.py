"""The Zenoh interface of a simulator: the same actions, topics and services that a real robot's controller uses.

What is exported here is the client; `hmrsim_zenoh.hosting` serves worlds. An export is loaded when it is first used, as
the simulator and most commands need few of them.
"""

from __future__ import annotations

import importlib
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim_zenoh.client.action_client import ActionClient
    from hmrsim_zenoh.client.aio import AsyncClient, AsyncRobot
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.commander import Commander
    from hmrsim_zenoh.client.connection import Condition
    from hmrsim_zenoh.client.goal_handle import GoalHandle
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.client.subscription import Subscription
    from hmrsim_zenoh.errors import (
        BadOptions,
        ClientClosed,
        ConnectionDenied,
        Deadlock,
        Denied,
        Dropped,
        GoalFailed,
        GoalRejectedError,
        GoalTimeout,
        Idle,
        NotCharging,
        PortTaken,
        RequestError,
        RequestTimeout,
        SimulationEnded,
        SimulatorGone,
        SimulatorNotFound,
        Unreachable,
    )
    from hmrsim_zenoh.wire.options import SessionOptions

__all__ = [
    "ActionClient",
    "AsyncClient",
    "AsyncRobot",
    "BadOptions",
    "Client",
    "ClientClosed",
    "Commander",
    "Condition",
    "ConnectionDenied",
    "Deadlock",
    "Denied",
    "Dropped",
    "GoalFailed",
    "GoalHandle",
    "GoalRejectedError",
    "GoalTimeout",
    "Idle",
    "Lockstep",
    "NotCharging",
    "PortTaken",
    "RequestError",
    "RequestTimeout",
    "SessionOptions",
    "SimulationEnded",
    "SimulatorGone",
    "SimulatorNotFound",
    "Subscription",
    "Unreachable",
]

_HOMES = MappingProxyType(
    {
        "ActionClient": "client.action_client",
        "AsyncClient": "client.aio",
        "AsyncRobot": "client.aio",
        "Client": "client.client",
        "Commander": "client.commander",
        "Condition": "client.connection",
        "GoalHandle": "client.goal_handle",
        "Lockstep": "client.lockstep",
        "SessionOptions": "wire.options",
        "Subscription": "client.subscription",
    }
)
"""The modules of the exports that are not errors."""


def __getattr__(name: str) -> object:
    """Load an export on first access (PEP 562)."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES.get(name, 'errors')}"), name)
