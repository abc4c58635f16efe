"""A porter that tries in vain while it is broken down, and the same run without that fault."""

from __future__ import annotations

import pytest

from hmrsim.fault_search.failure_page import failure_page, run_logged
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case, Injection
from tests.porters import check_of

BREAKDOWN = Injection(
    {
        "type": "breakdown",
        "robot": "porter",
        "duration": 60.0,
        "when": {"goal": "executing", "robot": "porter", "action": "pickup"},
    }
)


@pytest.fixture(scope="session")
def check():
    return check_of("vain")


@pytest.fixture(scope="session")
def failing(check):
    """Return the outcome of the failing run, and its log."""
    return run_logged(check, Case((BREAKDOWN,)), Wanted(trace=True))


@pytest.fixture(scope="session")
def passing(check):
    return run_logged(check, Case(), Wanted())


@pytest.fixture(scope="session")
def page(check, failing):
    return failure_page(check, Case((BREAKDOWN,)), *failing)
