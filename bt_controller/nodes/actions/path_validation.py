"""Nav2's ValidatePath."""

from __future__ import annotations

from bt_controller.nodes import Family
from bt_controller.nodes.path_check import PathCheck

FAMILY = Family("path_validation", {"ValidatePath": PathCheck})
