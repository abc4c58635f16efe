"""A mission that is interrupted to charge goes on where it was, whenever that was."""

from __future__ import annotations

import math
from itertools import product

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from py_trees.behaviours import Failure
from py_trees.blackboard import Blackboard
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Repeat, Timeout
from py_trees.timers import Timer

from bt_controller.behaviours.battery_guard import BatteryGuard
from bt_controller.behaviours.robot_actions import NavToPoseActionClient, Wait, pose_goal
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import PortError
from bt_controller.core.robots import Directory
from bt_controller.core.sim_time import simulated_time
from bt_controller.running.schedule import due
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait as WaitAction
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.protocol.goal import GoalStatus
from tests.profiles import examples
from tests.unit.bt_controller.conftest import FakeTopics

CHARGE = 99
BACK = 100
DIRECTORY = Directory.from_info(
    {"robots": [{"name": name, "actions": ["wait", "navigate_to_pose"]} for name in ("wall_e", "eve")]}
)


class Battery(FakeTopics):
    """The topics of a robot, with the battery state of a test."""

    def __init__(self):
        super().__init__()
        self.percentage = 1.0
        self.status = BatteryState.POWER_SUPPLY_STATUS_DISCHARGING

    def ask(self, _robot, _topic):
        return Odometry()

    def latest(self, _robot, _topic):
        return BatteryState(percentage=self.percentage, power_supply_status=self.status)


class Robots:
    """Does what the goals say, a step of each at a time; checks that no robot has two of them.

    Attributes:
        done: The seconds of the waits that were done, in order.
    """

    def __init__(self, client, *, steps=2, late=0, meanwhile=False):
        self._client = client
        self._steps = steps
        self._late = late
        self._meanwhile = meanwhile
        self._ages = {}
        self.done = []

    def step(self):
        """Advance each goal by one step."""
        open_goals = [goal for goal in self._client.goals if not goal.done]
        robots = [goal.robot for goal in open_goals]
        assert sorted(set(robots)) == sorted(robots)
        for goal in open_goals:
            if goal.accepted is None:
                goal.accept()
            if goal.canceled:
                self._ages[goal, "canceled"] = late = self._ages.get((goal, "canceled"), -1) + 1
                if late >= self._late:
                    self._end_canceled(goal)
                continue
            self._ages[goal] = self._ages.get(goal, 0) + 1
            if self._ages[goal] >= self._steps:
                self._succeed(goal)

    def _end_canceled(self, goal):
        if self._meanwhile:
            self._succeed(goal)
        else:
            goal.end_canceled()

    def _succeed(self, goal):
        goal.succeed()
        self.done.append(BACK if goal.action.name == "navigate_to_pose" else goal.goal.time.sec)


def leaf(seconds, robot=None):
    goal = WaitAction.Goal(time=Duration(sec=seconds))
    if robot is None:
        return Wait(seconds)
    return ActionLeaf(f"Wait {seconds}", "wait", goal, robot=robot)


def errand():
    """Return a mission of all kinds of composites; its six goals each have a number."""
    both = ParallelPolicy.SuccessOnAll(synchronise=True)
    choice = Selector("Choice", memory=True, children=[Failure("No"), leaf(2)])
    pair = Parallel("Pair", policy=both, children=[leaf(3), leaf(4, "eve")])
    limited = Timeout("Limited", Sequence("Inner", memory=True, children=[leaf(5), leaf(6)]), duration=1000.0)
    return Sequence("Errand", memory=True, children=[leaf(1), choice, pair, limited])


def guarded(client, mission, battery, charge=None):
    """Return a guard that is set up."""
    guard = BatteryGuard("Guard", mission, charge or leaf(CHARGE))
    for node in guard.iterate():
        node.setup(client=client, robot="wall_e", topics=battery, directory=DIRECTORY)
    return guard


