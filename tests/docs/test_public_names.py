"""Every public name has an example that the documentation tests run."""

from __future__ import annotations

import ast
import importlib
import re

import pytest

from tests.docs.page import blocks_of
from tests.paths import ROOT

PAGES = {
    "bt_controller": "bt_controller",
    "hmrsim": "hmrsim",
    "hmrsim.events": "events",
    "hmrsim.experiments.statistics": "statistics",
    "hmrsim.testing": "testing",
    "hmrsim_gym": "hmrsim_gym",
    "hmrsim_zenoh": "hmrsim_zenoh",
}
"""The page of each package that exports names."""


def used_in(text):
    """Return the names that a block of Python, or a doctest, reads."""
    lines = re.sub(r"^(?:>>>|\.\.\.) ?|^(?!>>>|\.\.\.).*", "", text, flags=re.MULTILINE) if ">>>" in text else text
    return {node.id for node in ast.walk(ast.parse(lines)) if isinstance(node, ast.Name)}


@pytest.mark.parametrize("package", PAGES)
def test_every_name_of_a_package_is_used_in_an_example(package):
    pytest.importorskip("scipy", reason="needs the extra experiments")
    pytest.importorskip("gymnasium", reason="needs the extra gym")
    names = set(importlib.import_module(package).__all__)
    blocks = blocks_of(ROOT / "docs" / "reference" / "python" / f"{PAGES[package]}.md")
    used = set().union(*(used_in(block.text) for block in blocks if block.language in {"python", "pycon"}))

    assert set() == names - used
