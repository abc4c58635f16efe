"""The size of payloads; clients know it, too, and need none of the settings of a run."""

from __future__ import annotations

from typing import Final

MAX_PAYLOAD: Final = 1024 * 1024
"""Default maximum size of a payload, in bytes."""
