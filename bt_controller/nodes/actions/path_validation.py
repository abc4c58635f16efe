"""Nav2's ValidatePath, which older trees call IsPathValid."""

from __future__ import annotations

from bt_controller.nodes import Family
from bt_controller.nodes.path_check import PathCheck


class ValidatePath(PathCheck):
    """Succeeds if a path is open: is an ``IsPathValid``, as newer trees call it."""


FAMILY = Family("path_validation", {"ValidatePath": ValidatePath})
