"""A fault lasts until a lifecycle manager detects and clears it.

Asked in https://github.com/selfpatch/selfpatch_demos/issues/20.
"""

import json

from hmrsim.testing import Run, simulation


def heal(run: Run) -> list[str]:
    """Clear all active faults, as a lifecycle manager does, and return their names."""
    key = run.client.keys.world
    faults = json.loads(run.client.get(key("get_faults"), payload=b"{}"))["faults"]
    active = [fault["name"] for fault in faults if fault["active"]]
    for name in active:
        run.client.get(key("clear_fault"), payload=json.dumps({"name": name}).encode())
    return active


def test_the_robot_works_again_after_the_manager_clears_the_fault() -> None:
    """The goal succeeds only after the manager has cleared the fault."""
    broken = {"type": "breakdown", "robot": "mocha", "name": "controller_server_down", "at": 2}
    with simulation("cafe", changes={"faults.+": broken}) as run:
        run.client.sleep(10)

        assert heal(run) == ["controller_server_down"]

        run.commander("mocha").navigate_to("table_1")
        (ended,) = run.happened("fault_ended", fault="breakdown")
        assert ended.at == 10.0
