"""Gymnasium and PettingZoo environments for learning to dispatch orders; the extra ``gym`` installs both.

::

    import gymnasium
    import hmrsim_gym

    env = gymnasium.make("hmrsim/Dispatch-v0", world="warehouse_orders", horizon=1800)
    observation, info = env.reset(seed=1)

Importing this package registers the environment; ``gymnasium.make("hmrsim_gym:hmrsim/Dispatch-v0")`` imports it for
you. The simulation runs in the process of the learner.
"""

from __future__ import annotations

import importlib
from types import MappingProxyType
from typing import TYPE_CHECKING

from hmrsim.errors import MissingExtra

try:
    import gymnasium
except ImportError:
    raise MissingExtra("environments need gymnasium and pettingzoo; pip install 'hmrsim[gym]'") from None

if TYPE_CHECKING:
    from hmrsim_gym.dispatch_env import DispatchEnv
    from hmrsim_gym.observations import (
        FleetFeature,
        OrderFeature,
        RobotFeature,
        best,
        earliest_due,
        first_come,
        nearest,
    )
    from hmrsim_gym.parallel import ParallelDispatch, parallel_env

__all__ = [
    "DispatchEnv",
    "FleetFeature",
    "OrderFeature",
    "ParallelDispatch",
    "RobotFeature",
    "best",
    "earliest_due",
    "first_come",
    "nearest",
    "parallel_env",
]

_HOMES = MappingProxyType(
    {
        "DispatchEnv": "dispatch_env",
        "FleetFeature": "observations",
        "OrderFeature": "observations",
        "ParallelDispatch": "parallel",
        "RobotFeature": "observations",
        "best": "observations",
        "earliest_due": "observations",
        "first_come": "observations",
        "nearest": "observations",
        "parallel_env": "parallel",
    }
)

gymnasium.register("hmrsim/Dispatch-v0", f"{__name__}.dispatch_env:DispatchEnv")


def __getattr__(name: str) -> object:
    """Return an export, importing its module on first use; raise AttributeError if there is no such export."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
