"""Fetch and deliver with the blocking commander, in the manner of nav2_simple_commander.

Start ``hmrsim run scenario1`` first, then run ``python examples/commander.py [ENDPOINT]``.
"""

import sys

from hmrsim_zenoh import Client, Commander, GoalFailed, SessionOptions


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Bring the medicine to the other room."""
    with Client(SessionOptions(connect=(endpoint,))) as client:
        wall_e = Commander(client, "wall_e")
        wall_e.go_to_pose(512, 215)
        wall_e.pickup("medicine")
        wall_e.go_to_pose(100, 180)
        wall_e.place("medicine")
        print("delivered")
        try:
            wall_e.pickup("anvil")
        except GoalFailed as failure:
            print(failure.status.name, failure.result.error_code.val)


if __name__ == "__main__":
    main(*sys.argv[1:])
