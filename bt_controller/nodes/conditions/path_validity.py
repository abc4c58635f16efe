"""Nav2's IsPathValid, which newer trees call ValidatePath."""

from __future__ import annotations

from bt_controller.nodes import Family
from bt_controller.nodes.path_check import PathCheck


class IsPathValid(PathCheck):
    """Succeeds if a path is open: if it enters no lane that was open earlier and is not open now.

    Faults, doors and obstacles close lanes. A robot on a closed lane may leave it. A path without poses is not valid.
    For an invalid path, ``collision_poses`` has the pose after which it is closed, or all such poses with
    ``stop_at_first_collision="false"``.
    """


FAMILY = Family("path_validity", {"IsPathValid": IsPathValid})
