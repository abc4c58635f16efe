"""Fetch a folder from behind a fire door, which is kept closed except when a robot passes."""

import json

from hmrsim_zenoh import Commander, GoalFailed, GoalRejectedError, RequestError, RequestTimeout, Unreachable

PAUSE = 25.0


class FireDoor:
    """The door, and whether it is open."""

    def __init__(self, client, name):
        """Control the door of this name."""
        self._client = client
        self._name = name
        self._open = False

    def open(self):
        """Open the door, if it is not open yet."""
        if not self._open:
            self._request("open")
            self._open = True

    def close(self):
        """Close the door."""
        self._request("closed")
        self._open = False

    def _request(self, state):
        """Return whether the door does what it is asked for."""
        request = json.dumps({"name": self._name, "state": state}).encode()
        try:
            answer = json.loads(self._client.get("hmrsim/_world/set_door_state", payload=request))
        except (RequestError, RequestTimeout, Unreachable):
            return False
        return answer["result"]["result"] == 1


def fetch(client):
    """Bring the folder to the office, however long that takes."""
    eve = Commander(client, "eve")
    door = FireDoor(client, "fire_door")
    while not delivered(client):
        try:
            next_step(client, eve, door)
        except (GoalFailed, GoalRejectedError):
            client.sleep(PAUSE)
    door.close()


def look(client):
    """Return where the folder is, and who carries it."""
    scene = json.loads(client.get("hmrsim/_world/scene"))
    folder = next(item for item in scene["items"] if item["name"] == "folder")
    return folder["at"], folder["carrier"]


def delivered(client):
    """Return whether the folder lies in the office."""
    (x, y), carrier = look(client)
    return not carrier and x**2 + y**2 < 0.8**2


def next_step(client, robot, door):
    """Take the folder from where it lies to where it belongs."""
    (x, _), carrier = look(client)
    if not carrier:
        door.open()
        client.sleep(3)
        robot.go_to_pose(x, 0)
        robot.pickup("folder")
    door.open()
    client.sleep(3)
    robot.navigate_to("office")
    robot.place("folder")
