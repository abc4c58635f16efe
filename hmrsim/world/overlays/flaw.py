"""What is wrong with an overlay, before its file and line are known."""

from __future__ import annotations


class OverlayFlaw(ValueError):
    """What an overlay says has no meaning; the text says why, and what would do."""


class UnknownPart(OverlayFlaw):
    """A table has no entry with a key; the text names both."""
