"""Robots that execute the scripts of their world file."""

from __future__ import annotations

import pytest

from hmrsim.goals.script_orders import read_order
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.outputs import EventStamped
from hmrsim.simulation.scripts import ScriptState
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD, simulate

ERRAND = ["Go shelf", "Grab parcel", "Go home", "Drop parcel", "Wait 2.5"]


@pytest.fixture
def scripted():
    """Return a simulation of the small world in which wall_e has these orders."""

    def make(*orders: str, robot: str = "wall_e"):
        robots = SMALL_WORLD["robots"]
        return simulate({**SMALL_WORLD, "robots": {**robots, robot: {**robots[robot], "script": orders}}})

    return make


def goals(log):
    """Return the accepted goals in order, with times and actions."""
    return [(time, event.action) for time, event in log.events if getattr(event, "status", None) == 1]


def test_each_order_starts_when_the_previous_one_has_succeeded(scripted):
    run = scripted(*ERRAND)
    log = run()

    assert [(0.0, "navigate_to_pose"), (8.0, "pickup"), (8.0, "navigate_to_pose"), (16.0, "place"), (16.0, "wait")] == (
        goals(log)
    )
    script = run.simulator.scripts.all["wall_e"]
    assert (ScriptState.DONE, 5, "", 18.5) == (script.state, script.done, script.error, script.ended)
    assert (1.0, 2.0) == run.simulator.items["parcel"].point


def test_a_script_ends_with_the_first_goal_that_fails(scripted):
    run = scripted("Go shelf", "Grab anvil", "Go home")
    run()

    script = run.simulator.scripts.all["wall_e"]
    assert (ScriptState.FAILED, 1, 8.0) == (script.state, script.done, script.ended)
    assert "'Grab anvil' ended ABORTED: 'anvil' is too heavy: 80 kg, the claw lifts 1 kg" == script.error


def test_a_controllers_goal_ends_the_script(scripted):
    run = scripted("Go shelf", "Go home")
    wait = SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=1)), "a" * 32)
    run((3.0, wait))

    script = run.simulator.scripts.all["wall_e"]
    assert f"'Go shelf' ended ABORTED: preempted by goal {'a' * 32}" == script.error
    assert 4.0 == run.simulator.now


def test_a_canceled_order_ends_the_script(scripted):
    run = scripted("Go shelf", "Go home")
    run((3.0, CancelGoal("wall_e", "navigate_to_pose")))

    assert "'Go shelf' ended CANCELED: canceled" == run.simulator.scripts.all["wall_e"].error


def test_a_rejected_order_ends_the_script():
    run = simulate({**SMALL_WORLD, "robots": {"eve": {"at": "home", "planner": "external", "script": ["Go shelf"]}}})
    run()

    assert "'Go shelf' was rejected: eve has an external planner, and none has announced itself" == (
        run.simulator.scripts.all["eve"].error
    )


def test_the_end_of_a_script_is_an_event(scripted):
    log = scripted("Wait 1")()

    (ended,) = [event for _, event in log.events if isinstance(event, EventStamped) and event.kind == "script_ended"]
    assert {"robot": "wall_e", "orders": 1, "done": 1, "state": "done", "error": ""} == ended.fields
    assert 1_000_000_000 == ended.stamp


def test_a_stopped_simulation_ends_the_goal_of_a_script(scripted):
    run = scripted("Go shelf", "Go home")
    run(until=3.0)
    run.simulator.stop("enough")

    assert ["ACCEPTED", "EXECUTING", "ABORTED"] == [
        event.status.name for _, event in run.log.events if hasattr(event, "goal_id") and hasattr(event, "status")
    ]


def test_follow_drives_straight_from_point_to_point(scripted):
    """The robot faces the direction in which it came."""
    run = scripted("Follow 1 3 4 3 4 7")
    run()

    assert (4.0, 7.0, pytest.approx(1.5707963)) == run.simulator.robots["wall_e"].pose()
    assert 8.0 == run.simulator.now


def test_follow_ends_at_the_last_reachable_point(scripted):
    run = scripted("Follow 5 5 9 5")
    run()

    error = run.simulator.scripts.all["wall_e"].error
    assert "'Follow 5 5 9 5' ended ABORTED: blocked: an obstacle stands between (5, 5) and (9, 5)" == error
    assert (5.0, 5.0) == run.simulator.robots["wall_e"].pose().point


@pytest.mark.parametrize(
    ("text", "action", "fields"),
    [
        ("Go shelf", "navigate_to_pose", {"pose": {"pose": {"position": {"x": 9.0, "y": 2.0}}}}),
        ("Go 3 4.5", "navigate_to_pose", {"pose": {"pose": {"position": {"x": 3.0, "y": 4.5}}}}),
        (" Go  3,-4.5 ", "navigate_to_pose", {"pose": {"pose": {"position": {"x": 3.0, "y": -4.5}}}}),
        ("Grab parcel", "pickup", {"target_name": "parcel"}),
        ("Drop parcel", "place", {"attached_object_name": "parcel"}),
        ("Wait 1.5", "wait", {"time": {"sec": 1, "nanosec": 500_000_000}}),
    ],
)
def test_an_order_sets_the_fields_of_its_goal(text, action, fields):
    order = read_order(text, World.model_validate(SMALL_WORLD))

    assert action == order.action.name
    assert order.action.goal.model_validate(fields) == order.goal


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Fly home", r"no order begins with 'Fly'; there are: .*Follow X Y X Y …; .*Go PLACE, or X Y; Grab ITEM; "),
        ("", "no order begins with ''"),
        ("Go", "'Go' says too little; expected Go PLACE, or X Y"),
        ("Go shelv", "no waypoint, place or dock 'shelv'; did you mean 'shelf'"),
        ("Go 3 nan", "no waypoint, place or dock '3 nan'"),
        ("Go 1e400 3", "no waypoint, place or dock '1e400 3'"),
        ("Grab parzel", "no item 'parzel'; did you mean 'parcel'"),
        ("Drop nothing", "no item 'nothing'"),
        ("Wait long", "'long' is not a number"),
        ("Wait -1", "expected one number of seconds, from 0 to 2147483647, got '-1'"),
        ("Wait 1e300", "expected one number of seconds, from 0 to 2147483647, got '1e300'"),
        ("Go 1e9 5", r"\(1e\+09, 5\) is outside any map: coordinates end at 1e\+07"),
        ("Follow 1 2 3 -1e9", "is outside any map"),
        ("Wait 1 2", "expected one number of seconds, from 0 to 2147483647, got '1 2'"),
        ("Follow 1 2 3", "3 numbers are not points; expected pairs of x and y"),
        ("Follow 1 x", "'x' is not a number"),
    ],
)
def test_an_invalid_order_is_refused_with_a_remedy(text, message):
    with pytest.raises(ValueError, match=message):
        read_order(text, World.model_validate(SMALL_WORLD))
