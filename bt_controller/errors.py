"""The errors of trees and of the controller."""

from __future__ import annotations

from hmrsim.errors import HmrsimError


class TreeError(HmrsimError):
    """There is no such tree, or it can't be built; the text names it and a remedy."""
