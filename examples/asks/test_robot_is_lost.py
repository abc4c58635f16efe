"""A robot loses its way: it believes to be where it is not, and says that it has arrived.

Asked in https://github.com/equinor/flotilla/issues/2334: there, a robot in the field reports to be at home.
"""

import json

from hmrsim.testing import simulation

JUMP = {"type": "localisation_jump", "robot": "mocha", "dx": 3, "dy": 0, "at": 1}


def test_what_the_robot_says_is_not_where_it_is() -> None:
    """Odometry is off by three metres; the truth is known to the test."""
    with simulation("cafe", changes={"faults.+": JUMP}) as run:
        run.client.sleep(2)
        said = json.loads(run.client.get("hmrsim/mocha/odom"))["pose"]["pose"]["position"]

        assert (said["x"], said["y"]) == (9.0, 1.0)
        assert run.position("mocha") == (6.0, 1.0)
