"""The story of the demo, and its live table."""

from __future__ import annotations

import io
import math

import pytest

from hmrsim.cli.demo_screen import CausalOrder, JsonLines, Line, Screen, Story
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.events.robots import ItemPicked, ItemPlaced, MotionBegan, Stopped
from hmrsim.events.simulation import SimulationReset

GOAL = ("eve", "wait", "1" * 32)
LINEN = ("eve", "linen")
ENDS = ("SUCCESS", "FAILURE")


def tree(*statuses, root="RUNNING"):
    leaves = [
        {"depth": 1, "name": f"leaf {i}", "status": status, "message": "why"} for i, status in enumerate(statuses)
    ]
    nodes = [{"depth": 0, "name": "root", "status": root, "message": ""}, *leaves]
    return {"robot": "eve", "sim_time": 3.0, "status": root, "nodes": nodes}


@pytest.fixture
def story():
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
def test_an_event_is_a_line_with_time_and_robot(event, robot, text, story):
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
def test_intermediate_steps_and_other_missions_are_omitted(event, story):
    assert [] == list(story.on_event(2.5, event))


@pytest.mark.parametrize("status", [4, 5, 6])
def test_the_line_of_the_tree_follows_the_end_of_its_goal(status, story):
    (line,) = story.on_event(2.5, GoalStatusChanged(*GOAL, status))

    assert line.hands_over


def test_the_line_of_the_world_follows_the_begin_of_its_behavior(story):
    lines = [*story.ticked(tree("RUNNING")), *story.ticked(tree("SUCCESS"))]

    assert [True, False] == [line.hands_over for line in lines]


def test_a_line_as_json(story):
    (line,) = story.on_event(2.5, ItemPicked(*LINEN))

    assert {"sim_time": 2.5, "source": "world", "robot": "eve", "text": "picks up linen"} == line.to_json()


def test_goals_are_counted(story):
    for status in (1, 2, 4, 4, 5, 6):
        list(story.on_event(2.5, GoalStatusChanged(*GOAL, status)))

    assert (2, 2) == (story.robots["eve"].succeeded, story.robots["eve"].failed)


def test_an_interrupted_motion_counts_its_part(story):
    list(story.on_event(0.0, MotionBegan("eve", (0.0, 0.0, 0.0), (3.0, 4.0, 0.0), 5.0, None)))
    list(story.on_event(5.0, MotionBegan("eve", (3.0, 4.0, 0.0), (3.0, 14.0, 0.0), 10.0, None)))
    list(story.on_event(7.0, Stopped("eve", (3.0, 6.0))))

    assert 7.0 == story.robots["eve"].distance


def test_an_interrupted_motion_over_two_lanes(story):
    back = {"from": [8.0, 0.0, 0.0], "to": [0.0, 0.0, 0.0], "duration": 8.0, "lane": None}
    list(story.on_event(0.0, MotionBegan("eve", (0.0, 0.0, 0.0), (8.0, 0.0, 0.0), 8.0, None, then=(back, back))))
    list(story.on_event(12.0, Stopped("eve", (4.0, 0.0))))

    assert 12.0 == story.robots["eve"].distance


def test_items_count_as_moved_once_put_down(story):
    list(story.on_event(2.5, ItemPicked(*LINEN)))
    carried = story.robots["eve"].carries, list(story.robots["eve"].moved)
    list(story.on_event(2.5, ItemPlaced(*LINEN, (1.0, 2.0))))

    assert ("linen", []) == carried
    assert ("", ["linen"]) == (story.robots["eve"].carries, story.robots["eve"].moved)


def test_a_behavior_is_a_line_when_it_begins_and_ends(story):
    reported = [
        [line.text for line in story.ticked(one)]
        for one in (*[tree("RUNNING", "INVALID")] * 2, tree("SUCCESS", "RUNNING"), tree(*ENDS, root="FAILURE"))
    ]

    assert [["leaf 0 begun"], [], ["leaf 0 done", "leaf 1 begun"], ["leaf 1 failed: why"]] == reported


def test_the_table_shows_the_running_behavior(story):
    list(story.ticked(tree("RUNNING")))
    meanwhile = story.robots["eve"].does
    list(story.ticked(tree("SUCCESS", root="SUCCESS")))

    assert ("leaf 0", "mission done") == (meanwhile, story.robots["eve"].does)


def test_summary_as_json(story):
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
    turns = CausalOrder(patience=0.5, hold=0.0)

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
def test_lines_are_in_causal_order(lines, tell):
    reported = [line.text for line in tell(*lines)]

    assert ["begun", "accepted", "SUCCEEDED", "done", "begun again"] == reported


