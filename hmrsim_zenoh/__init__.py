"""The wire: what a real robot's controller would see of the simulated ones, over Zenoh.

What is exported here is the client; the simulator's side is wired by ``hmrsim.cli``.
"""

from hmrsim_zenoh.action_client import ActionClient
from hmrsim_zenoh.client import Client
from hmrsim_zenoh.commander import Commander
from hmrsim_zenoh.errors import (
    BadOptions,
    ClientClosed,
    GoalFailed,
    GoalRejectedError,
    GoalTimeout,
    NobodyThere,
    PortTaken,
    RequestError,
    RequestTimeout,
    SimulatorGone,
    Unreachable,
)
from hmrsim_zenoh.goal_handle import GoalHandle
from hmrsim_zenoh.session import SessionOptions
from hmrsim_zenoh.subscription import Subscription

__all__ = [
    "ActionClient",
    "BadOptions",
    "Client",
    "ClientClosed",
    "Commander",
    "GoalFailed",
    "GoalHandle",
    "GoalRejectedError",
    "GoalTimeout",
    "NobodyThere",
    "PortTaken",
    "RequestError",
    "RequestTimeout",
    "SessionOptions",
    "SimulatorGone",
    "Subscription",
    "Unreachable",
]
