"""Brings the parcel to the ward; ``--bug`` handles failed goals, and not rejected ones."""

import os
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "clients"))

from driving import ATTEMPTS, PAUSE, item_of

from hmrsim_zenoh import Client, Commander, GoalFailed, GoalRejectedError, SessionOptions


def main(*, bug: bool) -> int:
    expected = (GoalFailed,) if bug else (GoalFailed, GoalRejectedError)  # the bug: there are other errors
    with Client(SessionOptions(connect=(os.environ["HMRSIM_CONNECT"],)), name="porter") as client:
        wall_e = Commander(client, "wall_e")
        for _ in range(ATTEMPTS):
            try:
                bring(client, wall_e)
            except expected:
                client.sleep(PAUSE)
            else:
                return 0
    return 1


def bring(client: Client, wall_e: Commander) -> None:
    found = item_of(client, "parcel")
    if found["carrier"] is None:
        wall_e.go_to_pose(*found["at"])
        wall_e.pickup("parcel")
    wall_e.go_to_pose(18.0, 0.0)
    wall_e.place("parcel")


if __name__ == "__main__":
    sys.exit(main(bug="--bug" in sys.argv))
