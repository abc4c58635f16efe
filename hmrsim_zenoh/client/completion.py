"""Names for shell completion, from the running simulator; none when no simulator answers at once."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any, Final

from hmrsim.errors import HmrsimError
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.wire.options import session_options

_PATIENCE: Final = 0.3
"""Wall seconds that a shell completion may take."""


def running(args: argparse.Namespace) -> dict[str, Any]:
    """Return the simulator's description; an empty mapping when none answers at once."""
    try:
        options = replace(session_options(args, "viewer"), timeout=_PATIENCE)
        with Client(options) as client:
            client.wait_for_simulator(_PATIENCE)
            return client.info(_PATIENCE)
    except (HmrsimError, AttributeError):
        # Without session options there is no simulator to ask.
        return {}


def robots(parsed_args: argparse.Namespace, **_unused: object) -> list[str]:
    """Return the names of the robots."""
    return [robot["name"] for robot in running(parsed_args).get("robots", ())]
