"""The page of a report."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest

from hmrsim.report import of_trace, report_of
from hmrsim.report.charts import timeline_of
from hmrsim.report.model import Error
from hmrsim.report.page import page_of
from tests.unit.hmrsim.report.worlds import ALONE, FAULTY, MEETING

EVIL = "</style></title><script>alert(1)</script>"


class _Elements(HTMLParser):
    """Collects the elements of a page."""

    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def _elements(page):
    parser = _Elements()
    parser.feed(page)
    return parser.found


@pytest.fixture
def page(told):
    """Return the function that runs a world and returns its page."""

    def make(world, **run):
        found = told(world, **run)
        return page_of(report_of(found), found.definition)

    return make


def test_the_page_loads_nothing(page):
    found = _elements(page(MEETING))
    links = [value for _, attrs in found for name, value in attrs.items() if name in ("src", "href", "data", "action")]

    assert all(link.startswith("#") for link in links)
    assert "default-src 'none'" in next(attrs["content"] for tag, attrs in found if "http-equiv" in attrs)
    assert "url(" not in page(MEETING)


def test_the_timeline_has_a_bar_per_goal_and_per_wait(page):
    found = _elements(page(MEETING))
    classes = [attrs.get("class", "") for tag, attrs in found if tag == "rect"]

    assert (3, 1) == (classes.count("g succeeded") - _throughput_bars(found), classes.count("w way"))


def _throughput_bars(found):
    """Return the number of bars of the throughput, which look like goals."""
    heights = [attrs for tag, attrs in found if tag == "rect" and attrs.get("class") == "g succeeded"]
    return sum(attrs["height"] not in ("11", "5") for attrs in heights)


@pytest.mark.parametrize("exact", [True, False])
def test_names_and_errors_are_text(trace, changed, exact):
    world = FAULTY | {
        "name": EVIL,
        "places": {EVIL: {"at": [2, 0]}},
        "items": {EVIL[:90]: {"at": [1, 1]}},
        "faults": [FAULTY["faults"][0] | {"name": "flat_tyre"}],
    }
    lines = trace(world, until=4.0)
    if not exact:
        lines = [
            line.replace("wall_e has broken", "<img src=x onerror=alert(2)> has broken") for line in changed(lines)
        ]
        lines = [line.replace('"robot":"wall_e"', '"robot":"<script>alert(3)</script>"') for line in lines]
    told = of_trace(lambda: lines)[0]
    page = page_of(report_of(told), told.definition)
    found = _elements(page)

    assert ["script"] == [tag for tag, _ in found if tag in ("script", "img")]
    assert "alert(1)" in page
    assert not [name for _, attrs in found for name in attrs if name.startswith("on")]
    assert exact or "&lt;img src=x onerror=alert(2)&gt;" in page


def test_the_page_is_reproducible(page):
    assert page(MEETING) == page(MEETING)


def test_tables_have_captions_and_headings(page):
    """Screen readers announce the captions and headings."""
    text = page(FAULTY, until=4.0)

    assert text.count("<table>") == text.count("<caption") == text.count("<thead>")
    assert re.search(r'<th scope="row">wall_e', text)


def test_the_map_of_a_world_without_lanes_has_the_driven_routes(page):
    world = {"name": "open", "robots": {"wall_e": {"type": "carrier", "at": [0, 0], "script": ["Wait 1"]}}}

    assert 'class="map"' in page(world)


def test_an_empty_run_has_a_page(page):
    text = page({"name": "empty"})

    assert "No robot waited." in text
    assert "No goal was aborted or rejected." in text


def test_missing_data_is_reported_at_the_top(trace, changed):
    lines = changed(trace(ALONE))
    told = of_trace(lambda: lines)[0]

    assert '<p class="warning">The trace could not be replayed exactly' in page_of(report_of(told), told.definition)


def test_too_many_goals_are_drawn_together_with_a_notice(told):
    found = report_of(told(ALONE))
    (goal, *_) = found.goals
    many = [goal.model_copy(update={"accepted": i / 2500, "ended": (i + 1) / 2500}) for i in range(25_000)]
    timeline = timeline_of(found.model_copy(update={"goals": tuple(many)}))

    assert timeline.together > 0
    assert timeline.rows[0].svg.count('class="g ') <= 20_000


def test_the_timeline_has_a_mark_for_rejected_goals(told):
    found = report_of(told(ALONE))
    name, length = found.robots[0].name, found.summary.sim_time
    rejected = Error.model_construct(robot=name, status="REJECTED")
    times = (0.0, length / 2, length / 2 + 1e-6, length)
    errors = tuple(rejected.model_copy(update={"at": at}) for at in times)
    svg = timeline_of(found.model_copy(update={"errors": errors})).rows[0].svg

    assert 'class="g rejected mark" d="M0 2v5M5000 2v5M9980 2v5"' in svg
    assert f"goals rejected 4 times, from 0.0 to {length:.1f} s" in svg


def test_a_name_is_no_markup_in_the_map(page):
    text = page(ALONE | {"places": {"<b>here</b>": {"at": [1, 1]}}})

    assert "<b>here" not in text
    assert "&lt;b&gt;here&lt;/b&gt;" in text
