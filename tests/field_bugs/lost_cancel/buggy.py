"""Inspect the vault with eve, or with wall_e if she takes too long."""

import contextlib

from hmrsim.actions import registry
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh import GoalRejectedError, GoalTimeout, RequestError

POSES = {"west": 0.0, "vault": 20.0, "east": 36.0}
DEADLINE = 30.0
TRIES = 12
PAUSE = 25.0


def inspect(client):
    """Send eve to the vault, and wall_e after the deadline; return whether one of them was there."""
    if not (go(client, "wall_e", "east") and go(client, "eve", "west")):
        return False
    handle = send(client, "eve", "vault")
    try:
        handle.result(sim_timeout=DEADLINE)
    except GoalTimeout:
        handle.cancel()
    except (GoalRejectedError, RequestError):
        pass
    if handle.status is GoalStatus.SUCCEEDED:
        return go(client, "eve", "west")
    return go(client, "wall_e", "vault") and go(client, "wall_e", "east")


def send(client, robot, place):
    """Send a robot to a place, and return the handle of the goal."""
    pose = {"pose": {"pose": {"position": {"x": POSES[place], "y": 0.0}}}}
    return client.action_client(robot, registry()["navigate_to_pose"]).send_goal(pose)


def go(client, robot, place):
    """Send a robot to a place until it is there; return whether it is."""
    for _ in range(TRIES):
        handle = send(client, robot, place)
        with contextlib.suppress(GoalRejectedError, RequestError):
            handle.result()
        if handle.status is GoalStatus.SUCCEEDED:
            return True
        client.sleep(PAUSE)
    return False
