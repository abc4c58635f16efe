"""Runs of a world in tests of users: queries, checks, and the messages of failed checks."""

from __future__ import annotations

import asyncio
import re
import subprocess
import sys
from contextlib import suppress
from typing import ClassVar

import pytest
from py_trees.behaviours import Running
from py_trees.composites import Sequence

from bt_controller.behaviours.robot_actions import GoTo, Pickup, Place
from hmrsim.actions import registry
from hmrsim.errors import WorldError
from hmrsim.geometry import Pose
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.settings.run import RunSettings
from hmrsim.testing.run import ControllerGoesOn
from hmrsim_zenoh import GoalFailed

WORLD = {
    "waypoints": {"home": [0, 0], "shelf": [10, 0], "ward": [20, 0]},
    "lanes": [["home", "shelf"], ["shelf", "ward"]],
    "items": {"medicine": {"at": [10, 0.5]}},
    "robots": {"wall_e": {"at": "home", "components": {"claw": {}}}, "eve": {"at": "ward"}},
}


def deliver():
    """Return the tree that brings the medicine to the ward."""
    return Sequence(
        "Deliver", memory=True, children=[GoTo("shelf"), Pickup("medicine"), GoTo("ward"), Place("medicine")]
    )


def pick_up():
    """Return a tree that fails: the medicine is out of reach."""
    return Pickup("medicine")


def test_a_tree_is_run_to_its_end(simulation):
    run = simulation(WORLD, tree=deliver, robots=["wall_e"])

    assert run.to_the_end().succeeded
    run.check_succeeded()
    run.check_visited("wall_e", "shelf", "ward")
    assert ["shelf", "ward"] == run.visited("wall_e")
    assert ("ward", None) == (run.where("medicine"), run.carrier("medicine"))
    assert ["navigate_to_pose", "pickup", "navigate_to_pose", "place"] == [goal.action for goal in run.goals("wall_e")]
    assert ["medicine"] == [each.fields["item"] for each in run.happened("picked", robot="wall_e")]
    assert run.now == run.goals()[-1].ended


def test_the_coverage_of_a_tree(simulation):
    run = simulation(WORLD, tree=pick_up, robots=["wall_e"], coverage=True)
    run.to_the_end()

    assert run.coverage.keys() == {f"pick_up/Pick up medicine:{seen}" for seen in ("RUNNING", "FAILURE", "ABORTED/-1")}


def test_coverage_is_not_counted_by_default(simulation):
    assert simulation(WORLD, tree=deliver).coverage is None


def test_a_client_and_a_commander(simulation):
    run = simulation(WORLD)
    wall_e = run.commander("wall_e")
    wall_e.go_to_pose(10, 0)
    wall_e.pickup("medicine")

    assert ("wall_e", "shelf") == (run.carrier("medicine"), run.where("wall_e"))
    with pytest.raises(GoalFailed):
        wall_e.pickup("medicine")
    (failed,) = run.goals(status="ABORTED")
    assert "pickup" == failed.action


def test_the_goals_of_a_robot(simulation):
    run = simulation(WORLD)
    run.commander("wall_e").go_to_pose(10, 0)
    run.commander("eve").go_to_pose(10, 0)

    (goal,) = run.goals("eve", "navigate_to_pose", "SUCCEEDED")
    assert isinstance(goal.goal, NavigateToPose.Goal)
    assert (20.0, "shelf", 10.0) == (goal.ended, goal.where, goal.accepted)


def test_a_failed_assertion_tells_the_story(simulation):
    run = simulation(WORLD, tree=pick_up, robots=["wall_e"])
    run.to_the_end()
    with pytest.raises(AssertionError, match=r"(?s)^wall_e failed\n.*ABORTED"):
        run.check_succeeded()
    with pytest.raises(AssertionError, match="wall_e did not visit 'shelf'"):
        run.check_visited("wall_e", "shelf")


def test_a_story_is_printed_line_by_line(simulation):
    with simulation("cafe") as run:
        run.commander("mocha").navigate_to("table_1")
        story = run.story()

    assert isinstance(story, list)
    assert story == str(story).splitlines()


