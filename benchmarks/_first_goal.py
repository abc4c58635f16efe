"""A controller's first goal: ``python -m benchmarks._first_goal ENDPOINT client|bare`` says when it is accepted.

*client* is hmrsim's own, *bare* nothing but Zenoh and JSON. Both are started along with the simulator, so that they
try until the server answers.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Final

_PATIENCE: Final = 300
"""Wall seconds to reach the simulator, and for an answer."""


def by_client(endpoint: str) -> None:
    """Send the goal with hmrsim's client."""
    from hmrsim.actions import registry  # noqa: PLC0415 - each way imports what it needs, which is part of its time
    from hmrsim.interfaces.nav2_msgs import NavigateToPose  # noqa: PLC0415
    from hmrsim_zenoh import Client  # noqa: PLC0415
    from hmrsim_zenoh.wire.options import SessionOptions  # noqa: PLC0415

    with Client(SessionOptions(connect=(endpoint,), timeout=_PATIENCE), acknowledge_timeout=_PATIENCE) as client:
        wall_e = client.action_client("wall_e", registry()["navigate_to_pose"])
        wall_e.send_goal(NavigateToPose.Goal()).wait_accepted()
        print("accepted", flush=True)


def by_bare_keys(endpoint: str) -> None:
    """Send the goal with a Zenoh client that retries fast, as docs/reference/keys.md describes the keys."""
    import zenoh  # noqa: PLC0415

    config = zenoh.Config()
    for key, value in {
        "mode": "client",
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": 1000 * _PATIENCE,
        "connect/retry": {"period_init_ms": 20, "period_max_ms": 200, "period_increase_factor": 1.05},
        "scouting/multicast/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config) as session:
        while not list(session.get("hmrsim/wall_e/navigate_to_pose/_action/send_goal", payload=b'{"goal": {}}')):
            time.sleep(0.01)
        print("accepted", flush=True)


if __name__ == "__main__":
    {"client": by_client, "bare": by_bare_keys}[sys.argv[2]](sys.argv[1])
