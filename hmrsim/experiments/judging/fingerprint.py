"""What tells that two replications are the same run, as neither leaves anything to chance."""

from __future__ import annotations

import hashlib
import json
import re
from typing import Final

_HEADER: Final = '"kind":"header"'
"""What the lines of a trace have that say the seed."""
_GOAL_ID: Final = re.compile(r"\b[0-9a-f]{32}\b")
"""Ids of goals depend on the seed, and on nothing else that differs between replications."""


def fingerprint_of(trace: str, *result: object) -> str:
    """Return a text that is the same for two runs if they differ in nothing but the seed and the ids of goals.

    It says whether a controller draws random numbers of its own: then its runs differ. Whether the simulator has drawn
    any has to be known besides, as runs may be equal by chance.

    Args:
        trace: What happened in it.
        result: What came of it, as JSON can have it.
    """
    ids: dict[str, str] = {}

    def numbered(match: re.Match[str]) -> str:
        return ids.setdefault(match[0], f"goal {len(ids)}")

    digest = hashlib.blake2b(digest_size=16)
    events = "\n".join(line for line in trace.splitlines() if _HEADER not in line)
    digest.update(_GOAL_ID.sub(numbered, events).encode())
    digest.update(json.dumps(result, sort_keys=True, default=str).encode())
    return digest.hexdigest()
