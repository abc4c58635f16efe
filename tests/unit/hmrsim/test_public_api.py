"""The public names of the packages: they exist, are documented and sorted."""

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
def test_names_are_sorted(package):
    names = importlib.import_module(package).__all__

    assert sorted(set(names)) == names


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_has_a_docstring(package):
    assert 100 < len(inspect.getdoc(importlib.import_module(package)))


@pytest.mark.parametrize(("package", "name"), NAMES)
def test_each_name_exists_and_has_its_own_docstring(package, name):
    found = getattr(importlib.import_module(package), name)

    assert isinstance(found, (int, str)) or inspect.getdoc(found)


@pytest.mark.parametrize("package", PACKAGES)
def test_an_unknown_name_is_no_attribute(package):
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
def test_unused_modules_are_not_imported(code, heavy):
    program = f"{code}; import sys; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "[]\n" == done.stdout
