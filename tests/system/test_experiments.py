"""Experiments as users run them, with real workers, commands and failures."""

from __future__ import annotations

import json
import os
import sqlite3
import sys
from contextlib import closing
from typing import TYPE_CHECKING, Any

import pytest
import yaml

from tests import processes
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.system

CONTROLLERS = """\
import ctypes
import os
import signal
import time

from hmrsim_zenoh import Client, Commander, SessionOptions


def go(client, x=10.0):
    Commander(client, client.info()["robots"][0]["name"]).go_to_pose(float(x), 0.0)


def dies(client):
    ctypes.string_at(0)


def hangs(client):
    while True:
        try:
            time.sleep(1)
        except BaseException:
            pass


def leaks(client):
    kept = []
    while True:
        kept.append(bytearray(10**8))


def prints(client):
    for _ in range(20000):
        print("x" * 1000)
    go(client)


if __name__ == "__main__":
    with Client(SessionOptions(connect=(os.environ["HMRSIM_CONNECT"],))) as client:
        go(client)
    print("seed", os.environ["HMRSIM_SEED"], "run", os.environ["HMRSIM_RUN"], os.environ["GREETING"])
"""

BASE: dict[str, Any] = {
    "name": "pace",
    "world": "zoo/crossing",
    "overlay": {"lanes.*.speed_factor": {"uniform": {"low": 0.3, "high": 1}}},
    "limits": {"simulated": 600, "wall": PATIENCE},
    "measures": {"time": "end.at"},
}


@pytest.fixture
def experiment(tmp_path):
    """Run an experiment; return its rows."""
    (tmp_path / "controllers.py").write_text(CONTROLLERS, encoding="utf-8")

    def run(folder: str, *options: str, **changes: Any) -> list[dict[str, Any]]:
        (tmp_path / "e.yaml").write_text(yaml.safe_dump({**BASE, **changes}, sort_keys=False), encoding="utf-8")
        process = processes.start("hmrsim", "experiment", "run", "e.yaml", "-o", folder, *options, cwd=tmp_path)
        _, err = process.communicate()
        assert process.returncode == 0, err
        return rows(tmp_path / folder)

    return run


def rows(folder: Path) -> list[dict[str, Any]]:
    """Return all rows without their wall times."""
    with closing(sqlite3.connect(folder / "results.sqlite")) as database:
        database.row_factory = sqlite3.Row
        found = [dict(row) for row in database.execute("SELECT * FROM runs ORDER BY number")]
    return [{name: value for name, value in row.items() if name != "wall"} for row in found]


def test_results_are_equal_with_one_worker_two_and_dask(experiment):
    changes = {"treatments": {"a": {"python": "controllers.py:go"}, "b": {"python": "controllers.py:go(x=5)"}}}
    one = experiment("one", "-j", "1", replications=6, **changes)

    assert 12 == len(one)
    assert all("succeeded" == row["ending"] for row in one)
    assert one == experiment("two", "--executor", "pool:2", replications=6, **changes)
    assert one == experiment("dask", "--executor", "dask", "-j", "2", replications=6, **changes)


def test_a_run_that_crashes_hangs_leaks_or_floods_affects_no_other(experiment):
    treatments = {name: {"python": f"controllers.py:{name}"} for name in ("go", "dies", "leaks", "prints")}
    limits = {**BASE["limits"], "memory": "500 MB"}
    found = experiment("bad", "-j", "2", treatments=treatments, limits=limits, replications=2)
    # One second is short for a busy machine, but not for what never ends.
    hangs = {"hangs": {"python": "controllers.py:hangs"}}
    found += experiment("hangs", "-j", "2", treatments=hangs, limits={**limits, "wall": 1}, replications=1)

    endings = {name: {row["ending"] for row in found if row["treatment"] == name} for name in (*treatments, *hangs)}
    assert {
        "go": {"succeeded"},
        "dies": {"died"},
        "hangs": {"hung"},
        "leaks": {"out_of_memory"},
        "prints": {"succeeded"},
    } == endings
    assert all(row["cause"] for row in found if row["ending"] != "succeeded")
    assert all(2000 >= len(row["output"]) for row in found)


def test_any_command_is_a_controller(experiment):
    treatments = {
        "script": {"command": f"{sys.executable} controllers.py", "set": {"GREETING": "hello"}},
        "same": {"python": "controllers.py:go"},
        "killed": {"command": [sys.executable, "-c", "import os; print('oh no', flush=True); os.kill(os.getpid(), 9)"]},
        "no": {"command": [sys.executable, "-c", "raise SystemExit(1)"]},
        "none": {"command": "no_such_program"},
    }
    found = experiment("commands", treatments=treatments)
    child_of_its_own = "import subprocess, sys; subprocess.call([sys.executable, '-c', 'while True: pass'])"
    stuck = {"stuck": {"command": [sys.executable, "-c", "import time; time.sleep(1000)"]}}
    found += experiment("stuck", treatments=stuck, limits={**BASE["limits"], "wall": 2, "processor": 1000})
    busy = {"busy": {"command": [sys.executable, "-c", child_of_its_own]}}
    found += experiment("busy", treatments=busy, limits={**BASE["limits"], "processor": 2})
    by = {row["treatment"]: row for row in found}

    assert ("succeeded", f"seed {by['script']['seed']} run 0 hello") == (by["script"]["ending"], by["script"]["output"])
    assert by["same"]["at"] == by["script"]["at"]
    waited = "it has waited for 2 wall seconds without computing anything"
    assert ("hung", waited) == (by["stuck"]["ending"], by["stuck"]["cause"])
    assert ("hung", "it takes longer than 2 s of processor time") == (by["busy"]["ending"], by["busy"]["cause"])
    assert ("crashed", "oh no") == (by["killed"]["ending"], by["killed"]["output"])
    assert "the controller ended with signal 9" == by["killed"]["cause"]
    assert "failed" == by["no"]["ending"]
    assert ("error", "no_such_program: No such file or directory") == (by["none"]["ending"], by["none"]["cause"])


def test_a_study_from_its_file_to_its_comparison(experiment, tmp_path):
    treatments = {"near": {"python": "controllers.py:go(x=5)"}, "far": {"python": "controllers.py:go(x=10)"}}
    experiment("study", treatments=treatments, replications=30, keep={"traces": "all"})

    def told(*arguments: str, code: int = 0) -> str:
        process = processes.start("hmrsim", *arguments, cwd=tmp_path, env=os.environ | {"COLUMNS": "200"})
        out, err = process.communicate()
        assert code == process.returncode, err
        return out

    assert "pace: 60 runs: 1 scenario, 2 treatments (near, far)" in told("experiment", "check", "e.yaml")
    assert {"done": 60, "endings": {"succeeded": 60}}.items() <= json.loads(
        told("experiment", "status", "study", "--json")
    ).items()
    assert "near" in told("experiment", "show", "study")
    again = json.loads(told("experiment", "again", "study", "7", "--trace", "seven.jsonl", "--json"))
    assert (True, (tmp_path / "study/traces/7.jsonl").read_bytes()) == (
        again["same"],
        (tmp_path / "seven.jsonl").read_bytes(),
    )
    assert "identical" in told("replay", "seven.jsonl")
    assert 61 == len(told("experiment", "export", "study").splitlines())
    compared = json.loads(told("compare", "study:near", "study:far", "--json", code=1))
    assert (30, "worse") == (compared["pairs"], compared["measures"]["time"]["verdict"])
    assert "identical" in told("compare", "seven.jsonl", "study/traces/7.jsonl")
    assert "line 1 differs" in told("compare", "seven.jsonl", "study/traces/8.jsonl", code=1)
