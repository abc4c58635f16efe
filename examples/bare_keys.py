"""Drive a robot with nothing but a Zenoh session: no library of hmrsim is needed.

Start ``hmrsim run scenario1`` first, then run ``python examples/bare_keys.py [ENDPOINT]``.
"""

import json
import sys

import zenoh


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Send one goal, wait for its result, print both."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    with zenoh.open(config) as session:
        action = "hmrsim/wall_e/navigate_to_pose/_action"
        goal = {"goal": {"pose": {"pose": {"position": {"x": 512, "y": 215}}}}}
        accepted = ask(session, f"{action}/send_goal", goal)
        print("accepted", accepted["accepted"])
        ended = ask(session, f"{action}/get_result", {"goal_id": accepted["goal_id"]})
        print("status", ended["status"], "error_code", ended["result"]["error_code"])


def ask(session: zenoh.Session, key: str, request: dict) -> dict:
    """Return the answer to one request; the simulator holds a result until the goal has ended."""
    for reply in session.get(key, payload=json.dumps(request), timeout=60):
        if reply.ok is None:
            raise SystemExit(reply.err.payload.to_string())
        return json.loads(reply.ok.payload.to_bytes())
    raise SystemExit(f"no answer from {key}; start `hmrsim run scenario1`")


if __name__ == "__main__":
    main(*sys.argv[1:])
