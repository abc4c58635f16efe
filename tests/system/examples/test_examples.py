"""Every example runs, and prints the expected output in the file beside it."""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.world_checks import load_world
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.session import SessionOptions
from tests.paths import ROOT

ALONE = [ROOT / "examples" / "bottlenecks.py", ROOT / "examples" / "in_process.py"]
"""Examples that need no simulator."""
LEARNING = ROOT / "examples" / "learning.py"
SEARCH = ROOT / "examples" / "fault_search.py"
EXAMPLES = sorted({*ROOT.glob("examples/*.py"), *ROOT.glob("examples/*.xml")} - {*ALONE, LEARNING, SEARCH})
CONTROLLER = Path(sys.executable).with_name("bt-controller")


@contextmanager
def served(world, **settings):
    """Serve a world, and yield its endpoint."""
    options = SessionOptions(listen=("tcp/127.0.0.1:0",))
    with Host(load_world(world), options, RunSettings(**settings)) as host:
        host.start()
        yield host.endpoints[0]


def world_of(example):
    """Return the world and the clock that an example's first lines name; trees run in lockstep."""
    world, clock = re.search(r"``hmrsim run (\S+?)(?: --clock (\w+))?``", example.read_text()).groups()
    world = str(ROOT / world) if "/" in world else world
    if clock or example.suffix == ".xml":
        return {"world": world, "clock": "lockstep"}
    return {"world": world, "real_time_factor": 5.0}


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_an_example_prints_its_expected_output(example):
    with served(**world_of(example)) as endpoint:
        check_output(example, endpoint)


@pytest.mark.parametrize("example", ALONE, ids=[path.stem for path in ALONE])
def test_an_example_without_a_simulator_loads_no_network_library(example):
    code = f"import runpy, sys; runpy.run_path({str(example)!r}, run_name='__main__'); sys.exit('zenoh' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)

    assert (example.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


def test_the_search_example_finds_the_same_each_time():
    done = subprocess.run([sys.executable, SEARCH], cwd=ROOT, capture_output=True, text=True, check=False)

    assert (SEARCH.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


def test_the_learning_example_improves_and_is_reproducible():
    pytest.importorskip("gymnasium", reason="environments need the extra gym")
    pytest.importorskip("scipy", reason="comparisons need the extra experiments")
    done = subprocess.run([sys.executable, LEARNING], cwd=ROOT, capture_output=True, text=True, check=False)

    assert (LEARNING.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


def command_of(example, endpoint):
    """Return the command that an example names, for this simulator."""
    if example.suffix == ".xml":
        return [CONTROLLER, "run", example.relative_to(ROOT), "--robot", "wall_e", "--connect", endpoint]
    if tree := re.search(r"``(bt-controller run [^`]+)``", example.read_text()):
        return [CONTROLLER, *tree[1].split()[1:], "--connect", endpoint]
    return [sys.executable, example, endpoint]


def check_output(example, endpoint):
    command = command_of(example, endpoint)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)

    assert (example.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


def test_there_are_examples():
    assert 11 <= len(EXAMPLES)
