"""The ids of goals: 32 hex digits on the wire, made from names and numbers where clients choose none."""

from __future__ import annotations

import hashlib
import re
from typing import Final

ZERO_ID: Final = "0" * 32
"""The goal id that stands for "all goals" in a cancel request."""

_GOAL_ID = re.compile(r"[0-9a-f]{32}")
_MAX_SHOWN = 200


def parse_goal_id(text: str) -> str:
    """Return a goal id as 32 lower-case hex digits; hyphens are dropped.

    Any 16 bytes are an id: rclcpp's are not valid version-4 UUIDs either.

    Raises:
        ValueError: *text* has another form.
    """
    if _GOAL_ID.fullmatch(text):
        return text
    goal_id = text.replace("-", "").lower()
    if not _GOAL_ID.fullmatch(goal_id):
        raise ValueError(f"goal id {text[:_MAX_SHOWN]!r} is not a UUID of 32 hex digits")
    return goal_id


def made_goal_id(owner: str, number: int) -> str:
    """Return the id of the goal with this number, from 1, that *owner* sends: the same in every run."""
    return hashlib.blake2b(f"{owner}/{number}".encode(), digest_size=16).hexdigest()
