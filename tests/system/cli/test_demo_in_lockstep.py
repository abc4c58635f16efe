"""The demo's mission in lockstep."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest


@pytest.fixture(scope="module")
def traces(tmp_path_factory):
    """Return the exit codes and the traces of two demos in lockstep."""
    paths = [tmp_path_factory.mktemp("demo") / "run.jsonl" for _ in range(2)]
    command = [sys.executable, "-m", "hmrsim.cli", "demo", "--clock", "lockstep", "--json", "--trace"]
    codes = [subprocess.run([*command, str(path)], capture_output=True, check=False).returncode for path in paths]
    return codes, [path.read_bytes() for path in paths]


def test_the_mission_is_the_same_each_time(traces):
    codes, (first, second) = traces

    assert [0, 0] == codes
    assert first == second


def test_the_mission_has_obstacles(traces):
    """Two robots avoid a corridor full of people, and others wait for doors and for each other."""
    lines = [json.loads(line) for line in traces[1][0].splitlines()]
    happened = [line for line in lines if "stamp" in line]

    assert ["visitors", "wet_floor"] == [line["name"] for line in happened if line["kind"] == "fault_began"]
    assert ["m_o", "nan_e"] == [line["robot"] for line in happened if line["kind"] == "rerouted"]
    assert (14, 18) == (
        sum("is opening" in line.get("why", "") for line in happened if line["kind"] == "waiting"),
        sum("for" in line for line in happened if line["kind"] == "waiting"),
    )
    assert 247 == lines[-1]["stamp"]["sec"]
