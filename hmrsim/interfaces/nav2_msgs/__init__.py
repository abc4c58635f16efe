"""Nav2's actions, as of kilted, and their error codes.

A lower code is a deeper cause: a navigator passes on the planner's or the controller's instead of its own.
"""

from __future__ import annotations

from hmrsim.interfaces.nav2_msgs.behaviors import (
    BackUp,
    DockRobot,
    DriveOnHeading,
    Spin,
    UndockRobot,
    Wait,
)
from hmrsim.interfaces.nav2_msgs.messages import (
    Route,
    RouteEdge,
    RouteNode,
    TrackingFeedback,
    WaypointStatus,
)
from hmrsim.interfaces.nav2_msgs.navigation import (
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
)
from hmrsim.interfaces.nav2_msgs.planning import (
    ComputeAndTrackRoute,
    ComputePathThroughPoses,
    ComputePathToPose,
    ComputeRoute,
    SmoothPath,
)

__all__ = [
    "BackUp",
    "ComputeAndTrackRoute",
    "ComputePathThroughPoses",
    "ComputePathToPose",
    "ComputeRoute",
    "DockRobot",
    "DriveOnHeading",
    "FollowPath",
    "FollowWaypoints",
    "NavigateThroughPoses",
    "NavigateToPose",
    "Route",
    "RouteEdge",
    "RouteNode",
    "SmoothPath",
    "Spin",
    "TrackingFeedback",
    "UndockRobot",
    "Wait",
    "WaypointStatus",
]
