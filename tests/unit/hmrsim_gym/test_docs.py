"""The examples in docs/reference/gym.md run as they stand there, in a shorter horizon."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests.paths import ROOT

pytest.importorskip("pettingzoo", reason="environments need the extra gym")

TEXT = (ROOT / "docs" / "reference" / "gym.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_the_examples_in_the_docs_run(block):
    """They import what they use, and come to the end."""
    names = {}

    exec(block.replace("horizon=1800", "horizon=60"), names)

    assert not names["env"].close()


def test_there_are_two_examples():
    """One for each interface."""
    assert 2 == len(BLOCKS)


def test_the_figures_are_those_of_the_example():
    """Of its last run, that is."""
    out = (ROOT / "examples" / "learning.out").read_text()
    costs = re.search(r"the nearest order costs (\d+), the learned one (\d+)", out).groups()
    difference = re.search(r"difference is -(\d+), between -(\d+) and -(\d+)", out).groups()

    assert f"orders cost {costs[1]} a run instead of the {costs[0]} of `nearest`" in TEXT
    assert "{0} less, with 95 % between {2} and {1}".format(*difference) in TEXT


def test_without_the_extra_it_says_what_to_install():
    """Whichever of its names is asked for."""
    code = "import sys; sys.modules['gymnasium'] = None; import hmrsim_gym"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)

    assert "MissingExtra: environments need gymnasium and pettingzoo; pip install 'hmrsim[gym]'" in done.stderr
