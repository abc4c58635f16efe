"""Where files are that tests read."""

from __future__ import annotations

from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent
REFERENCES = ROOT.parent / "shared" / "data"
"""Files of others, on machines that have them."""
