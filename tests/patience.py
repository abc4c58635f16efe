"""How long tests wait for what must happen."""

from __future__ import annotations

from typing import Final

PATIENCE: Final = 300.0
"""Wall seconds after which a test that waits for a message, an event or a thread fails.

Each of them takes far less than ten seconds, on a machine that is thirty times slower than that less than this. The end
of a process is waited for without a limit of its own: pytest's timeout ends a test that does so in vain.
"""