def play(client, lows, mission=None, **robots):
    """Run a guarded mission to its end, with a battery that is low from the given ticks until it is charged."""
    client.goals.clear()
    Blackboard.clear()
    battery, world = Battery(), Robots(client, **robots)
    guard = guarded(client, mission or errand(), battery)
    for tick in range(500):
        if tick in lows:
            battery.percentage = 0.1
        with simulated_time(float(tick)):
            guard.tick_once()
        if guard.status is not Status.RUNNING:
            return guard, world, tick
        world.step()
        if world.done[-1:] == [CHARGE]:
            battery.percentage = 1.0
    raise AssertionError("the mission does not end")


def test_a_mission_without_interruption_needs_no_charging(client):
    guard, world, ticks = play(client, ())

    assert (Status.SUCCESS, [1, 2, 3, 4, 5, 6], 10) == (guard.status, world.done, ticks)


@pytest.mark.parametrize(("late", "meanwhile"), [*product((0, 1, 3), (False, True))])
def test_a_mission_interrupted_at_any_tick_does_each_step_once(client, late, meanwhile):
    for tick in range(10):
        guard, world, _ = play(client, {tick}, late=late, meanwhile=meanwhile)

        assert guard.status is Status.SUCCESS
        assert sorted(world.done) == [1, 2, 3, 4, 5, 6, CHARGE, BACK]


@examples(150, share_fixtures=True)
@given(
    lows=st.frozensets(st.integers(0, 60), max_size=6),
    steps=st.integers(1, 4),
    late=st.integers(0, 4),
    meanwhile=st.booleans(),
)
@example(lows={0, 1, 2, 3, 4}, steps=1, late=0, meanwhile=False)  # never full when that is looked at
def test_a_mission_interrupted_again_and_again_does_each_step_once(client, lows, steps, late, meanwhile):
    """However often, and whatever becomes of the canceled goals; given up only when charging is in vain."""
    guard, world, _ = play(client, lows, steps=steps, late=late, meanwhile=meanwhile)
    steps_done = sorted(seconds for seconds in world.done if seconds < CHARGE)
    in_vain = guard.feedback_message in ("charged to 10% only", "charged 3 times, and no goal has ended in between")

    assert guard.status is (Status.FAILURE if in_vain else Status.SUCCESS)
    assert steps_done == ([*dict.fromkeys(steps_done)] if in_vain else [1, 2, 3, 4, 5, 6])


def test_the_way_back_is_in_the_tree_from_the_start():
    guard = BatteryGuard("Guard", leaf(1), leaf(CHARGE))

    assert ["Wait 1 s", "Wait 99 s", "Go back"] == [child.name for child in guard.children]


def test_charging_in_an_earlier_life_does_not_count(client):
    battery = Battery()
    guard = BatteryGuard("Guard", Sequence("Twice", memory=True, children=[leaf(1), leaf(2)]), leaf(CHARGE))
    for node in guard.iterate():
        node.setup(client=client, robot="wall_e", topics=battery, directory=DIRECTORY, resume="me/m/wall_e")
    guard.tick_once()
    client.goals[0].is_known(GoalStatus.SUCCEEDED)
    client.goals[0].succeed()
    battery.percentage = 0.1
    guard.tick_once()
    client.goals[1].is_known(GoalStatus.SUCCEEDED)
    client.goals[1].succeed()
    guard.tick_once()

    assert [1, CHARGE, CHARGE] == [goal.goal.time.sec for goal in client.goals]
    assert client.goals[1].goal_id != client.goals[2].goal_id


STEPS = {
    "tick": lambda guard, _battery, _goals: guard.tick_once(),
    "low": lambda _guard, battery, _goals: setattr(battery, "percentage", 0.1),
    "full": lambda _guard, battery, _goals: setattr(battery, "percentage", 1.0),
    "accept": lambda _guard, _battery, goals: goals[-1].accept(),
    "succeed": lambda _guard, _battery, goals: goals[-1].succeed(),
    "end_canceled": lambda _guard, _battery, goals: goals[-1].end_canceled(),
    "abort": lambda _guard, _battery, goals: goals[-1].abort(208, "no way there"),
}
"""What the tree does, how full the battery is, and what becomes of the latest goal."""
WAIT, GO = "wait", "navigate_to_pose"


