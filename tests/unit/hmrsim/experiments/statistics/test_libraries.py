"""scipy is an extra."""

from __future__ import annotations

import subprocess
import sys

import pytest

from hmrsim.errors import MissingExtra
from hmrsim.experiments.statistics import confidence_sequence, mean_interval, proportion_interval


@pytest.mark.parametrize(
    ("missing", "act"),
    [
        ("scipy", lambda: mean_interval([1.0, 2.0])),
        ("scipy.optimize", lambda: confidence_sequence([1.0, 2.0] * 20)),
        ("numpy", lambda: confidence_sequence([1.0, 2.0])),
    ],
)
def test_without_it_the_error_says_what_to_install(monkeypatch, missing, act):
    """Instead of an ImportError."""
    monkeypatch.setitem(sys.modules, missing, None)

    with pytest.raises(MissingExtra, match=r"need scipy; pip install 'hmrsim\[experiments\]'"):
        act()


def test_the_package_is_imported_without_it():
    """And what needs no distribution works."""
    program = (
        "import sys; sys.modules.update(scipy=None, numpy=None); from hmrsim.experiments import statistics; "
        "print(round(statistics.proportion_interval(0, 20).high, 4))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)

    assert "0.1611\n" == done.stdout, done.stderr
    assert proportion_interval(0, 20).high < 1
