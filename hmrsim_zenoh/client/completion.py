"""What the simulator that runs knows, for shells that complete names; nothing when nobody answers at once."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import HmrsimError
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    import argparse

_PATIENCE: Final = 0.3
"""Wall seconds that somebody waits for a completion."""


def running(args: argparse.Namespace) -> dict[str, Any]:
    """Return what the simulator says of itself; an empty mapping when none answers at once."""
    try:
        options = replace(session_options(args), timeout=_PATIENCE)
        with Client(options) as client:
            client.wait_for_simulator(_PATIENCE)
            return client.info(_PATIENCE)
    except (HmrsimError, AttributeError):
        # Without session options there is no simulator to ask.
        return {}


def robots(parsed_args: argparse.Namespace, **_unused: object) -> list[str]:
    """Return the names of the robots."""
    return [robot["name"] for robot in running(parsed_args).get("robots", ())]
