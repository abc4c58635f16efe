"""Varnish a part once: a program that is started for each part. The work in the booth is the robot's action wait."""

import sys

from hmrsim.actions import registry
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh import Client, Commander, GoalFailed, GoalRejectedError, GoalTimeout, RequestError, SessionOptions

TRIES = 12
PAUSE = 25.0
WORK = {"time": {"sec": 15}}


def main(client):
    """Drive to the booth, varnish the part, and drive home; return whether that is done."""
    return drive(client, "booth") and varnish(client) and drive(client, "home")


def varnish(client):
    """Varnish the part; an order without an answer is sent again under its id, which the robot carries out once."""
    actions = client.action_client("eve", registry()["wait"])
    attempt = 1
    for _ in range(TRIES):
        handle = actions.send_goal(WORK, goal_id=f"{attempt:032x}", adopt=True)
        try:
            handle.result(sim_timeout=30.0)
        except GoalTimeout:
            continue
        except (GoalRejectedError, RequestError):
            client.sleep(PAUSE)
            continue
        if handle.status is GoalStatus.SUCCEEDED:
            return True
        attempt += 1
        client.sleep(PAUSE)
    return False


def drive(client, place):
    """Drive to a place, and try again after a pause; return whether the robot has arrived."""
    for _ in range(TRIES):
        try:
            Commander(client, "eve").navigate_to(place)
        except (GoalFailed, GoalRejectedError, RequestError):
            client.sleep(PAUSE)
        else:
            return True
    return False


if __name__ == "__main__":
    with Client(SessionOptions.from_environment(), name="varnish") as connection:
        sys.exit(0 if main(connection) else 1)
