"""The coverage of whole runs."""

from __future__ import annotations

from bt_controller.coverage import TreeCoverage
from bt_controller.loading.trees import load
from bt_controller.running.runner import run_tree
from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation

TREE = "bt_controller.examples.hospital:mission"


def covered(**options):
    """Return what the hospital's mission has covered."""
    coverage = TreeCoverage()
    with simulation("hospital", **options) as run:
        run_tree(run.client, load(TREE), ["wall_e"], coverage=coverage)
    return {key.removeprefix(f"{TREE}/Mission of {{robot}}") for key in coverage.keys()}  # noqa: SIM118 - no mapping


def test_a_fault_shows_what_a_run_without_it_does_not():
    """The goal of the first attempt has its code, and the second attempt is ticked."""
    fault = {"type": "claw_misses", "robot": "wall_e", "at": 0, "duration": 60}
    more = covered(changes={"faults": [fault]}) - covered()
    steps = "/Deliver medicine/Fetch medicine/Get medicine"

    assert {f"{steps}/Pick up medicine:ABORTED/-4", f"{steps}/Pick up medicine again:RUNNING"} < more


def test_the_end_of_the_simulation_is_no_failure():
    """The trees did not fail: they had no time left."""
    keys = covered(settings=RunSettings(duration=5.0))

    assert {key.rpartition(":")[2] for key in keys} == {"RUNNING"}
