"""Follow a goal by callbacks, and cancel it from one: a ticket tells what becomes of the goal.

Start ``hmrsim run scenario1`` first, then run ``python examples/feedback.py [ENDPOINT]``.
"""

import sys

from hmrsim.actions.navigate_to_pose import ACTION
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim_zenoh import Client, SessionOptions


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Drive until a hundred pixels are behind, then cancel."""
    remaining = []

    def look(feedback: NavigateToPose.Feedback) -> None:
        remaining.append(feedback.distance_remaining)
        if remaining[-1] < remaining[0] - 100:
            goal.cancel()

    with Client(SessionOptions(connect=(endpoint,))) as client:
        target = PoseStamped(pose=Pose(position=Point(x=512, y=215)))
        goal = client.action_client("wall_e", ACTION).send_goal(NavigateToPose.Goal(pose=target), on_feedback=look)
        result = goal.result(timeout=40)
        print(goal.status.name, result.error_msg)


if __name__ == "__main__":
    main(*sys.argv[1:])
