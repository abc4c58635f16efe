"""Fixtures of the tests of reports: runs of small worlds, and the reports of their traces."""

from __future__ import annotations

import json

import pytest

from hmrsim.actions import registry
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.report import of_trace, report_of
from tests.unit.hmrsim.report.worlds import traced


@pytest.fixture
def trace():
    """Return the function that runs a world and returns its trace."""
    return traced


@pytest.fixture
def told():
    """Return the function that runs a world and returns its story from the trace."""

    def tell(world, **run):
        lines = traced(world, **run)
        return of_trace(lambda: lines)[0]

    return tell


@pytest.fixture
def report(told):
    """Return the function that runs a world and returns the report of its trace."""
    return lambda world, **run: report_of(told(world, **run))


@pytest.fixture
def changed():
    """Return the function that makes a trace impossible to replay, as one of another contract."""

    def change(lines):
        header = json.loads(lines[0])
        header["contract"] = 99
        return [json.dumps(header) + "\n", *lines[1:]]

    return change


@pytest.fixture
def send():
    """Return the function that makes the command which sends a goal."""

    def make(robot, action, goal, goal_id=None):
        return SendGoal(robot, action, registry()[action].goal.model_validate(goal), goal_id)

    return make


@pytest.fixture
def cancel():
    """Return the function that makes the command which cancels a goal."""
    return lambda robot, action, goal_id: CancelGoal(robot, action, goal_id, 0)
