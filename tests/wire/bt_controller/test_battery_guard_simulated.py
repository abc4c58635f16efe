"""A guarded mission in a real simulation, interrupted at many of its instants."""

from __future__ import annotations

import operator

import pytest
from py_trees.composites import Sequence

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.battery_guard import BatteryGuard
from bt_controller.behaviours.robot_actions import Dock, GoTo, Pickup, Place, Undock, Wait
from bt_controller.behaviours.subscribers import CheckData
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.sim_time import now
from bt_controller.loading.trees import Plan, load
from bt_controller.running.clocks import LockstepClock, Mailbox, clock_for
from bt_controller.running.mission import Mission
from bt_controller.running.runner import Runner
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from tests.served_world import served_world

STEPS = ["Go to shelf", "Pick up parcel", "Go to bed", "Wait 4 s", "Place parcel"]
"""The leaves of the mission, in their order."""


def world(charge):
    """Return a world in which a robot's battery is low after *charge* seconds or so."""
    return {
        "name": "ward",
        "waypoints": {"home": [0, 0], "shelf": [6, 0], "bed": [12, 0], "yard": [6, 4]},
        "lanes": [["home", "shelf"], ["shelf", "bed"], ["shelf", "yard"]],
        "items": {"parcel": {"at": [6, 0.3], "weight": 0.1}},
        "docks": {"charger": {"at": [6, 6], "staging": [6, 4], "type": "charger", "power": 50}},
        "robot_types": {
            "nurse": {
                "components": {
                    "claw": {"reach": 0.9, "max_weight": 1.0, "handling_time": 2},
                    "battery": {"capacity": 500, "initial_charge": 100 + charge, "drain": {"still": 1, "moving": 1}},
                }
            }
        },
        "robots": {"wall_e": {"type": "nurse", "at": "home"}},
    }


def errand():
    steps = [GoTo("shelf"), Pickup("parcel"), GoTo("bed"), Wait(4), Place("parcel")]
    return Sequence("Errand", memory=True, children=steps)


def charge():
    """Return the steps that charge the robot, wait for it, and leave the dock."""
    return Sequence("Charge", memory=True, children=[Dock("charger"), WaitUntilCharged(0.9), Undock()])


CHARGES = {"a dock": lambda: Dock("charger"), "dock, wait, undock": charge}
CHARGING = {"a dock": ["Dock at charger"], "dock, wait, undock": ["Dock at charger", "Undock"]}


@pytest.fixture
def sent(monkeypatch):
    """Return the list of all goals sent, by leaf and ticket, and check that no two overlap."""
    goals = []
    send = ActionLeaf._send

    def noted(self, goal):
        assert all(ticket.done for _, ticket in goals)
        send(self, goal)
        goals.append((self.name, self._handle))

    monkeypatch.setattr(ActionLeaf, "_send", noted)
    return goals


def run(plan, seconds, **time):
    """Run a tree in the ward; return whether it succeeded."""
    with served_world(world(seconds), **time) as options, Client(options, name="trees") as client:
        mission, mailbox = Mission("wall_e", plan), Mailbox()
        clock = clock_for(client, mailbox, feedback=False, grace=1.0)
        return Runner(client, [mission], clock, mailbox, show=None).run().succeeded


def guarded(how):
    """Return the plan of the guarded errand."""
    return Plan("test", lambda: BatteryGuard("G", errand(), CHARGES[how]()), takes_robot=False, confirmed=False)


def check(sent, charging):
    """Each step SUCCEEDED once and in order, at most one goal was canceled, and the robot came back if it had to."""
    done = [name for name, ticket in sent if ticket.status is GoalStatus.SUCCEEDED]
    others = [(name, ticket.status) for name, ticket in sent if ticket.status is not GoalStatus.SUCCEEDED]
    drives = [name.startswith("Go to") for name, _ in others]

    assert STEPS == [name for name in done if name in STEPS]
    assert charging == [name for name in done if name not in (*STEPS, "Go back")]
    assert [] == others or [GoalStatus.CANCELED] == [status for _, status in others]
    assert ([True] != drives) == ("Go back" in done)


