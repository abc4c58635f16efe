"""What a demo tells of its mission."""

from __future__ import annotations

import pytest

from hmrsim.cli.demo_story import Story
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.events.robots import ItemPicked, ItemPlaced, MotionBegan, Stopped
from hmrsim.events.simulation import SimulationReset

GOAL = ("eve", "wait", "1" * 32)
LINEN = ("eve", "linen")


def tree(*statuses, root="RUNNING"):
    """Return a tree of one root and some leaves, as the controller shows it."""
    leaves = [
        {"depth": 1, "name": f"leaf {i}", "status": status, "message": "why"} for i, status in enumerate(statuses)
    ]
    nodes = [{"depth": 0, "name": "root", "status": root, "message": ""}, *leaves]
    return {"robot": "eve", "sim_time": 3.0, "status": root, "nodes": nodes}


@pytest.fixture
def story():
    """Return the story of one robot."""
    return Story({"eve": "courier"})


@pytest.mark.parametrize(
    ("event", "robot", "text"),
    [
        (GoalAccepted(*GOAL, {"time": {"sec": 5}}), "eve", "wait accepted: 5 s"),
        (GoalStatusChanged(*GOAL, 4), "eve", "wait SUCCEEDED"),
        (GoalStatusChanged(*GOAL, 6, {"error_msg": "no"}), "eve", "wait ABORTED: no"),
        (ItemPicked(*LINEN), "eve", "picks up linen"),
        (ItemPlaced(*LINEN, (1.0, 2.5)), "eve", "puts down linen at (1, 2.5)"),
        (SimulationReset(255), "", "the simulation was reset"),
    ],
)
def test_events_are_told(event, robot, text, story):
    """What happens is told with time and robot."""
    (line,) = story.on_event(2.5, event)

    assert f"    2.500 | world | {robot:<8} | {text}" == str(line)


@pytest.mark.parametrize(
    "event",
    [
        GoalStatusChanged(*GOAL, 2),
        MotionBegan("eve", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1.0, None),
        ItemPicked("hal", "linen"),
    ],
)
def test_what_is_not_told(event, story):
    """Steps in between and robots of other missions are passed over."""
    assert [] == list(story.on_event(2.5, event))


@pytest.mark.parametrize(
    ("status", "hands_over"),
    [(4, True), (5, True), (6, True)],
)
def test_the_end_of_a_goal_hands_over(status, hands_over, story):
    """When a goal has ended it is the tree's turn."""
    (line,) = story.on_event(2.5, GoalStatusChanged(*GOAL, status))

    assert hands_over == line.hands_over


def test_the_begin_of_a_behaviour_hands_over(story):
    """When a behaviour has begun it is the world's turn; when it is done the tree goes on."""
    lines = [*story.ticked(tree("RUNNING")), *story.ticked(tree("SUCCESS"))]

    assert [True, False] == [line.hands_over for line in lines]


def test_a_line_for_programs(story):
    """A line has its time in milliseconds."""
    (line,) = story.on_event(2.5, ItemPicked(*LINEN))

    assert {"sim_time": 2.5, "source": "world", "robot": "eve", "text": "picks up linen"} == line.to_json()


def test_goals_are_counted(story):
    """Goals that succeeded and that did not are counted apart."""
    for status in (1, 2, 4, 4, 5, 6):
        list(story.on_event(2.5, GoalStatusChanged(*GOAL, status)))

    assert (2, 2) == (story.robots["eve"].succeeded, story.robots["eve"].failed)


def test_distance_is_what_was_driven(story):
    """A piece of a route that was broken off counts as far as it was driven."""
    list(story.on_event(0.0, MotionBegan("eve", (0.0, 0.0, 0.0), (3.0, 4.0, 0.0), 5.0, None)))
    list(story.on_event(5.0, MotionBegan("eve", (3.0, 4.0, 0.0), (3.0, 14.0, 0.0), 10.0, None)))
    list(story.on_event(7.0, Stopped("eve", (3.0, 6.0))))

    assert 7.0 == story.robots["eve"].distance


def test_a_way_told_at_once_counts_as_far_as_it_was_driven(story):
    """Stopped on its second lane, of which it has driven a half."""
    back = {"from": [8.0, 0.0, 0.0], "to": [0.0, 0.0, 0.0], "duration": 8.0, "lane": None}
    list(story.on_event(0.0, MotionBegan("eve", (0.0, 0.0, 0.0), (8.0, 0.0, 0.0), 8.0, None, then=(back, back))))
    list(story.on_event(12.0, Stopped("eve", (4.0, 0.0))))

    assert 12.0 == story.robots["eve"].distance


def test_items_are_moved_once_they_lie(story):
    """An item that is carried has not been moved yet."""
    list(story.on_event(2.5, ItemPicked(*LINEN)))
    carried = story.robots["eve"].carries, list(story.robots["eve"].moved)
    list(story.on_event(2.5, ItemPlaced(*LINEN, (1.0, 2.0))))

    assert ("linen", []) == carried
    assert ("", ["linen"]) == (story.robots["eve"].carries, story.robots["eve"].moved)


def test_a_behaviour_is_told_when_it_begins_and_ends(story):
    """A tree that is shown again tells only what is new, and of leaves only."""
    told = [
        [line.text for line in story.ticked(one)]
        for one in (
            tree("RUNNING", "INVALID"),
            tree("RUNNING", "INVALID"),
            tree("SUCCESS", "RUNNING"),
            tree("SUCCESS", "FAILURE", root="FAILURE"),
        )
    ]

    assert [["leaf 0 begun"], [], ["leaf 0 done", "leaf 1 begun"], ["leaf 1 failed: why"]] == told


def test_what_a_robot_does(story):
    """The running behaviour is what the robot does; at the end its mission is done."""
    list(story.ticked(tree("RUNNING")))
    meanwhile = story.robots["eve"].does
    list(story.ticked(tree("SUCCESS", root="SUCCESS")))

    assert ("leaf 0", "mission done") == (meanwhile, story.robots["eve"].does)


def test_sum(story):
    """The sum is there for programs, too."""
    list(story.on_event(2.5, GoalStatusChanged(*GOAL, 4)))

    assert {
        "eve": {"type": "courier", "succeeded": 1, "failed": 0, "distance": 0.0, "items_moved": []}
    } == story.to_json()
