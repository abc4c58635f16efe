"""Traces, reports, scenes and answers of known runs stay the same, byte for byte."""

from __future__ import annotations

import pytest

from tests.golden import _cases

_PROCESSES = ("demo", "program/")


def _marked(name):
    marks = [pytest.mark.system] if name.startswith(_PROCESSES) else []
    return pytest.param(name, id=name, marks=marks)


@pytest.mark.parametrize("name", [_marked(name) for name in _cases.CASES])
def test_a_golden_run_is_unchanged(name):
    found = _cases.digests(_cases.made(name))

    assert _cases.known().get(name) == found, (
        f"`python -m tests.golden DIR --only {name}`, before and after your change, the second time with"
        " `--against` the first DIR, shows the first difference; `--update` pins what you meant to change"
    )


@pytest.mark.parametrize("name", _cases.WITHIN)
def test_a_golden_run_is_the_same_within_one_process(name):
    assert _cases.known()[name] == _cases.digests(_cases.made(name, _cases.WITHIN))


def test_every_pinned_case_is_run():
    assert [] == sorted(_cases.known().keys() - _cases.CASES.keys())
