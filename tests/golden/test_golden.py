"""Whatever is changed inside, runs stay as they were, byte for byte: traces, reports, scenes and answers."""

from __future__ import annotations

import pytest

from tests.golden import _cases

_PROCESSES = ("demo", "program/")


def _marked(name):
    marks = [pytest.mark.system] if name.startswith(_PROCESSES) else []
    return pytest.param(name, id=name, marks=marks)


@pytest.mark.parametrize("name", [_marked(name) for name in _cases.CASES])
def test_it_is_as_pinned(name):
    """If it should not be: pin it anew."""
    found = _cases.digests(_cases.made(name))

    assert _cases.known().get(name) == found, (
        f"`python -m tests.golden DIR --only {name}`, before and after your change, the second time with"
        " `--against` the first DIR, shows the first difference; `--update` pins what you meant to change"
    )


@pytest.mark.parametrize("name", _cases.WITHIN)
def test_it_is_the_same_within_one_process(name):
    """Without Zenoh, and without a thread for the simulation."""
    assert _cases.known()[name] == _cases.digests(_cases.made(name, _cases.WITHIN))


def test_nothing_is_pinned_that_is_not_run():
    """A case that was renamed leaves nothing behind."""
    assert [] == sorted(_cases.known().keys() - _cases.CASES.keys())
