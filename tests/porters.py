"""Controllers of a porter robot as users write them, and their checks in a small world."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

from hmrsim.actions import registry
from hmrsim.fault_search.campaign import Campaign, Options, limited
from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.schedule import Case
from hmrsim.trials.batches import Serial
from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.errors import GoalFailed, GoalRejectedError

HERE = Path(__file__).parent
TRIES = 3

WORLD: dict[str, Any] = {
    "name": "porters",
    "waypoints": {"home": [0, 0], "store": [10, 0], "shelf": [20, 0], "nook": [20, 10]},
    "lanes": [["home", "store"], ["store", "shelf"], ["shelf", "nook"]],
    "items": {"box": {"at": [10, 0.3]}, "crate": {"at": [20, 9.5]}},
    "robots": {
        "porter": {"at": "home", "components": {"claw": {}}},
        "other": {"at": "nook", "components": {"claw": {}}},
    },
}


def check_of(function: str, **said: Any):
    """Return the check of a porter."""
    file = {"world": WORLD, "controller": {"python": f"porters.py:{function}"}, **said}
    return check_at(CheckFile.model_validate(file), HERE)


def searched(check, executor=Serial, **options: Any):
    """Return the result of a search within this process."""
    with Evaluator(check, executor, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        check = limited(check, nominal)
        evaluator.take(check, nominal)
        return Campaign(check, evaluator, nominal, Options(**options)).run()


def careful(client):
    """Bring the box; retry failed steps after a pause, and report failure if that does not help."""
    porter = Commander(client, "porter")
    return all(tried(client, step) for step in steps(porter))


def sleepy(_client):
    """Do nothing until the run ends."""
    threading.Event().wait()


def needy(client):
    """Look up the position of the crate, and bring the box carefully."""
    scene = json.loads(client.get(client.keys.world("scene")))
    return bool({item["name"]: item for item in scene["items"]}["crate"]) and careful(client)


def hasty(client):
    """Make the other robot bring the crate; give up when anything fails."""
    other = Commander(client, "other")
    return done(lambda: other.pickup("crate")) and done(lambda: other.go_to_pose(20, 0))


def tired(client):
    """Bring the box, or drive to the berth regardless of failures if it can't be picked up."""
    porter = client.action_client("porter", registry()["dock_robot"])
    if done(lambda: Commander(client, "porter").pickup("box")):
        return True
    while porter.send_goal({"use_dock_id": True, "dock_id": "berth"}).result().error_code:
        pass
    return False


def vain(client):
    """Bring the box; retry failed steps at once, without end."""
    porter = Commander(client, "porter")
    for step in steps(porter):
        while not done(step):
            pass
    return True


def proud(client):
    """Bring the box, and report success regardless of the outcome."""
    porter = Commander(client, "porter")
    for step in steps(porter):
        done(step)
    return True


def crashing(client):
    """Bring the box without checking any result."""
    porter = Commander(client, "porter")
    for step in steps(porter):
        step()
    return True


def broken(client):
    """Raise an error at once."""
    raise RuntimeError(f"nothing works for {client}")


def steps(porter):
    """Return the steps in order."""
    return [
        lambda: porter.go_to_pose(10, 0),
        lambda: porter.pickup("box"),
        lambda: porter.go_to_pose(20, 0),
        lambda: porter.place("box"),
        lambda: porter.go_to_pose(0, 0),
    ]


def done(step):
    """Return whether a step succeeds."""
    try:
        step()
    except (GoalFailed, GoalRejectedError):
        return False
    return True


def tried(client, step):
    """Return whether a step succeeds within its retries."""
    for _ in range(TRIES):
        if done(step):
            return True
        client.sleep(30)
    return False
