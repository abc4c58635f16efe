"""The causes of goals that did not succeed."""

from __future__ import annotations

from functools import partial

import pytest

from hmrsim.protocol.commands import CancelGoal, ChangeState, GetResult
from tests import simulation
from tests.simulation import A, B, simulate

WORLD = {
    "waypoints": {"home": [0, 0], "shelf": [20, 0], "island": [0, 50]},
    "lanes": [["home", "shelf"]],
    "walls": [[[-5, 30], [25, 30]]],
    "traffic": {"policy": "reserve", "patience": 5},
    "robots": {
        "eve": {"at": "home", "components": {"claw": {}, "battery": {"initial_charge": 60, "capacity": 100}}},
        "bob": {"at": "shelf"},
    },
}


send = partial(simulation.send, robot="eve")
go = partial(simulation.go, robot="eve")


WAIT = send("wait", time={"sec": 100})
ASKED = GetResult("eve", "wait", A, "asked")


def cause(log, goal_id=A):
    return next(change.cause for change in log.goal_changes(goal_id) if change.status.terminal)


@pytest.mark.parametrize(
    ("commands", "expected"),
    [
        ([(0.0, send("wait", time={"sec": 1}))], ""),
        ([(0.0, WAIT), (1.0, CancelGoal("eve", "wait", A))], "canceled"),
        ([(0.0, WAIT), (1.0, go(5.0, goal_id=B))], "preempted"),
        ([(0.0, WAIT)], "battery_empty"),
        ([(0.0, go(20.0))], "blocked"),
        ([(0.0, send("follow_path", path={"poses": [{"pose": {"position": {"y": 40.0}}}]}))], "blocked"),
        ([(0.0, send("pickup", target_name="nothing"))], "failed"),
        ([(0.0, go(0.0, 40.0))], "no_route"),
        ([(0.0, WAIT), (1.0, ChangeState("eve", "behavior_server", ("wait",), 4))], "deactivated"),
    ],
)
def test_other_goals_and_cancels_are_causes(commands, expected):
    log = simulate(WORLD)(*commands, until=80.0)

    assert cause(log) == expected


@pytest.mark.parametrize(
    ("service", "request_", "expected"),
    [
        ("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": 5.0}}}}, "moved"),
        ("delete_entity", {"entity": "eve"}, "deleted"),
        ("reset_simulation", {}, "reset"),
    ],
)
def test_services_are_causes(service, request_, expected):
    run = simulate(WORLD)
    run((0.0, WAIT), (0.0, ASKED), until=1.0)
    run.ask(service, request_)

    assert (cause(run.log), run.log.answer("asked").cause) == (expected, expected)


def test_a_breakdown_is_a_cause():
    run = simulate(WORLD)
    run((0.0, go(10.0)), until=1.0)
    run.ask("inject_fault", {"type": "breakdown", "robot": "eve"})

    assert cause(run.log) == "breakdown"


def test_a_busy_base_is_a_cause():
    log = simulate(WORLD)((0.0, WAIT), (1.0, send("pickup", B, target_name="nothing")), until=2.0)

    assert cause(log, B) == "busy"


def test_the_end_of_the_simulation_is_a_cause():
    run = simulate(WORLD)
    run((0.0, WAIT), until=1.0)
    run.simulator.stop("the end")

    assert cause(run.log) == "ended"