def test_wrong_questions(simulation):
    run = simulation(WORLD)

    with pytest.raises(ValueError, match="no robot or item 'bob'; there are: wall_e, eve, medicine"):
        run.where("bob")
    with pytest.raises(ValueError, match="there is no tree to run"):
        run.to_the_end()
    with pytest.raises(AssertionError, match="has not come to its end"):
        run.check_succeeded()
    with pytest.raises(WorldError, match="robots"):
        simulation({**WORLD, "robots": {"eve": {"at": "nowhere"}}})


def test_two_runs_have_the_same_trace_byte_for_byte(simulation):
    traces = []
    for _ in range(2):
        run = simulation("hospital", tree="bt_controller.examples.hospital:mission")
        run.to_the_end()
        run.check_succeeded()
        traces.append(run.trace)

    assert traces[0] == traces[1]
    assert traces[0].count('"kind":"status"') > 50


def test_pytest_starts_as_fast_as_before():
    """The plug-in loads nothing of the simulator before a test asks for it."""
    code = "import sys, hmrsim.testing.plugin; print([m for m in ('zenoh', 'py_trees', 'simpy') if m in sys.modules])"

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "[]\n" == done.stdout


NODES = '''\
from py_trees.common import Status

from bt_controller.core.node import Condition


class Never(Condition):
    """Fails, and says why."""

    def update(self):
        """Fail."""
        self.feedback_message = "it never is"
        return Status.FAILURE
'''
NEVER = '<root BTCPP_format="4"><BehaviorTree ID="A"><Never name="Is it so?"/></BehaviorTree></root>'


def test_a_tree_in_xml_with_nodes_of_its_own(simulation, tmp_path, monkeypatch):
    """They are named as for the command; a failure names the node that failed."""
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "nodes_of_its_own.py").write_text(NODES)
    (tmp_path / "never.xml").write_text(NEVER)

    run = simulation("cafe", tree=tmp_path / "never.xml", robots=["mocha"], nodes=["nodes_of_its_own"])

    assert not run.to_the_end().succeeded
    with pytest.raises(AssertionError, match=r"^mocha failed\n  mocha: Is it so\? \(.*never\.xml:1\): it never is\n"):
        run.check_succeeded()


def test_a_tree_that_does_not_end(simulation):
    run = simulation("cafe", tree=lambda: Running("Rest"), robots=["mocha"], settings=RunSettings(duration=30))
    run.to_the_end()

    assert 30 == run.now
    with pytest.raises(AssertionError, match=r"^mocha failed\n  mocha: Rest: running\n"):
        run.check_succeeded()


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda run: run.happened("battery_emtpy"), "no event 'battery_emtpy'; did you mean 'battery_empty'?"),
        (lambda run: run.happened("dock_docked", robt="chai"), "no field of dock_docked 'robt'; did you mean 'robot'?"),
        (lambda run: run.goals("mcha"), "no robot 'mcha'; did you mean 'mocha'?"),
        (lambda run: run.goals("mocha", "dock"), "no action 'dock'; did you mean 'dock_robot'?"),
        (lambda run: run.goals(status="ABORTTED"), "no status 'ABORTTED'; did you mean 'ABORTED'?"),
        (lambda run: run.visited("chia"), "no robot 'chia'; did you mean 'chai'?"),
        (lambda run: run.check_visited("chai", "conter"), "no place 'conter'; did you mean 'counter'?"),
        (lambda run: run.carrier("cofee"), "no item 'cofee'; did you mean 'coffee'?"),
        (lambda run: run.orders("opn"), "no state of an order 'opn'; did you mean 'open'?"),
    ],
)
def test_a_question_about_what_can_not_be_is_an_error(simulation, ask, said):
    """Its answer would be the same for ever, and so would be a test that asks it."""
    with pytest.raises(ValueError, match=re.escape(said)):
        ask(simulation("cafe"))


def test_the_goals_of_a_deleted_robot_are_known(simulation):
    run = simulation("cafe")
    run.commander("chai").wait(1)
    run.client.get("hmrsim/_world/delete_entity", payload=b'{"entity": "chai"}')

    assert ["wait"] == [goal.action for goal in run.goals("chai")]


def test_a_place_that_was_not_visited_is_named_with_the_one_before(simulation):
    run = simulation("cafe")
    run.commander("chai").navigate_to("counter")

    with pytest.raises(AssertionError, match=r"^chai did not visit 'hall'; it visited counter\n"):
        run.check_visited("chai", "hall")
    with pytest.raises(AssertionError, match=r"^chai did not visit 'hall' after 'counter'; it visited counter\n"):
        run.check_visited("chai", "counter", "hall")