@pytest.mark.parametrize(
    ("steps", "sent", "status", "message"),
    [
        ("tick low tick tick", [WAIT], Status.RUNNING, "stopping, battery 10%"),
        ("tick low tick tick end_canceled tick", [WAIT, WAIT], Status.RUNNING, "charge, battery 10%"),
        (
            "tick low tick end_canceled tick abort tick",
            [WAIT, WAIT],
            Status.FAILURE,
            "the battery is at 10%, and charging it failed",
        ),
        (
            "tick low tick abort tick succeed full tick succeed tick",
            [WAIT, WAIT, GO],
            Status.FAILURE,
            "mission, battery 100%",
        ),
        (
            "low tick succeed full tick abort tick",
            [WAIT, GO],
            Status.FAILURE,
            "charged, but can't get back: aborted: no way there",
        ),
    ],
    ids=[
        "a robot that is still leaving one goal is not given another",
        "it is charged when its goal has ended",
        "the mission is not gone on with on an empty battery",
        "a goal that was aborted meanwhile was not canceled, and is not sent again",
        "a robot that can't get back would go on in the wrong place",
    ],
)
def test_a_low_battery_is_charged_between_goals(client, steps, sent, status, message):
    battery = Battery()
    guard = guarded(client, leaf(1), battery)
    for step in steps.split():
        STEPS[step](guard, battery, client.goals)

    assert (sent, status) == ([goal.action.name for goal in client.goals], guard.status)
    assert message == guard.feedback_message
    assert status is Status.RUNNING or all(goal.done for goal in client.goals)


def test_a_charger_that_still_charges_is_waited_for(client):
    """As a dock succeeds as soon as it charges."""
    battery = Battery()
    battery.percentage = 0.1
    guard = guarded(client, leaf(1), battery)
    guard.tick_once()
    client.goals[0].succeed()
    battery.status = BatteryState.POWER_SUPPLY_STATUS_CHARGING
    for battery.percentage in (0.1, 0.5, 0.89):
        guard.tick_once()
    before = len(client.goals)
    battery.percentage = 0.9
    guard.tick_once()

    assert (1, 2) == (before, len(client.goals))


def test_a_charger_that_does_not_charge_fails_the_guard(client):
    """After some seconds, in which it might have been late to say so."""
    battery = Battery()
    battery.percentage = 0.1
    guard = guarded(client, leaf(1), battery)
    for now in (0.0, 1.0, 3.0):
        with simulated_time(now):
            guard.tick_once()
        client.goals[0].succeed()
    before = guard.status
    with simulated_time(4.0):
        guard.tick_once()

    assert (Status.RUNNING, Status.FAILURE) == (before, guard.status)
    assert guard.feedback_message == "charged to 10% only"


def test_an_interrupt_while_charging_cancels_that(client):
    battery = Battery()
    battery.percentage = 0.1
    guard = guarded(client, leaf(1), battery)
    guard.tick_once()
    guard.stop(Status.INVALID)

    assert [True] == [goal.canceled for goal in client.goals]


def test_time_stands_still_for_the_mission(client):
    """A timer of ten seconds that was interrupted for a hundred ends a hundred seconds later, and is ticked then."""
    battery = Battery()
    guard = guarded(client, Timer("Timer", 10.0), battery)
    for now, battery.percentage in ((0.0, 1.0), (4.0, 0.1), (5.0, 0.1), (100.0, 1.0), (104.0, 1.0)):
        with simulated_time(now):
            guard.tick_once()
        for goal in client.goals:
            goal.succeed()
    battery.asks = False
    when = due(guard, 104.0, 1.0).time
    statuses = []
    for now in (109.0, 110.0):
        with simulated_time(now):
            guard.tick_once()
        statuses.append(guard.status)

    assert 110.0 == when
    assert [Status.RUNNING, Status.SUCCESS] == statuses