@pytest.mark.parametrize("how", CHARGES)
@pytest.mark.parametrize("seconds", [-5, 0.5, 1.5, 4.5, 5.5, 6.5, 7.5, 12.5, 14.5, 16.5, 18.5, 19.5])
def test_a_mission_that_is_interrupted_charges_resumes_and_finishes(sent, how, seconds):
    succeeded = run(guarded(how), seconds, clock="lockstep")

    assert succeeded
    check(sent, CHARGING[how])


class Counted(LockstepClock):
    """Counts how often time moves."""

    waits = 0

    def wait(self, until):
        self.waits += 1
        return super().wait(until)


def alone(build, seconds):
    """Run a tree in lockstep; return whether it succeeded, when that was, and how often time moved."""
    plan = Plan("test", build, takes_robot=False, confirmed=False)
    with served_world(world(seconds), clock="lockstep") as options, Client(options, name="trees") as client:
        mission, mailbox = Mission("wall_e", plan), Mailbox()
        clock = Counted(client, client.lockstep, mailbox, feedback=False, grace=1.0)
        outcome = Runner(client, [mission], clock, mailbox, show=None).run()
        return outcome.succeeded, clock.now, clock.waits


def test_a_guard_sleeps_until_the_battery_is_low(sent):
    """A charge, a rest and a mission of 250 s take no more steps than their goals."""
    succeeded, _, waits = alone(lambda: BatteryGuard("G", Wait(250), Dock("charger")), 200.25)

    assert succeeded
    assert waits < 30
    assert ["Wait 250 s", "Dock at charger", "Go back", "Wait 250 s"] == [name for name, _ in sent]


def test_a_guard_acts_at_the_instant_at_which_the_battery_is_low(monkeypatch):
    """The threshold is a port of the guard: half of 500 is reached 150 s before 100 are left."""
    stopped, stop = [], BatteryGuard._stop
    monkeypatch.setattr(BatteryGuard, "_stop", lambda guard: (stopped.append(now()), stop(guard)))
    succeeded, _, _ = alone(lambda: BatteryGuard("G", Wait(100), Dock("charger"), below=0.5), 200.25)

    assert succeeded
    assert [pytest.approx(50.25, abs=1e-6)] == stopped


def test_a_leaf_sees_a_level_at_its_instant():
    """The level is reached between two whole seconds, and time advances although nothing else happens."""
    succeeded, ended, waits = alone(lambda: CheckData("Low", "battery_state", "percentage", 0.2, operator.lt), 7.25)

    assert (True, 1) == (succeeded, waits)
    assert ended == pytest.approx(7.25, abs=1e-6)


@pytest.mark.parametrize("seconds", [2, 6.5, 14.5])
def test_in_real_time_battery_messages_wake_the_guard(sent, seconds):
    succeeded = run(guarded("a dock"), seconds, real_time_factor=20.0)

    assert succeeded
    check(sent, CHARGING["a dock"])


FILE = """
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <BatteryGuard below="0.2" until="0.9">
      <Sequence>
        <NavigateToPose name="Go to shelf" goal="shelf"/>
        <Pickup name="Pick up parcel" target_name="parcel"/>
        <NavigateToPose name="Go to bed" goal="bed"/>
        <Wait name="Wait 4 s" wait_duration="4"/>
        <Place name="Place parcel" attached_object_name="parcel"/>
      </Sequence>
      <DockRobot name="Dock at charger" dock_id="charger"/>
    </BatteryGuard>
  </BehaviorTree>
</root>
"""


@pytest.mark.parametrize("seconds", [4.5, 6.5, 12.5, 16.5])
def test_a_guard_interrupts_the_mission_of_a_tree_file(sent, tmp_path, seconds):
    path = tmp_path / "guard.xml"
    path.write_text(FILE)
    succeeded = run(load(str(path)), seconds, clock="lockstep")

    assert succeeded
    check(sent, CHARGING["a dock"])
