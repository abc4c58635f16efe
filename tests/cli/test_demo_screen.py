"""Where a demo shows its mission."""

from __future__ import annotations

import io

import pytest

from hmrsim.cli.demo_screen import JsonLines, Screen


class Terminal(io.StringIO):
    """What says that it is one."""

    def isatty(self):
        """Return that it is."""
        return True


def test_log_lines_stand_above_the_live_table(capsys):
    """They go where the table is, through what draws it."""
    out = Terminal()
    screen = Screen(out)
    with screen.opened():
        screen.log("[INFO] simulator: [red]hello")

    assert "[INFO] simulator: [red]hello" in out.getvalue()
    assert "" == capsys.readouterr().err


@pytest.mark.parametrize("screen", [Screen(io.StringIO()), JsonLines()], ids=["text", "json"])
def test_log_lines_are_no_result(screen, capsys):
    """Without a live table they go to stderr."""
    with screen.opened():
        screen.log("hello")

    assert ("", "hello\n") == capsys.readouterr()
