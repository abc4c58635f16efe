"""Trees on a terminal, whatever its size."""

from __future__ import annotations

import io

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Sequence
from rich.console import Console

from bt_controller.loading.trees import Plan
from bt_controller.running.mission import Mission
from bt_controller.running.snapshot import ASCII
from bt_controller.watching.live_display import LiveDisplay


class Step(Behaviour):
    """Has always the same status, and nothing to say."""

    def __init__(self, name, outcome):
        super().__init__(name)
        self.outcome = outcome

    def update(self):
        return self.outcome


def steps(*outcomes):
    """Return what makes a tree of a sequence of steps."""

    def tree(robot):
        children = [Step(f"Step {number}", outcome) for number, outcome in enumerate(outcomes, 1)]
        return Sequence(f"Mission of {robot}", memory=True, children=children)

    return tree


RUNS = steps(Status.SUCCESS, Status.RUNNING, Status.SUCCESS)
SUCCEEDS = steps(Status.SUCCESS)
FAILS = steps(Status.SUCCESS, Status.FAILURE)


@pytest.fixture
def screen():
    """Return what shows robots and their trees, ticked once at 1.5 s, on a terminal of some height."""

    def show(height, **trees):
        display = LiveDisplay()
        for robot, function in trees.items():
            mission = Mission(robot, Plan("test", function, takes_robot=True, confirmed=False))
            mission.tick(1.5)
            display.ticked(mission, 1.5)
        return display.text(height).plain.splitlines()

    return show


def test_all_trees_are_whole_where_they_fit(screen):
    assert [
        "wall_e at 1.500 s",
        "{-} Mission of wall_e [✓]",
        "    --> Step 1 [✓]",
        "eve at 1.500 s",
        "{-} Mission of eve [*]",
        "    --> Step 1 [✓]",
        "    --> Step 2 [*]",
        "    --> Step 3 [-]",
    ] == screen(24, wall_e=SUCCEEDS, eve=RUNS)


def test_what_does_not_fit_is_a_line(screen):
    assert [
        "eve at 1.500 s",
        "{-} Mission of eve [*]",
        "    --> Step 1 [✓]",
        "    --> Step 2 [*]",
        "    --> Step 3 [-]",
        "m_o    [*] Step 2",
        "auto   [✕] Step 2",
        "wall_e [✓] Mission of wall_e",
    ] == screen(9, wall_e=SUCCEEDS, eve=RUNS, auto=FAILS, m_o=RUNS)


def test_robots_that_do_not_fit_are_counted(screen):
    trees = {f"r{number}": RUNS for number in range(4)}

    assert ["r0 [*] Step 2", "r1 [*] Step 2", "… and 4 more: 2 running, 1 succeeded, 1 failed"] == screen(
        4, **trees, s=SUCCEEDS, f=FAILS
    )


def test_of_a_tree_that_is_too_high_what_is_over_is_folded(screen):
    def tree(robot):
        first = Sequence("First", memory=True, children=[Step("A", Status.SUCCESS), Step("B", Status.SUCCESS)])
        then = Sequence("Then", memory=True, children=[Step("C", Status.RUNNING), Step("D", Status.SUCCESS)])
        return Sequence(robot, memory=True, children=[first, then])

    assert [
        "eve at 1.500 s",
        "{-} eve [*]",
        "    {-} First … [✓]",
        "    {-} Then [*]",
        "        --> C [*]",
        "        --> D [-]",
    ] == screen(7, eve=tree)


def test_of_a_terminal_of_four_lines_the_end_of_the_way_is_left(screen):
    assert ["eve at 1.500 s", "{-} Mission of eve [*]", "    --> Step 2 [*]"] == screen(4, eve=RUNS)


def test_in_the_end_there_is_room_for_the_outcome(screen):
    assert ["wall_e [✓] Mission of wall_e", "eve    [✓] Mission of eve"] == screen(5, wall_e=SUCCEEDS, eve=SUCCEEDS)


def drawn(display, *, width, encoding="utf-8"):
    """Return what a terminal of five lines gets."""
    out = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    Console(file=out, width=width, height=5).print(display)
    out.flush()
    return out.buffer.getvalue().decode(encoding).splitlines()


@pytest.mark.parametrize(
    ("symbols", "encoding", "line"),
    [({}, "utf-8", "{-} Mission of wal…"), ({"symbols": ASCII}, "ascii", "{-} Mission of wall")],
)
def test_long_lines_are_cut(symbols, encoding, line):
    """A line that were broken would shift all that is below."""
    display = LiveDisplay(**symbols)
    mission = Mission("wall_e", Plan("test", SUCCEEDS, takes_robot=True, confirmed=False))
    mission.tick(None)
    display.ticked(mission, None)

    assert ["wall_e", line] == drawn(display, width=19, encoding=encoding)[:2]


def test_a_tree_that_was_stopped_is_shown_as_it_was():
    display = LiveDisplay()
    mission = Mission("wall_e", Plan("test", RUNS, takes_robot=True, confirmed=False))
    mission.tick(1.5)
    display.ticked(mission, 1.5)
    before = display.text(24)
    mission.interrupt()
    display.ticked(mission, 1.5)

    assert before == display.text(24)


class Prints(Behaviour):
    """Has the terminal drawn anew while it is ticked, as a behavior that prints does."""

    def __init__(self, display):
        super().__init__("Prints")
        self.display = display
        self.seen = []

    def update(self):
        self.seen.append(self.display.text(24).plain)
        return Status.RUNNING


def test_a_behaviour_may_print():
    display = LiveDisplay()
    leaf = Prints(display)
    mission = Mission("wall_e", Plan("test", lambda: leaf, takes_robot=False, confirmed=False))
    for now in (1.5, 2.5):
        mission.tick(now)
        display.ticked(mission, now)

    assert ["", "wall_e at 1.500 s\n--> Prints [*]"] == leaf.seen
    assert "wall_e at 2.500 s\n--> Prints [*]" == display.text(24).plain
