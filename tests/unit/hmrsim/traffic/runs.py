"""Runs of robots under a policy."""

from __future__ import annotations

from tests import simulation
from tests.simulation import simulate


def go(robot, x, y, goal_id):
    return simulation.go(x, y, goal_id, robot)


def under(policy, world, **settings):
    """Return a simulation of a world under a policy."""
    return simulate({**world, "traffic": {"policy": policy, **settings}})


def end(log, goal_id):
    """Return when a goal ended, rounded to a microsecond, its status and its message."""
    at, status = log.changes(goal_id)[-1]
    return round(at, 6), status, log.result(goal_id).error_msg
