"""What notebooks show."""

from __future__ import annotations

import html

import pytest

from hmrsim.errors import TraceError
from hmrsim.notebook import draw, report
from hmrsim.testing import simulation


def test_a_map_is_a_picture():
    """With the names of places, unless they are not wanted."""
    assert ">terrace</text>" in draw("cafe")._repr_svg_()
    assert ">terrace</text>" not in draw("cafe", names=False)._repr_svg_()


def test_the_report_of_a_run_is_a_page_in_a_frame(tmp_path):
    """The same from the text of a trace and from its file; what is in it is escaped."""
    with simulation("cafe") as run:
        run.commander("mocha").navigate_to("table_1")
    file = tmp_path / "run.jsonl"
    file.write_text(run.trace)
    shown = report(run.trace)

    assert shown == report(file)
    assert shown._repr_html_().startswith(f'<iframe srcdoc="{html.escape(shown.html[:40])}')
    assert "navigate_to_pose" in shown.html


def test_what_is_no_trace_is_told():
    """As by the command."""
    with pytest.raises(TraceError):
        report("nothing\n")
