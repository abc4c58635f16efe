"""Nav2's ValidatePath, which older trees call IsPathValid."""

from __future__ import annotations

from bt_controller.nodes import Family
from bt_controller.nodes.path_check import PathCheck


class ValidatePath(PathCheck):
    """Succeeds if a path is open: same as ``IsPathValid``, under its name in newer trees."""


FAMILY = Family("path_validation", {"ValidatePath": ValidatePath})