def test_in_lockstep_time_stops_for_the_levels_that_a_guard_waits_for(client):
    battery = Battery()
    battery.stops = True
    guard = guarded(client, leaf(1), battery)
    charging, discharging = BatteryState.POWER_SUPPLY_STATUS_CHARGING, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
    found = []
    for now, battery.percentage, battery.status in (
        (0.0, 1.0, discharging),
        (1.0, 0.1, discharging),
        (2.0, 0.1, discharging),
        (3.0, 0.1, discharging),
        (4.0, 0.2, charging),
        (9.0, 0.9, charging),
    ):
        with simulated_time(now):
            guard.tick_once()
        needed = due(guard, now, 1.0)
        found.append((needed.time, [(*when,) for each in needed.awaited for when in each.when]))
        for goal in client.goals:
            goal.succeed() if now else None
    full = ("/percentage", ">=", 0.9), ("/power_supply_status", "==", BatteryState.POWER_SUPPLY_STATUS_FULL)

    assert (math.inf, [("/percentage", "<", 0.2)]) == found[0]
    assert (math.inf, []) == found[1]
    assert (math.inf, [*full]) == found[2]
    assert (6.0, [*full]) == found[3]
    assert (math.inf, [*full, ("/power_supply_status", "!=", charging)]) == found[4]


def test_counts_of_decorators_are_kept(client):
    guard, world, _ = play(client, {3}, Repeat("Thrice", leaf(1), num_success=3))

    assert (Status.SUCCESS, [1, CHARGE, BACK, 1, 1]) == (guard.status, world.done)


@pytest.mark.parametrize(("below", "until"), [(0.5, 0.4), (-0.1, 0.9), (0.2, 1.1)])
def test_shares_that_make_no_sense_are_an_error(client, below, until):
    guard = BatteryGuard("Guard", leaf(1), leaf(CHARGE), below=below, until=until)
    with pytest.raises(PortError, match=r"Guard: port 'below': .* are not as 0 <= below < until <= 1"):
        guard.setup(client=client, robot="wall_e", topics=Battery())


def test_a_battery_that_is_low_on_the_way_back_is_charged_again(client):
    battery = Battery()
    guard = guarded(client, leaf(1), battery)
    for percentage, end in (
        (0.1, "succeed"),
        (1.0, "accept"),
        (0.1, "end_canceled"),
        (0.1, "succeed"),
        (1.0, "accept"),
    ):
        battery.percentage = percentage
        guard.tick_once()
        getattr(client.goals[-1], end)()

    assert ["wait", "navigate_to_pose", "wait", "navigate_to_pose"] == [goal.action.name for goal in client.goals]
    assert client.goals[1].goal == client.goals[3].goal


def test_a_mission_that_does_not_get_on_between_charges_fails(client):
    battery = Battery()
    guard = guarded(client, NavToPoseActionClient("Far", pose_goal(500.0, 0.0)), battery)
    while guard.status in (Status.INVALID, Status.RUNNING):
        battery.percentage = 1.0
        guard.tick_once()
        battery.percentage = 0.1
        guard.tick_once()
        client.goals[-1].end_canceled()
        if guard.status is Status.RUNNING:
            guard.tick_once()
            client.goals[-1].succeed()

    assert (Status.FAILURE, 3) == (guard.status, sum(goal.action.name == "wait" for goal in client.goals))
    assert "charged 3 times, and no goal has ended in between" == guard.feedback_message


def test_a_drive_that_was_interrupted_is_gone_on_with_from_the_charger(client):
    battery = Battery()
    guard = guarded(client, NavToPoseActionClient("Go", pose_goal(5.0, 5.0)), battery)
    for percentage, end in ((1.0, "accept"), (0.1, "end_canceled"), (0.1, "succeed"), (1.0, "accept")):
        battery.percentage = percentage
        guard.tick_once()
        getattr(client.goals[-1], end)()

    assert ["navigate_to_pose", "wait", "navigate_to_pose"] == [goal.action.name for goal in client.goals]
    assert client.goals[2].goal == pose_goal(5.0, 5.0)