class TestEndlessTree:
    """A tree that never ends, in a run without a duration."""

    WORLD: ClassVar = {"waypoints": {"a": [0, 0]}, "robots": {"ann": {"at": "a"}}}
    TREE = """\
<root BTCPP_format="4"><BehaviorTree ID="Rest"><KeepRunningUntilFailure>
  <Wait wait_duration="10"/>
</KeepRunningUntilFailure></BehaviorTree></root>
"""

    def test_it_ends_after_a_simulated_hour_with_the_goals_that_repeat(self, simulation, tmp_path):
        path = tmp_path / "rest.xml"
        path.write_text(self.TREE)
        with (
            simulation(self.WORLD, tree=path) as run,
            pytest.raises(
                ControllerGoesOn, match=r"after 3600 simulated seconds; the goals .*: wait of ann 3\d\d times; if"
            ),
        ):
            run.to_the_end()

    def test_a_longer_duration_of_its_own_counts(self, simulation, tmp_path):
        path = tmp_path / "rest.xml"
        path.write_text(self.TREE)
        with simulation(self.WORLD, tree=path, settings=RunSettings(duration=4000)) as run:
            run.to_the_end()

            assert 4000 == run.now


class TestAsyncioControllers:
    """Functions and coroutines that `Run.play` runs as controllers."""

    @staticmethod
    async def patrol(client, places=("shelf", "ward")):
        """Visit some places, and return them."""
        for place in places:
            await client.robot("wall_e").navigate_to(place)
        return places

    @staticmethod
    async def wait_for_orders(client):
        """Wait for orders without an end."""
        await client.robot("wall_e").navigate_to("shelf")
        async for _ in client.events("order_placed"):
            pass

    def test_its_result_is_returned(self, simulation):
        run = simulation(WORLD)

        assert ["ward"] == run.play(self.patrol, places=["ward"])
        assert ["ward"] == run.visited("wall_e")

    def test_it_is_canceled_after_its_duration(self, simulation):
        run = simulation(WORLD)

        assert run.play(self.wait_for_orders, duration=60) is None
        assert run.now == 60
        assert ["shelf"] == run.visited("wall_e")

    def test_one_that_does_not_end(self, simulation):
        with pytest.raises(
            ControllerGoesOn, match=r"after 3600 simulated seconds; .* navigate_to_pose of wall_e 1 times"
        ):
            simulation(WORLD).play(self.wait_for_orders)

    def test_one_that_waits_for_itself(self, simulation):
        async def wait_for_itself(client):
            await client.robot("wall_e").navigate_to("shelf")
            await asyncio.Event().wait()

        with pytest.raises(ControllerGoesOn) as caught:
            simulation(WORLD).play(wait_for_itself)

        assert [
            "wall_e is idle at shelf: it has had no goal since navigate_to_pose SUCCEEDED at 10 s",
            "eve is idle at ward: it has had no goal yet",
        ] == caught.value.__notes__

    def test_a_blocking_controller(self, simulation):
        with pytest.raises(TypeError, match=r"deliver is no `async def` function; call it .*: deliver\(run.client\)"):
            simulation(WORLD).play(deliver)


