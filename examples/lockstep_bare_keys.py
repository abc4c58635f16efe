"""Control two robots in virtual time with nothing but a Zenoh session: each run is the same, and takes no time.

Start ``hmrsim run hospital --clock lockstep`` first, then run ``python examples/lockstep_bare_keys.py [ENDPOINT]``.
"""

import json
import sys

import zenoh

NAME = "nurse_station"
PLACES = {"pharmacy": (6.0, 18.0), "lab": (15.0, 18.0), "ward_a": (22.6, 17.5)}
ROUNDS = {"wall_e": ["pharmacy", "ward_a"], "eve": ["ward_a", "lab", "pharmacy"]}


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Send each robot to one place after the other; print when it arrives, in simulated seconds."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    with zenoh.open(config) as session:
        # The token shows that the participant is alive: when it is gone, the others need not wait.
        token = session.liveliness().declare_token(f"hmrsim/_participant/{NAME}")
        epoch = ask(session, "join", {"name": NAME})["epoch"]
        ways = {robot: list(places) for robot, places in ROUNDS.items()}
        commands = [go(robot, ways) for robot in ways]
        while commands or any(ways.values()):
            request = {"participant": NAME, "epoch": epoch, "until": None, "wake": ["result"], "commands": commands}
            granted = ask(session, "advance", request)
            epoch, commands = granted["epoch"], []
            for event in granted["events"]:
                robot = event["robot"]
                print(f"{granted['now']:9.3f} s  {robot} has reached {ways[robot].pop(0)}, status {event['status']}")
                if ways[robot]:
                    commands.append(go(robot, ways))
        ask(session, "leave", {"participant": NAME})
        token.undeclare()


def go(robot: str, ways: dict) -> dict:
    """Return the command that sends a robot to the next of its places."""
    x, y = PLACES[ways[robot][0]]
    return {"robot": robot, "action": "navigate_to_pose", "goal": {"pose": {"pose": {"position": {"x": x, "y": y}}}}}


def ask(session: zenoh.Session, what: str, request: dict) -> dict:
    """Return the answer to a request about time; an advance is held until time has moved."""
    for reply in session.get(f"hmrsim/_world/time/{what}", payload=json.dumps(request), timeout=1e6):
        if reply.ok is None:
            raise SystemExit(reply.err.payload.to_string())
        return json.loads(reply.ok.payload.to_bytes())
    raise SystemExit("no simulator answers; start `hmrsim run hospital --clock lockstep`")


if __name__ == "__main__":
    main(*sys.argv[1:])
