"""Docking fails, and the robot goes to another charger.

Asked in https://github.com/equinor/isar/issues/31 and https://github.com/equinor/flotilla/issues/716, where a mission
could not be tested for failed docking without the robot.
"""

from hmrsim.testing import simulation
from hmrsim_zenoh import Commander, GoalFailed

BROKEN = {"type": "dock_out_of_order", "dock": "charger_1", "at": 0, "duration": 600}
FREE = {"robots.mocha.at": "table_1", "robots.latte.at": "hall"}
"""Start the other robots elsewhere, so that the chargers are free."""


def charge(robot: Commander, chargers: list[str]) -> str:
    """Dock at the first charger that works and return its name."""
    for charger in chargers:
        try:
            robot.dock(charger)
        except GoalFailed as failure:
            print(failure)
        else:
            return charger
    return ""


def test_the_robot_docks_at_the_other_charger() -> None:
    """The first attempt ends with Nav2's error code."""
    with simulation("cafe", changes={"faults.+": BROKEN, **FREE}) as run:
        chai = run.commander("chai")

        assert charge(chai, ["charger_1", "charger_2"]) == "charger_2"

        (failed,) = run.goals("chai", action="dock_robot", status="ABORTED")
        assert failed.result.error_code in {904, 905}
