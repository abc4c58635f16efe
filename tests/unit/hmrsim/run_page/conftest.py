"""A porter that tries in vain while it is broken down, and the same run without that fault."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.failure_page import failure_page, run_logged
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case, Injection
from tests.porters import check_of

PLANTED = Path(__file__).parents[3] / "planted"
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


def planted(name):
    """Return the check of a planted bug, a case that shows it, its outcome and its log."""
    bug = yaml.safe_load((PLANTED / "catalogue.yaml").read_text("utf-8"))[name]
    said = {"world": bug["world"], "controller": bug["bug"], "limits": {"simulated": 600}}
    check = check_at(CheckFile.model_validate(said), PLANTED)
    case = Case(tuple(Injection(each.get("fault", each)) for each in bug["shown_by"]))
    return check, case, *run_logged(check, case, Wanted())


@pytest.fixture(scope="session")
def waiting():
    """Return the check, case, outcome and log of a robot that queues for a charger that another one does not leave."""
    return planted("occupied_berth")


@pytest.fixture(scope="session")
def page(check, failing):
    return failure_page(check, Case((BREAKDOWN,)), *failing)
