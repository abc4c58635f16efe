"""Two robots patrol in turns; each is sent to its charger when its battery is low."""

import json

from hmrsim_zenoh import Commander, GoalFailed, GoalRejectedError, NotCharging, RequestError, Unreachable

ROBOTS = {"eve": ("gate_1", "corner_1", "charger_1"), "wall_e": ("gate_2", "corner_2", "charger_2")}
ROUNDS = 14
TRIES = 12
PAUSE = 25.0
LOW = 0.3


def patrol(client):
    """Let both robots walk their rounds; return whether they have, and are charged."""
    charge = {}
    for name in ROBOTS:
        client.subscribe(
            f"hmrsim/{name}/battery_state",
            lambda _key, payload: charge.update({name: json.loads(payload)["percentage"]}),  # noqa: B023 - the bug
            history=True,
        )
    robots = {name: Commander(client, name) for name in ROBOTS}
    for _ in range(ROUNDS):
        for leg in (1, 0):
            for name, places in ROBOTS.items():
                if charge.get(name, 1.0) < LOW and not recharge(client, robots[name], places[2]):
                    return False
                if not drive(client, robots[name], places[leg]):
                    return False
    return all(recharge(client, robots[name], places[2]) for name, places in ROBOTS.items())


def drive(client, robot, place):
    """Drive to a place, and try again after a pause; return whether the robot has arrived."""
    for _ in range(TRIES):
        try:
            robot.navigate_to(place)
        except (GoalFailed, GoalRejectedError):
            client.sleep(PAUSE)
        else:
            return True
    return False


def recharge(client, robot, dock):
    """Charge at a dock; return whether that worked."""
    for _ in range(TRIES):
        try:
            robot.dock(dock)
            robot.wait_until_charged(0.8)
        except (GoalFailed, GoalRejectedError, NotCharging, RequestError, Unreachable):
            client.sleep(PAUSE)
        else:
            return True
    return False
