"""The table of limits in the docs."""

from __future__ import annotations

import importlib
import re

import pytest

from tests.paths import ROOT

_ROW = re.compile(r"^\| (?P<what>.+?) \| (?P<limit>.+?) \| (?P<where>.*`.+?) \|$", re.MULTILINE)
_NUMBER = re.compile(r"(\d[\d,]*(?:e\d+)?)( MiB)?")
_NAME = re.compile(r"`([\w./]+)`")
_ROWS = {
    row["what"]: row for row in _ROW.finditer((ROOT / "docs" / "reference" / "limits.md").read_text(encoding="utf-8"))
}


def constants(where):
    """Yield the constants that a row names, and their values; one without a module is of the file behind it."""
    names = _NAME.findall(where)
    files = [name for name in names if "/" in name]
    for name in names:
        if name in files:
            files.remove(name)
            continue
        module, _, constant = name.rpartition(".")
        if not module and not files:
            module = names[0].rpartition(".")[0]
        module = module or files[0].removesuffix(".py").replace("/", ".")
        if constant.isupper():
            yield constant, getattr(importlib.import_module(module), constant)


@pytest.mark.parametrize("what", _ROWS)
def test_each_limit_is_as_documented(what):
    limit = _ROWS[what]["limit"].replace("10⁹", "1e9")
    said = {float(digits.replace(",", "")) * 2 ** (20 * bool(unit)) for digits, unit in _NUMBER.findall(limit)}
    for constant, value in constants(_ROWS[what]["where"]):
        number = getattr(value, "greatest", value)
        if isinstance(number, (int, float)):
            assert number in said, (constant, number, limit)