def test_at_the_end_the_lines_that_still_wait_are_in_causal_order():
    """A mission may end before any of the world's lines has come."""
    turns = CausalOrder(patience=0.5, hold=0.0)
    for line in (BEGUN, DONE, AGAIN, ACCEPTED, SUCCEEDED):
        turns.add(line, 10.0)

    reported = [line.text for line in turns.ready(math.inf)]
    assert ["begun", "accepted", "SUCCEEDED", "done", "begun again"] == reported


def test_times_never_go_back(tell):
    """If the controller's clock lags, its lines get the time of the event before them."""
    reported = [line.sim_time for line in tell(BEGUN, ACCEPTED, SUCCEEDED, DONE)]

    assert [1.0, 1.1, 2.05, 2.05] == reported


def test_a_controller_without_a_clock_reports_no_time(tell):
    (line,) = tell(BEGUN._replace(sim_time=None))

    assert line.sim_time is None


def test_robots_do_not_wait_for_each_other(tell):
    reported = [(line.text, line.sim_time) for line in tell(ACCEPTED, ELSEWHERE, BEGUN)]

    assert [("begun", 1.0), ("accepted", 1.1), ("elsewhere", 9.0)] == reported


def test_lines_are_in_the_order_of_time():
    """A line that arrives within the hold of a later one comes before it; one that arrives after it has its time."""
    order = CausalOrder(patience=0.5, hold=0.5)
    early, late = (Line(time, "tree", "hal", str(time)) for time in (1.0, 2.0))
    order.add(ELSEWHERE, 10.0)
    held = [*order.ready(10.0)]
    order.add(early, 10.4)
    told = [*order.ready(10.9)]
    order.add(late, 11.0)
    told += order.ready(12.0)

    assert [] == held
    assert [("1.0", 1.0), ("elsewhere", 9.0), ("2.0", 9.0)] == [(line.text, line.sim_time) for line in told]


@pytest.mark.parametrize(
    ("event", "detail"),
    [
        (GoalAccepted(*GOAL, {"time": {"sec": 5}}), True),
        (GoalStatusChanged(*GOAL, 4), False),
        (GoalStatusChanged(*GOAL, 6, {"error_msg": "no"}), False),
        (ItemPicked(*LINEN), True),
        (SimulationReset(255), True),
    ],
)
def test_the_short_log_has_the_ends_of_goals(event, detail, story):
    """Everything else of the world is a detail, except for warnings and errors."""
    (line,) = story.on_event(2.5, event)

    assert detail == line.detail


def test_a_line_waits_only_for_a_limited_time(tell):
    """A behavior may end without an event of the world, such as when its goal is rejected."""
    waiting = tell(BEGUN, DONE)
    later = tell(at=10.5)

    assert (["begun"], ["done"]) == ([line.text for line in waiting], [line.text for line in later])


STORY = Story({"wall_e": "nurse"})


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_log_lines_are_above_the_live_table(capsys):
    out = Terminal()
    screen = Screen(out)
    with screen.opened(STORY):
        screen.log("[INFO] simulator: [red]hello")

    assert "[INFO] simulator: [red]hello" in out.getvalue()
    assert "" == capsys.readouterr().err


def test_the_live_table_shows_what_each_robot_does():
    out = Terminal()
    story = Story({"wall_e": "nurse"})
    robot = story.robots["wall_e"]
    robot.does, robot.distance, robot.carries = "Go to pharmacy", 9.53, "medicine"
    screen = Screen(out)
    with screen.opened(story):
        screen.refresh()

    (row,) = {line.strip() for line in out.getvalue().splitlines() if "pharmacy" in line}
    assert ["wall_e", "nurse", "Go", "to", "pharmacy", "9.5", "medicine"] == row.split()


@pytest.mark.parametrize("screen", [Screen(io.StringIO()), JsonLines()], ids=["text", "json"])
def test_log_lines_go_to_stderr(screen, capsys):
    with screen.opened(STORY):
        screen.log("hello")

    assert ("", "hello\n") == capsys.readouterr()


def test_details_are_only_in_json(capsys):
    lines = [Line(1.0, "world", "wall_e", "accepted", detail=True), Line(2.0, "world", "wall_e", "SUCCEEDED")]
    out = io.StringIO()
    for screen in (Screen(out), JsonLines()):
        for line in lines:
            screen.show(line)

    assert ["SUCCEEDED"] == [line.rpartition("| ")[2] for line in out.getvalue().splitlines()]
    assert 2 == len(capsys.readouterr().out.splitlines())
