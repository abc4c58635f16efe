"""Brings the parcel to the ward; ``--bug`` catches every error and tries again at once, forever."""

import os
import sys
from contextlib import suppress
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "clients"))

from driving import Driver

from hmrsim_zenoh import Client, Commander, SessionOptions


def main(*, bug: bool) -> int:
    with Client(SessionOptions(connect=(os.environ["HMRSIM_CONNECT"],)), name="porter") as client:
        if not bug:
            return 0 if Driver(client, "wall_e").bring("parcel", "ward") else 1
        wall_e = Commander(client, "wall_e")
        steps = (
            lambda: wall_e.go_to_pose(6.0, 0.0),
            lambda: wall_e.pickup("parcel"),
            lambda: wall_e.go_to_pose(18.0, 0.0),
            lambda: wall_e.place("parcel"),
        )
        for step in steps:
            done = False
            while not done:
                with suppress(Exception):  # the bug: whatever it is, and without a pause
                    step()
                    done = True
    return 0


if __name__ == "__main__":
    sys.exit(main(bug="--bug" in sys.argv))