class TestOrders:
    """Checks of the orders of a demand."""

    WORLD: ClassVar = {
        "waypoints": {"home": [0, 0], "shelf": [10, 0], "ward": [20, 0]},
        "lanes": [["home", "shelf"], ["shelf", "ward"]],
        "robots": {"ann": {"at": "home", "components": {"claw": {"max_weight": 1}}}, "bob": {"at": "ward"}},
        "traffic": {"policy": "reserve", "patience": None},
        "demand": [
            {"name": "box", "at": "shelf", "to": "home", "arrives": 5, "count": 2},
            {"name": "safe", "at": "shelf", "to": "home", "weight": 80, "arrives": 12, "count": 1},
        ],
    }

    @staticmethod
    async def deliver(client):
        """Serve the orders one after the other."""
        ann = client.robot("ann")
        async for order in client.orders():
            with suppress(GoalFailed):
                await ann.navigate_to(order["from"])
                await ann.pickup(order["item"])
                await ann.navigate_to(order["to"])
                await ann.place(order["item"])

    @staticmethod
    async def visit_the_ward(client):
        """Wait for the robot that stands there."""
        await client.robot("ann").navigate_to("ward")

    def test_the_number_of_delivered_orders(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.deliver, duration=100)

        run.check_delivered(2)

    def test_a_failure_tells_the_open_orders_and_the_goals_that_failed(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.deliver, duration=100)

        with pytest.raises(AssertionError) as caught:
            run.check_delivered()

        text, *lines = str(caught.value).splitlines()
        assert "2 of 3 orders were delivered" == text
        assert "  safe_1, placed at 12 s: no robot has picked up 'safe_1' at shelf" == lines[0]
        heavy = "'safe_1' is too heavy: 80 kg, the claw lifts 1 kg"
        assert f"  pickup of ann was aborted at 55 s: {heavy}" in lines
        assert "    100.000 s  play() canceled the controller, which had not returned within its duration" == lines[-2]
        assert lines[-1].startswith("    100.000 s  its tasks then: Task-2 waits for a future (")

    def test_another_number_of_orders(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.deliver, duration=100)

        with pytest.raises(AssertionError, match=r"^2 of 3 orders were delivered, not 1\n"):
            run.check_delivered(1)

    def test_an_order_that_a_robot_carries(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.deliver, duration=18)

        with pytest.raises(AssertionError, match="box_1, placed at 5 s: ann carries 'box_1', which has to go to home"):
            run.check_delivered()

    def test_no_order_is_not_all_orders(self, simulation):
        with pytest.raises(AssertionError, match=r"^0 of 0 orders were delivered"):
            simulation(WORLD).check_delivered()

    def test_why_tells_what_held_a_robot_up_when_the_controller_was_canceled(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.visit_the_ward, duration=60)

        assert run.why("ann").startswith("ann has waited at shelf since 10 s for bob")
        with pytest.raises(AssertionError, match=r"60\.000 s  ann has waited at shelf since 10 s for bob"):
            run.check_delivered()

    def test_why_tells_what_a_robot_does_once_time_has_gone_on(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.visit_the_ward, duration=60)
        run.client.sleep(1)

        assert run.why("ann").startswith("ann is idle at shelf: it has had no goal since navigate_to_pose CANCELED")

    def test_why_tells_what_a_robot_does_that_was_spawned_after_the_controller_was_canceled(self, simulation):
        run = simulation(self.WORLD)
        run.play(self.visit_the_ward, duration=60)
        run.simulator.roster.delete("ann")
        for name in ("ann", "cat"):
            run.simulator.roster.spawn_robot(name, "carrier", Pose(0.0, 0.0, 0.0))

        assert run.why("cat").startswith("cat is idle at home: it has had no goal yet")
        assert run.why("ann").startswith("ann is idle at home: it has had no goal yet")


def test_a_run_tells_why_a_robot_waits(simulation):
    run = simulation({**WORLD, "traffic": {"policy": "reserve"}})
    run.client.action_client("wall_e", registry()["navigate_to_pose"]).send_goal({"pose": "ward"})
    run.client.sleep(30.0)

    assert run.why("wall_e").startswith("wall_e has waited at shelf since 10 s for eve")
    assert "eve is idle at ward: it has had no goal yet; what would help: " in run.why("wall_e")
    with pytest.raises(AssertionError, match=r"30\.000 s  wall_e has waited at shelf since 10 s for eve"):
        run.check_visited("wall_e", "ward")


INVALID_WORLD = """
from hmrsim.testing import simulation

def test_it():
    simulation({"robots": {"eve": {"at": "nowhere"}}})
"""
UNKNOWN_PLACE = """
import asyncio
from hmrsim.testing import simulation

async def drive(client):
    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(client.robot("eve").compute_path_to([]))

def test_it():
    with simulation({"robots": {"eve": {"at": [0, 0]}}}) as run:
        run.play(drive)
"""


@pytest.mark.parametrize(
    ("test", "shown", "hidden"),
    [
        (INVALID_WORLD, "test_world.py:5: WorldError", "hmrsim/testing/run.py"),
        (UNKNOWN_PLACE, "in drive", "asyncio/runners.py"),
    ],
)
def test_tracebacks_show_the_lines_of_the_user(tmp_path, test, shown, hidden):
    (tmp_path / "test_world.py").write_text(test)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_world.py"]

    output = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout

    assert shown in output
    assert hidden not in output
