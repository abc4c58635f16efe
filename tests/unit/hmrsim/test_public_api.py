"""What the packages offer: each name is there, has a docstring and stands in order."""

from __future__ import annotations

import importlib
import inspect
import subprocess
import sys
from importlib.util import find_spec

import pytest

LEARNS = find_spec("pettingzoo") is not None
"""Whether the extra gym is installed."""

PACKAGES = ("hmrsim", "hmrsim_zenoh", "bt_controller", *(["hmrsim_gym"] if LEARNS else []))
NAMES = [(package, name) for package in PACKAGES for name in importlib.import_module(package).__all__]


@pytest.mark.parametrize("package", PACKAGES)
def test_names_are_in_order(package):
    """So that a name is found, and two changes don't meet."""
    names = importlib.import_module(package).__all__

    assert sorted(set(names)) == names


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_says_what_it_is_for(package):
    """In a paragraph at least."""
    assert 100 < len(inspect.getdoc(importlib.import_module(package)))


@pytest.mark.parametrize(("package", "name"), NAMES)
def test_a_name_is_there_and_says_what_it_is(package, name):
    """Whatever has a docstring has one of its own; numbers and texts have none."""
    found = getattr(importlib.import_module(package), name)

    assert isinstance(found, (int, str)) or inspect.getdoc(found)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_name_that_is_not_there_is_no_attribute(package):
    """As of any module."""
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nonsense'"):
        importlib.import_module(package).nonsense  # noqa: B018 - it is asked for


@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import hmrsim, hmrsim_zenoh, bt_controller", ("pydantic", "simpy", "zenoh", "py_trees", "yaml")),
        ("from hmrsim import RunSettings, Simulator, World, commands, errors, load_world", ("zenoh", "py_trees")),
        pytest.param(
            "import hmrsim_gym",
            ("pettingzoo", "simpy", "zenoh", "networkx"),
            marks=pytest.mark.skipif(not LEARNS, reason="environments need the extra gym"),
        ),
    ],
)
def test_what_is_not_asked_for_is_not_loaded(code, heavy):
    """A program that imports a package waits for nothing that it doesn't use."""
    program = f"{code}; import sys; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "[]\n" == done.stdout
