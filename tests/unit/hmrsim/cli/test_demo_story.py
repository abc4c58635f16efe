"""The story of the demo."""

from __future__ import annotations

import pytest

from hmrsim.cli.demo_story import CausalOrder, Line, Story
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
def test_events_are_lines(event, robot, text, story):
    """An event is a line with time and robot."""
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
def test_omitted_events(event, story):
    """Intermediate steps and robots of other missions are omitted."""
    assert [] == list(story.on_event(2.5, event))


@pytest.mark.parametrize(
    ("status", "hands_over"),
    [(4, True), (5, True), (6, True)],
)
def test_the_end_of_a_goal_hands_over(status, hands_over, story):
    """After the end of a goal, the tree's line follows."""
    (line,) = story.on_event(2.5, GoalStatusChanged(*GOAL, status))

    assert hands_over == line.hands_over


def test_the_begin_of_a_behaviour_hands_over(story):
    """After the beginning of a behavior, the world's line follows; after its end, the tree's next line."""
    lines = [*story.ticked(tree("RUNNING")), *story.ticked(tree("SUCCESS"))]

    assert [True, False] == [line.hands_over for line in lines]


def test_a_line_for_programs(story):
    """A line has its time in milliseconds."""
    (line,) = story.on_event(2.5, ItemPicked(*LINEN))

    assert {"sim_time": 2.5, "source": "world", "robot": "eve", "text": "picks up linen"} == line.to_json()


def test_goals_are_counted(story):
    """Successful and failed goals are counted separately."""
    for status in (1, 2, 4, 4, 5, 6):
        list(story.on_event(2.5, GoalStatusChanged(*GOAL, status)))

    assert (2, 2) == (story.robots["eve"].succeeded, story.robots["eve"].failed)


def test_an_interrupted_motion(story):
    """An interrupted motion counts up to where it stopped."""
    list(story.on_event(0.0, MotionBegan("eve", (0.0, 0.0, 0.0), (3.0, 4.0, 0.0), 5.0, None)))
    list(story.on_event(5.0, MotionBegan("eve", (3.0, 4.0, 0.0), (3.0, 14.0, 0.0), 10.0, None)))
    list(story.on_event(7.0, Stopped("eve", (3.0, 6.0))))

    assert 7.0 == story.robots["eve"].distance


def test_an_interrupted_motion_over_two_lanes(story):
    """A motion that stops halfway on its second lane counts one and a half lanes."""
    back = {"from": [8.0, 0.0, 0.0], "to": [0.0, 0.0, 0.0], "duration": 8.0, "lane": None}
    list(story.on_event(0.0, MotionBegan("eve", (0.0, 0.0, 0.0), (8.0, 0.0, 0.0), 8.0, None, then=(back, back))))
    list(story.on_event(12.0, Stopped("eve", (4.0, 0.0))))

    assert 12.0 == story.robots["eve"].distance


def test_items_are_moved_once_they_are_put_down(story):
    """A carried item counts as moved once it is put down."""
    list(story.on_event(2.5, ItemPicked(*LINEN)))
    carried = story.robots["eve"].carries, list(story.robots["eve"].moved)
    list(story.on_event(2.5, ItemPlaced(*LINEN, (1.0, 2.0))))

    assert ("linen", []) == carried
    assert ("", ["linen"]) == (story.robots["eve"].carries, story.robots["eve"].moved)


def test_a_behavior_is_a_line_when_it_begins_and_ends(story):
    """Only changes of leaves are lines."""
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
    """The table shows the running behavior, and at the end that the mission is done."""
    list(story.ticked(tree("RUNNING")))
    meanwhile = story.robots["eve"].does
    list(story.ticked(tree("SUCCESS", root="SUCCESS")))

    assert ("leaf 0", "mission done") == (meanwhile, story.robots["eve"].does)


def test_summary_as_json(story):
    """The summary is also available as JSON values."""
    list(story.on_event(2.5, GoalStatusChanged(*GOAL, 4)))

    assert {
        "eve": {"type": "courier", "succeeded": 1, "failed": 0, "distance": 0.0, "items_moved": []}
    } == story.to_json()


BEGUN = Line(1.0, "tree", "eve", "begun", hands_over=True)
ACCEPTED = Line(1.1, "world", "eve", "accepted")
SUCCEEDED = Line(2.05, "world", "eve", "SUCCEEDED", hands_over=True)
DONE = Line(2.0, "tree", "eve", "done")
AGAIN = Line(2.0, "tree", "eve", "begun again", hands_over=True)
ELSEWHERE = Line(9.0, "tree", "wall_e", "elsewhere")


@pytest.fixture
def tell():
    """Return the function that adds lines at 10 s and returns those that are ready at a time."""
    turns = CausalOrder(patience=0.5)

    def run(*lines, at=10.0):
        for line in lines:
            turns.add(line, 10.0)
        return list(turns.ready(at))

    return run


@pytest.mark.parametrize(
    "lines",
    [
        [BEGUN, ACCEPTED, SUCCEEDED, DONE, AGAIN],
        [ACCEPTED, BEGUN, SUCCEEDED, DONE, AGAIN],
        [ACCEPTED, SUCCEEDED, BEGUN, DONE, AGAIN],
        [BEGUN, DONE, AGAIN, ACCEPTED, SUCCEEDED],
    ],
)
def test_causes_come_first(lines, tell):
    """Lines are in causal order, however they arrive."""
    told = [line.text for line in tell(*lines)]

    assert ["begun", "accepted", "SUCCEEDED", "done", "begun again"] == told


def test_times_never_go_back(tell):
    """If the controller's clock lags, its lines get the time of the event before them."""
    told = [line.sim_time for line in tell(BEGUN, ACCEPTED, SUCCEEDED, DONE)]

    assert [1.0, 1.1, 2.05, 2.05] == told


def test_an_unknown_time(tell):
    """A controller that has not received the clock yet reports no time."""
    (line,) = tell(BEGUN._replace(sim_time=None))

    assert line.sim_time is None


def test_robots_do_not_wait_for_each_other(tell):
    """Lines of other robots are not delayed."""
    told = [(line.text, line.sim_time) for line in tell(ACCEPTED, ELSEWHERE, BEGUN)]

    assert [("elsewhere", 9.0), ("begun", 1.0), ("accepted", 1.1)] == told


def test_patience_has_an_end(tell):
    """A behavior may end without an event of the world, as when its goal is rejected."""
    waiting = tell(BEGUN, DONE)
    later = tell(at=10.5)

    assert (["begun"], ["done"]) == ([line.text for line in waiting], [line.text for line in later])
