"""The keystore that the environment names, for commands of ``hmrsim security`` that are given none."""

from __future__ import annotations

import os
from pathlib import Path

from hmrsim.cli.exits import WrongUse
from hmrsim.cli.security_options import VARIABLE


def folder_of_environment() -> Path:
    """Return the folder that the environment names.

    Raises:
        WrongUse: It names none.
    """
    named = os.environ.get(VARIABLE, "")
    if not named:
        raise WrongUse(f"no keystore; name its folder DIR, or set {VARIABLE}=DIR")
    return Path(named)
