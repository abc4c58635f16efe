"""Reports of recordings, and of runs in which somebody changed the world."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hmrsim.gateway import CallService
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.report import of_recording, report_of
from hmrsim.report.watching import Watcher
from hmrsim.services import registry as services
from hmrsim.simulator import Simulator
from hmrsim.world.loading import world_of
from tests.report.worlds import ALONE, CHARGING, FAULTY, MEETING, goal_to


def _recorded(world, *, since=0.0, battery=None):
    """Return a recording of a run's scripts, which may begin late."""
    samples = []
    simulator = Simulator(world_of(world, "test"))
    simulator.advance(since)

    def keep(happened):
        stamp = Time.from_nanoseconds(happened.at).model_dump()
        if happened.kind == "scene":
            samples.append((happened.at, "_world/scene", dict(happened.fields) | {"stamp": stamp}))
        elif happened.kind != "battery":
            samples.append(
                (happened.at, "_world/events", dict(happened.fields) | {"kind": happened.kind, "stamp": stamp})
            )
        elif battery:
            samples.append((happened.at, f"{battery}/battery_state", _state(simulator, battery)))

    Watcher(simulator, keep)
    simulator.run_scripts()
    return SimpleNamespace(samples=lambda: iter(samples), world=world, info={"seed": 3}, truncated=False)


def _state(simulator, robot):
    return simulator.robots[robot].energy.state().model_dump(mode="json")


@pytest.mark.parametrize("world", [ALONE, MEETING, CHARGING])
def test_a_recording_tells_the_same_as_a_trace(report, world):
    """Of motions, states, goals and waits."""
    recorded, traced = report_of(of_recording(_recorded(world))), report(world)

    assert traced.goals == recorded.goals
    assert (traced.waits, traced.states, traced.lanes) == (recorded.waits, recorded.states, recorded.lanes)
    assert ("recording", True) == (recorded.source.kind, recorded.source.exact)


def test_energy_of_a_recording_is_that_of_its_battery_states():
    """They say it in ampere hours at the nominal voltage."""
    (robot,) = report_of(of_recording(_recorded(CHARGING, battery="wall_e"))).robots

    assert pytest.approx(24.0) == robot.energy_used
    assert pytest.approx(24.0) == robot.energy_charged


def test_a_recording_that_begins_late():
    """What is under way then is taken from the scene: one and a half of four metres are left, and all of the rest."""
    found = report_of(of_recording(_recorded(ALONE, since=2.5)))
    (robot,) = found.robots

    assert (2.5, 7.5) == (robot.began, found.summary.sim_time)
    assert {"driving": 5.5, "busy": 2.0} == {state: time for state, time in robot.seconds.items() if time}
    assert "It begins 2.5 s after the simulation did; what was before is not known." in found.source.notes


def test_time_that_began_anew_goes_on(report, send):
    """After the reset at 3 s the goal takes another 4 s."""
    world = ALONE | {"robots": {"wall_e": {"type": "cart", "at": "home"}}}
    reset = CallService("reset_simulation", services()["reset_simulation"].request())
    go = send("wall_e", "navigate_to_pose", goal_to(4, 0))
    found = report(world, commands=[(1.0, go), (3.0, reset), (0.0, go)], until=5.0)
    (robot,) = found.robots

    assert [("ABORTED", 1.0, 3.0), ("SUCCEEDED", 3.0, 7.0)] == [(g.status, g.accepted, g.ended) for g in found.goals]
    assert (8.0, 6.0) == (found.summary.sim_time, robot.distance)
    assert "Simulated time began anew (once); here it goes on where it was." in found.source.notes


def test_robots_that_come_and_go(report):
    """Each is counted for as long as it is there."""
    spawn = services()["spawn_entity"].request.model_validate(
        {"name": "eve", "uri": "robot_type:cart", "initial_pose": {"pose": {"position": {"x": 4.0}}}}
    )
    delete = services()["delete_entity"].request.model_validate({"entity": "eve"})
    commands = [(1.0, CallService("spawn_entity", spawn)), (3.0, CallService("delete_entity", delete))]
    found = report(ALONE, commands=commands)
    robots = {robot.name: (robot.began, robot.ended, robot.seconds["idle"]) for robot in found.robots}

    assert {"wall_e": (0.0, 10.0, 0.0), "eve": (1.0, 3.0, 2.0)} == robots


def test_a_goal_that_runs_out_of_patience_says_for_whom(report):
    """It waited for the one that stands in its way for all its patience."""
    world = MEETING | {
        "traffic": {"policy": "reserve", "patience": 5, "reroutes": 0},
        "robots": {
            "early": {"type": "cart", "at": "middle"},
            "late": {"type": "cart", "at": "south", "script": ["Go north"]},
        },
    }
    (error,) = report(world).errors

    assert ("late", 104, "PATIENCE_EXCEEDED") == (error.robot, error.error_code, error.error_name)
    assert "early" == error.waited_for
    assert 5.0 == error.at - error.waiting_since


def test_a_fault_in_the_beginning_is_known(report):
    """It is in the first scene, or told of at time 0."""
    found = report(FAULTY | {"faults": [FAULTY["faults"][0] | {"at": 0}]})

    assert [("flat_tyre", 0.0)] == [(fault.name, fault.began) for fault in found.faults]
