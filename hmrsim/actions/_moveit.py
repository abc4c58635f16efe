"""What MoveIt's actions have in common: the codes that the dispatcher needs."""

from __future__ import annotations

from hmrsim.actions import Codes
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes

CODES = Codes(
    canceled=MoveItErrorCodes.PREEMPTED,
    preempted=MoveItErrorCodes.PREEMPTED,
    rejected=MoveItErrorCodes.FAILURE,
    unknown=MoveItErrorCodes.FAILURE,
    busy=MoveItErrorCodes.INVALID_ROBOT_STATE,
)
