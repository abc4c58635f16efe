"""Nav2's IsPathValid, which newer trees call ValidatePath."""

from __future__ import annotations

from bt_controller.node import Condition
from bt_controller.nodes import Family
from bt_controller.nodes.path_check import PathCheck


class IsPathValid(PathCheck, Condition):
    """Looks at it again each period where it is ticked each time."""

    next_look = Condition.next_look


FAMILY = Family("path_validity", {"IsPathValid": IsPathValid})
