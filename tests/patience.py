"""The time limit of tests that wait for something."""

from __future__ import annotations

from typing import Final

PATIENCE: Final = 300.0
"""Wall seconds after which a test that waits for a message, an event or a thread fails.

Each of these takes far less than ten seconds, and less than the limit even on a machine thirty times slower. Tests wait
for the end of a process without a limit, since pytest's timeout ends a test that waits in vain.
"""
