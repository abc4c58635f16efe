"""Every example runs, and prints what the file beside it says."""

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
    """Serve a world; give where."""
    options = SessionOptions(listen=("tcp/127.0.0.1:0",))
    with Host(load_world(world), options, RunSettings(**settings)) as host:
        host.start()
        yield host.endpoints[0]


@pytest.fixture
def endpoint():
    """Return where scenario 1 is served."""
    with served("scenario1", real_time_factor=5.0) as where:
        yield where


def world_of(example):
    """Return the world, and the clock, that an example asks for in its first lines; for trees it is lockstep."""
    world, clock = re.search(r"``hmrsim run (\S+?)(?: --clock (\w+))?``", example.read_text()).groups()
    world = str(ROOT / world) if "/" in world else world
    if clock or example.suffix == ".xml":
        return {"world": world, "clock": "lockstep"}
    return {"world": world, "real_time_factor": 5.0}


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_it_prints_what_it_should(example):
    """The output is compared, line by line."""
    with served(**world_of(example)) as endpoint:
        check_output(example, endpoint)


@pytest.mark.parametrize("example", ALONE, ids=[path.stem for path in ALONE])
def test_an_example_that_needs_no_simulator(example):
    """It prints what it should, and loads nothing of the network."""
    code = f"import runpy, sys; runpy.run_path({str(example)!r}, run_name='__main__'); sys.exit('zenoh' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=100, check=False
    )

    assert (example.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


def test_the_example_that_searches():
    """It finds the same each time."""
    done = subprocess.run([sys.executable, SEARCH], cwd=ROOT, capture_output=True, text=True, timeout=100, check=False)

    assert (SEARCH.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


@pytest.mark.timeout(420)
def test_the_example_that_learns():
    """It learns the same each time, and what it has learned is better."""
    pytest.importorskip("gymnasium", reason="environments need the extra gym")
    pytest.importorskip("scipy", reason="comparisons need the extra experiments")
    done = subprocess.run(
        [sys.executable, LEARNING], cwd=ROOT, capture_output=True, text=True, timeout=400, check=False
    )

    assert (LEARNING.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


def command_of(example, endpoint):
    """Return the command that an example names, for this simulator."""
    if example.suffix == ".xml":
        return [CONTROLLER, "run", example.relative_to(ROOT), "--robot", "wall_e", "--connect", endpoint]
    if tree := re.search(r"``(bt-controller run [^`]+)``", example.read_text()):
        return [CONTROLLER, *tree[1].split()[1:], "--connect", endpoint]
    return [sys.executable, example, endpoint]


def check_output(example, endpoint):
    """Run an example against a simulator."""
    command = command_of(example, endpoint)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=100, check=False)

    assert (example.with_suffix(".out").read_text(), "", 0) == (done.stdout, done.stderr, done.returncode)


BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_the_code_in_the_readme_runs(block, endpoint):
    """As it stands there, but for the endpoint."""
    code = block.replace("tcp/127.0.0.1:7447", endpoint)
    code = code.replace("Client()", f"Client(__import__('hmrsim_zenoh').SessionOptions(connect=('{endpoint}',)))")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100, check=False)

    assert ("", 0) == (done.stderr, done.returncode)


def test_the_code_in_the_docs_of_the_graph_runs():
    """As it stands there; it needs no simulator."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "reference" / "graph.md").read_text(), re.DOTALL)
    for block in blocks:
        done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True, timeout=100, check=False)

        assert ("", 0) == (done.stderr, done.returncode)
    assert blocks


def test_there_are_examples_and_blocks():
    """Neither list is empty by accident."""
    assert 11 <= len(EXAMPLES)
    assert 2 == len(BLOCKS)


def test_the_tree_in_the_docs_runs(endpoint, tmp_path):
    """As it stands there: checked, then run to success."""
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "reference" / "trees.md").read_text(), re.DOTALL)
    (tmp_path / "fetch.py").write_text(block)
    for order in (["check", "fetch:fetch"], ["run", "fetch:fetch", "--robot", "wall_e", "--connect", endpoint]):
        done = subprocess.run(
            [CONTROLLER, *order], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False
        )

        assert (0, "") == (done.returncode, done.stderr), done.stdout


def test_the_trees_and_nodes_in_the_docs_are_right(tmp_path):
    """The tree in XML, and the node of one's own, as they stand there."""
    text = (ROOT / "docs" / "reference" / "xml_trees.md").read_text()
    (tree,) = re.findall(r"```xml\n(.*?)```", text, re.DOTALL)
    (node,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / "visit.xml").write_text(tree.replace("<FollowPath ", '<Say text="off we go"/><FollowPath '))
    (tmp_path / "my_nodes.py").write_text(node)
    order = ["check", "visit.xml", "--nodes", "my_nodes", "--set", "goal=patient"]
    done = subprocess.run([CONTROLLER, *order], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)

    assert (0, "") == (done.returncode, done.stderr), done.stdout
    assert "        --> Say\n" in done.stdout
