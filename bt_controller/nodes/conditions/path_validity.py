"""Nav2's IsPathValid, which newer trees call ValidatePath."""

from __future__ import annotations

from bt_controller.nodes import Family
from bt_controller.nodes.path_check import PathCheck


class IsPathValid(PathCheck):
    """Succeeds if a path is open: if it begins no lane that was open at some time and is not now.

    Lanes are closed by faults, by doors, or because something lies on them. Who is on a closed lane may leave it. A
    path without poses is not valid. Of a path that is not, ``collision_poses`` has the pose from which it is not
    open; all of them with ``stop_at_first_collision="false"``.
    """


FAMILY = Family("path_validity", {"IsPathValid": IsPathValid})
