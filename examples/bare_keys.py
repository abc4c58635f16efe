"""Drive a robot with nothing but a Zenoh session: no library of hmrsim is needed.

Start ``hmrsim run scenario1`` first, then run ``python examples/bare_keys.py [ENDPOINT]``.
"""

import json
import sys
from collections.abc import Iterator

import zenoh

KEY = "hmrsim/wall_e/navigate_to_pose/_action/execute"


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Execute one goal, and print its acceptance and its result."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    with zenoh.open(config) as session:
        for answer in execute(session, {"pose": {"pose": {"position": {"x": 512, "y": 215}}}}):
            if "accepted" in answer:
                print("accepted", answer["accepted"])
            else:
                print("status", answer["status"], "error_code", answer["result"]["error_code"])


def execute(session: zenoh.Session, goal: dict) -> Iterator[dict]:
    """Yield the answers as they come: the acceptance and the result, or the rejection.

    By default Zenoh keeps the last one alone.
    """
    request, each = json.dumps({"goal": goal}), zenoh.ConsolidationMode.NONE
    answered = False
    for reply in session.get(KEY, payload=request, timeout=60, consolidation=each):
        if reply.ok is None:
            raise SystemExit(reply.err.payload.to_string())
        answered = True
        yield json.loads(reply.ok.payload.to_bytes())
    if not answered:
        raise SystemExit(f"no answer from {KEY}; start `hmrsim run scenario1`")


if __name__ == "__main__":
    main(*sys.argv[1:])
