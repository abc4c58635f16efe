"""The output of the demo."""

from __future__ import annotations

import io

import pytest

from hmrsim.cli.demo_screen import JsonLines, Screen
from hmrsim.cli.demo_story import Story

STORY = Story({"wall_e": "nurse"})


class Terminal(io.StringIO):
    """What says that it is one."""

    def isatty(self):
        """Return True."""
        return True


def test_log_lines_are_above_the_live_table(capsys):
    """Log lines are printed above the table."""
    out = Terminal()
    screen = Screen(out)
    with screen.opened(STORY):
        screen.log("[INFO] simulator: [red]hello")

    assert "[INFO] simulator: [red]hello" in out.getvalue()
    assert "" == capsys.readouterr().err


def test_the_live_table_shows_what_each_robot_does():
    """The table has one line per robot during the mission."""
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
    """Without a live table, log lines go to stderr."""
    with screen.opened(STORY):
        screen.log("hello")

    assert ("", "hello\n") == capsys.readouterr()
