"""A robot is lost: its pose estimate is wrong, and it reports that it has arrived.

Asked in https://github.com/equinor/flotilla/issues/2334, where a robot in the field reports that it is at home.
"""

import json

from hmrsim.testing import simulation

JUMP = {"type": "localisation_jump", "robot": "mocha", "dx": 3, "dy": 0, "at": 1}


def test_odometry_differs_from_the_true_pose() -> None:
    """Odometry is off by 3 m, and the test knows the true pose."""
    with simulation("cafe", changes={"faults.+": JUMP}) as run:
        run.client.sleep(2)
        said = json.loads(run.client.get("hmrsim/mocha/odom"))["pose"]["pose"]["position"]

        assert (said["x"], said["y"]) == (9.0, 1.0)
        assert run.position("mocha") == (6.0, 1.0)
