"""Bring a box to the bench, with a recovery for steps that fail three times."""

import contextlib
import json

from hmrsim_zenoh import Commander, GoalFailed, GoalRejectedError

RETRIES = 3


def fetch(client):
    """Bring the box to the bench, however long that takes."""
    eve = Commander(client, "eve")
    failures = 0
    while not delivered(client):
        if failures >= RETRIES:
            make_room(client, eve)
            continue
        try:
            next_step(client, eve)
        except (GoalFailed, GoalRejectedError):
            failures += 1
            client.sleep(10)
        else:
            failures = 0


def look(client):
    """Return where the box is, and who carries it."""
    scene = json.loads(client.get("hmrsim/_world/scene"))
    box = next(item for item in scene["items"] if item["name"] == "box")
    return box["at"], box["carrier"]


def delivered(client):
    """Return whether the box lies on the bench."""
    (x, y), carrier = look(client)
    return not carrier and (x - 10) ** 2 + y**2 < 0.8**2


def next_step(client, robot):
    """Take the box from where it lies to where it belongs."""
    (x, y), carrier = look(client)
    if not carrier:
        robot.go_to_pose(x, 0 if abs(y) < 1 else y)
        robot.pickup("box")
    robot.navigate_to("bench")
    robot.place("box")


def make_room(client, robot):
    """Drive out of the way of others for a while."""
    with contextlib.suppress(GoalFailed, GoalRejectedError):
        robot.navigate_to("bay")
    client.sleep(30)
