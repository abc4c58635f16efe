"""Follow a goal without blocking: a ticket for the goal, callbacks for what becomes of it, and a cancel.

Start ``hmrsim run scenario1`` first, then run ``python examples/feedback.py [ENDPOINT]``.
"""

import sys
import threading

from hmrsim.actions.navigate_to_pose import ACTION
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim_zenoh import Client, SessionOptions


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Drive until a hundred pixels are behind, then cancel."""
    far_enough = threading.Event()
    first = []

    def look(feedback: NavigateToPose.Feedback) -> None:
        first.append(feedback.distance_remaining)
        if feedback.distance_remaining < first[0] - 100:
            far_enough.set()

    with Client(SessionOptions(connect=(endpoint,))) as client:
        target = PoseStamped(pose=Pose(position=Point(x=512, y=215)))
        goal = client.action_client("wall_e", ACTION).send_goal(NavigateToPose.Goal(pose=target), on_feedback=look)
        goal.wait_accepted(timeout=10)
        far_enough.wait(timeout=30)
        goal.cancel()
        result = goal.result(timeout=10)
        print(goal.status.name, result.error_msg)


if __name__ == "__main__":
    main(*sys.argv[1:])
