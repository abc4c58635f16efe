"""The displays of worlds and runs in notebooks."""

from __future__ import annotations

import html

import pytest

from hmrsim.errors import TraceError
from hmrsim.notebook import draw, report
from hmrsim.testing import simulation


def test_a_map_is_a_picture_with_optional_names():
    assert ">terrace</text>" in draw("cafe")._repr_svg_()
    assert ">terrace</text>" not in draw("cafe", names=False)._repr_svg_()


def test_the_report_of_a_run_is_a_page_in_a_frame(tmp_path):
    with simulation("cafe") as run:
        run.commander("mocha").navigate_to("table_1")
    file = tmp_path / "run.jsonl"
    file.write_text(run.trace)
    shown = report(run.trace)

    assert shown == report(file)
    assert shown._repr_html_().startswith(f'<iframe srcdoc="{html.escape(shown.html[:40])}')
    assert "navigate_to_pose" in shown.html


def test_a_file_that_is_no_trace_is_an_error():
    with pytest.raises(TraceError):
        report("nothing\n")
