"""The documentation of the environments, and their missing extra."""

from __future__ import annotations

import re
import subprocess
import sys

from tests.paths import ROOT

TEXT = (ROOT / "docs" / "reference" / "gym.md").read_text()


def test_figures_are_those_of_the_example():
    out = (ROOT / "examples" / "learning.out").read_text()
    costs = re.search(r"the nearest order costs (\d+), the learned one (\d+)", out).groups()
    difference = re.search(r"difference is -(\d+), between -(\d+) and -(\d+)", out).groups()

    assert f"orders cost {costs[1]} a run instead of the {costs[0]} of `nearest`" in TEXT
    assert "{0} less, with 95 % between {2} and {1}".format(*difference) in TEXT


def test_missing_extra_names_the_package_to_install():
    code = "import sys; sys.modules['gymnasium'] = None; import hmrsim_gym"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert "MissingExtra: environments need gymnasium and pettingzoo; pip install 'hmrsim[gym]'" in done.stderr
