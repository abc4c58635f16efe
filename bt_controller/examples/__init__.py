"""Example trees to start from.

`bt-controller run bt_controller.examples:go_to_pose` runs the first; the demo runs `hospital`.
"""

from __future__ import annotations

from bt_controller.examples.scenario2 import go_to_pose

__all__ = ["go_to_pose"]
