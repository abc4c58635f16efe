"""A logged run is replayed without its controller.

Asked in https://github.com/splintered-reality/py_trees/issues/419.
"""

from pathlib import Path

from hmrsim.cli import main
from hmrsim.testing import simulation


def test_a_replay_gives_the_same_trace(tmp_path: Path) -> None:
    """The trace of one run is enough to replay it any number of times."""
    with simulation("hospital", tree="bt_controller.examples.hospital:mission") as run:
        run.to_the_end()
        trace = run.trace
    file = tmp_path / "mission.jsonl"
    file.write_text(trace)

    assert main(["replay", str(file)]) == 0


def test_a_replay_detects_a_difference(tmp_path: Path) -> None:
    """The replay of a changed trace fails."""
    with simulation("cafe") as run:
        run.commander("mocha").navigate_to("table_1")
        trace = run.trace
    file = tmp_path / "mission.jsonl"
    file.write_text(trace.replace('"x":6.0,"y":6.0', '"x":6.0,"y":3.0', 1))

    assert main(["replay", str(file)]) == 1
