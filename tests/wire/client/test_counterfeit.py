"""Tools that meet a counterfeit simulator print one clear line, no traceback and no escape sequence."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from random import Random

import pytest

import bt_controller.cli
from hmrsim.cli import main
from tests.counterfeit import Counterfeit
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.simulation import SMALL_WORLD
from tests.torture.mutation import with_other_value

GOAL = "'{time: {nanosec: 100000000}}'"
TREE = '<root BTCPP_format="4"><BehaviorTree ID="A"><Wait wait_duration="0.1"/></BehaviorTree></root>'

TOOLS = [
    "hmrsim action list",
    "hmrsim action list --json",
    "hmrsim action info /wall_e/wait",
    f"hmrsim action send-goal /wall_e/wait {GOAL} --feedback",
    "hmrsim topic list",
    "hmrsim topic echo /wall_e/odom --once",
    "hmrsim topic echo /_world/clock --once --json",
    "hmrsim service list",
    "hmrsim service call /_world/get_entities",
    "hmrsim service call /_world/get_faults --json",
    "hmrsim doctor",
    "hmrsim doctor --json",
    "hmrsim record run.mcap --duration 0.2",
    "bt-controller run tree.xml --robot wall_e --quiet",
]

GARBAGE = {
    "nothing": b"",
    "no text": b"\xff\xfe\x00",
    "null": b"null",
    "a list": b"[]",
    "a number": b"7",
    "an escape sequence": b'"\\u001b[2J"',
    "an empty object": b"{}",
    "deep": b"[" * 100_000,
    "deep objects": b'{"a":' * 100_000,
    "large numbers": b'{"a":1e400,"robots":' + b"9" * 5_000 + b"}",
    "not a number": b'{"now":NaN,"lag":NaN,"robots":[{"name":NaN}]}',
    "names that are numbers": b'{"robots":[{"name":1,"actions":[2]}],"aliases":[]}',
    "names that move the cursor": b'{"robots":[{"name":"\\u001b[2J","actions":["\\u001b[31m"]}]}',
    "participants that are numbers": b'{"now":"1","participants":[1],"waiting_for":[null]}',
}

CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


@pytest.fixture(scope="module")
def counterfeit():
    with served_world() as real, Counterfeit(real, SMALL_WORLD["robots"]) as fake:
        yield fake


@pytest.fixture
def tried(counterfeit, tmp_path, monkeypatch, capsys):
    """Return the function that runs a tool against a counterfeit that changes its answers."""
    monkeypatch.chdir(tmp_path)
    Path("tree.xml").write_text(TREE)

    def run(line: str, change, timeout: str = "1") -> tuple[int, str]:
        counterfeit.change = change
        program, *words = shlex.split(line)
        words += ["--connect", counterfeit.options.connect[0], "--timeout", timeout]
        code = (main if program == "hmrsim" else bt_controller.cli.main)(words)
        told = capsys.readouterr()
        return code, told.out + told.err

    return run


@pytest.mark.parametrize("tool", TOOLS)
def test_a_counterfeit_that_changes_nothing_is_as_good_as_the_real_one(tried, tool):
    """This is the control for the other tests."""
    code, _ = tried(tool, lambda _key, payload: payload, str(PATIENCE))

    # The doctor reports a busy machine as a problem.
    assert code == 0 or (code == 1 and "doctor" in tool)


@pytest.mark.uncovered
@pytest.mark.parametrize("tool", TOOLS)
def test_garbage_is_reported_in_one_line(tried, tool):
    for name, garbage in GARBAGE.items():
        code, told = tried(tool, lambda _key, _payload, garbage=garbage: garbage)

        assert code in (0, 1, 2, 3), (name, told)
        assert told.strip() or code == 0, name
        assert "Traceback" not in told, (name, told)
        assert not CONTROL.search(told), (name, told)


@pytest.mark.uncovered
@pytest.mark.parametrize("seed", range(20))
def test_answers_with_values_of_other_types_do_no_harm(tried, seed):
    random = Random(seed)

    def change(_key: str, payload: bytes) -> bytes:
        return json.dumps(with_other_value(json.loads(payload or b"0"), random)).encode()

    code, told = tried(random.choice(TOOLS), change)

    assert code in (0, 1, 2, 3)
    assert "Traceback" not in told
    assert not CONTROL.search(told)
