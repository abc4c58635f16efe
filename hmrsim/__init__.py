"""A mission-level simulator of robots: a world and commands go in, events come out, and it does no I/O.

A Python program reads a world, gives it to a `Simulator` with its `RunSettings` and its sinks, submits `commands` and
lets time pass; no network is needed for that. The commands of ``hmrsim``, and the servers of ``hmrsim_zenoh``, do the
same. What is exported is loaded when it is first used: ``hmrsim --help`` needs none of it.
"""

from __future__ import annotations

import importlib
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim import errors, events
    from hmrsim.protocol import commands
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world import World
    from hmrsim.world_checks import load_world

__all__ = [
    "CONTRACT",
    "RunSettings",
    "Simulator",
    "World",
    "__version__",
    "commands",
    "errors",
    "events",
    "load_world",
]

__version__ = "0.1.0"

CONTRACT = 1
"""Version of the public interface: keys, messages, traces."""

_HOMES = MappingProxyType(
    {
        "RunSettings": "hmrsim.settings.run",
        "Simulator": "hmrsim.simulation.simulator",
        "World": "hmrsim.world",
        "commands": "hmrsim.protocol.commands",
        "errors": "hmrsim.errors",
        "events": "hmrsim.events",
        "load_world": "hmrsim.world_checks",
    }
)
"""The modules of the names that are loaded on first use; some of the names are modules."""


def __getattr__(name: str) -> object:
    """Load an exported name on first use (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(_HOMES[name])
    return module if module.__name__.endswith(f".{name}") else getattr(module, name)
