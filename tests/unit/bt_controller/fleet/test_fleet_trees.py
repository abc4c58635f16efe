"""Trees that are one for several robots."""

from __future__ import annotations

import pytest
from py_trees.behaviours import Success
from py_trees.blackboard import Blackboard
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.robots import NotServed
from bt_controller.examples.deliveries import TASKS
from bt_controller.loading.trees import Plan, load
from bt_controller.running.clocks import Mailbox, clock_for
from bt_controller.running.mission import missions_for
from bt_controller.running.runner import Runner
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.world_checks import load_world


def plan(function):
    """Return the plan of one tree for all."""
    return Plan("test", function, takes_robot=False, confirmed=False, takes_robots=True)


def all_go(robots):
    """Return a tree in which each robot drives."""
    leaves = [ActionLeaf(robot, "navigate_to_pose", NavigateToPose.Goal(), robot=robot) for robot in robots]
    return Parallel("All", policy=ParallelPolicy.SuccessOnAll(), children=leaves)


@pytest.fixture
def run(client):
    """Return the function that runs a tree for some robots: the outcome."""

    def run(function, *robots):
        mailbox = Mailbox()
        clock = clock_for(client, mailbox, feedback=False, grace=0.0)
        missions = missions_for(robots, plan(function))
        return Runner(client, missions, clock, mailbox, show=lambda *_: _succeed(client), grace=0.0).run()

    return run


def _succeed(client):
    for goal in client.goals:
        goal.succeed()


def test_each_leaf_sends_to_its_own_robot(client, run):
    outcome = run(all_go, "wall_e", "eve")

    assert {"fleet": Status.SUCCESS} == outcome.statuses
    assert ["wall_e", "eve"] == [goal.robot for goal in client.goals]


def test_a_robot_that_is_not_there_is_an_error(run):
    with pytest.raises(NotServed, match="no robot 'wally'; did you mean 'wall_e'"):
        run(lambda _robots: Success("Success"), "eve", "wally")


def test_a_leaf_that_names_no_robot_is_an_error(run):
    with pytest.raises(NotServed, match="no robot 'fleet'"):
        run(lambda _robots: ActionLeaf("Go", "navigate_to_pose", NavigateToPose.Goal()), "eve")


def test_all_leaves_share_a_blackboard(run):
    seen = []

    def tree(robots):
        Blackboard.set("robots", len(robots))
        seen.append(Blackboard.get("robots"))
        return Success("Success")

    run(tree, "wall_e", "eve")

    assert [2] == seen
    assert not Blackboard.exists("robots")


@pytest.mark.parametrize(
    ("signature", "takes"),
    [("robots", (False, True)), ("robots=()", (False, True)), ("robot", (True, False)), ("", (False, False))],
)
def test_the_parameters_name_says_whether_it_is_one_tree_for_all(tmp_path, monkeypatch, signature, takes):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    name = f"bt_test_fleet_{abs(hash(signature))}"
    (tmp_path / f"{name}.py").write_text(f"def tree({signature}):\n    pass\n")
    found = load(f"{name}:tree")

    assert takes == (found.takes_robot, found.takes_robots)


def test_the_map_has_what_is_to_be_brought_and_where():
    world = load_world("hospital_fleet").world
    places = {task.source for task in TASKS} | {task.target for task in TASKS}

    assert [] == [task.item for task in TASKS if task.item not in world.items]
    assert [] == [place for place in places if place not in world.places]


def test_no_item_is_asked_for_twice():
    assert len(TASKS) == len({task.item for task in TASKS})
