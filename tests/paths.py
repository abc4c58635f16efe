"""Paths of the files that tests read."""

from __future__ import annotations

import os
from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent
REFERENCES = ROOT.parent / "shared" / "data"
"""Files of other projects, on machines that have them."""


def nav2_files(suffix: str) -> list[Path]:
    """Return Nav2's files of a kind: those of the folder that NAV2_FILES names, such as a checkout, or `REFERENCES`."""
    named = os.environ.get("NAV2_FILES")
    folders = [Path(named)] if named else [REFERENCES / "bt", REFERENCES / "nav2"]
    return sorted(file for folder in folders for file in folder.rglob(f"*{suffix}"))
