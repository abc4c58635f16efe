"""Fetch and deliver as a finite-state machine in plain Python, without a behavior tree.

Start ``hmrsim run scenario1 --clock lockstep`` first, then run ``python examples/state_machine.py [ENDPOINT]``.
"""

import sys
from collections.abc import Iterator
from contextlib import suppress

from hmrsim.actions import registry
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh import Client, GoalRejectedError, SessionOptions


def go(x: float, y: float) -> NavigateToPose.Goal:
    """Return the goal to drive to a point."""
    return NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=x, y=y))))


MACHINE: dict[str, tuple[str, Message, str, str]] = {
    "to_the_medicine": ("navigate_to_pose", go(512, 215), "picking_up", "failed"),
    "picking_up": ("pickup", Pickup.Goal(target_name="medicine"), "to_the_patient", "picking_up_again"),
    "picking_up_again": ("pickup", Pickup.Goal(target_name="medicine"), "to_the_patient", "failed"),
    "to_the_patient": ("navigate_to_pose", go(100, 180), "putting_down", "failed"),
    "putting_down": ("place", Place.Goal(attached_object_name="medicine"), "delivered", "failed"),
}
"""By state: the action, its goal, and the next state after success and after failure."""


def run(client: Client, robot: str, state: str) -> Iterator[tuple[float, str]]:
    """Yield each state, and when it was entered, until there is no way on."""
    yield client.now, state
    while state in MACHINE:
        action, goal, then, otherwise = MACHINE[state]
        sent = client.action_client(robot, registry()[action]).send_goal(goal)
        with suppress(GoalRejectedError):
            # A robot that has broken down rejects goals; that is a failure like others.
            sent.result()
        state = then if sent.status is GoalStatus.SUCCEEDED else otherwise
        yield client.now, state


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Bring the medicine to the other room."""
    with Client(SessionOptions(connect=(endpoint,)), name="state_machine") as client:
        for now, state in run(client, "wall_e", "to_the_medicine"):
            print(f"{now:.3f} {state}")


if __name__ == "__main__":
    main(*sys.argv[1:])
