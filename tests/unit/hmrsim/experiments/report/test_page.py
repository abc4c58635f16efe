"""The page of an experiment's report."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest

from hmrsim.experiments.report import page_of, summary_of
from hmrsim.experiments.report.model import Estimate, Point
from hmrsim.experiments.report.page import (
    Axis,
    axis_of,
    figure,
    histogram_chart,
    interval_chart,
    points,
    running_chart,
    ticks_of,
)
from hmrsim.experiments.store import Row
from hmrsim.report.html import UNKNOWN
from tests.unit.hmrsim.experiments.report.conftest import TREE, times

EVIL = "</style></title><script>alert(1)</script>"


class _Elements(HTMLParser):
    """Collects the elements of a page, and checks that they are nested."""

    def __init__(self):
        super().__init__()
        self.found, self._open = [], []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        if tag not in ("meta", "link", "br"):
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        """Check that it was the last that began."""
        assert tag == self._open.pop()


def elements(page):
    parser = _Elements()
    parser.feed(page)
    assert [] == parser._open
    return parser.found


def headings(page):
    return re.findall(r"<h2>(.*?)</h2>", page)


@pytest.fixture
def page(results):
    """Return a function that makes the page of made-up results."""

    def make(made=times, **changes):
        return page_of(summary_of(results(made, **changes)), "results")

    return make


def test_page_loads_nothing(page):
    found = elements(page())
    links = [value for _, attrs in found for name, value in attrs.items() if name in ("src", "href", "data", "action")]

    assert all(link.startswith("#") for link in links)
    assert {attrs.get("id") for _, attrs in found} >= {link[1:] for link in links}
    policy = next(attrs["content"] for tag, attrs in found if "http-equiv" in attrs)
    assert policy == "default-src 'none'; style-src 'unsafe-inline'; script-src 'none'"
    assert "url(" not in page()
    assert "script" not in {tag for tag, _ in found}


def test_page_has_all_sections(page):
    assert [
        "Treatments",
        "Comparisons",
        "Measures",
        "Factors",
        "Endings",
        "Runs that differ",
        "Runs without success",
        "The experiment&#39;s file",
    ] == [each.replace("'", "&#39;") for each in headings(page())]


def test_escapes_texts_of_users(page):
    def made(run, _levels):
        return Row(run, "crashed", EVIL)

    found = page(made, factors={"speed": ["<b>x</b>", EVIL]})

    assert EVIL not in found
    assert "&lt;script&gt;alert(1)" in found
    assert "script" not in {tag for tag, _ in elements(found)}


def test_page_says_how_to_repeat_runs(page):
    def made(run, levels):
        return Row(run, "timeout", "it is late") if run.number == 5 else times(run, levels)

    found = page(made)

    assert "<code>hmrsim experiment run pace_0.yaml -o results</code>" in found
    assert "<code>hmrsim experiment again results 5 --trace run_5.jsonl</code>" in found
    assert "it is late" in found


def test_page_without_runs(page):
    found = page(lambda _run, _levels: None)

    assert "No run has a result yet." in found
    assert [
        "Treatments",
        "Comparisons",
        "Runs that differ",
        "Runs without success",
        "The experiment's file",
    ] == headings(found)
    elements(found)


def test_page_of_one_treatment_has_no_comparisons(page):
    found = page(treatments={"a": TREE})

    assert [
        "Treatments",
        "Measures",
        "Factors",
        "Endings",
        "Runs without success",
        "The experiment's file",
    ] == headings(found)
    elements(found)


def test_page_without_measures_or_factors_has_success(page):
    def made(run, _levels):
        return Row(run, "succeeded", success=True)

    found = page(made, measures={}, factors={}, replications=1)

    assert ["Treatments", "Comparisons", "Measures", "Endings"] == headings(found)[:4]
    assert "There is one replication" in found
    assert "All runs ended with a success." in found
    elements(found)


def test_measure_without_values_is_dashes(page):
    def made(run, _levels):
        return Row(run, "succeeded", success=True)

    found = page(made)

    assert f'<td class="n">{UNKNOWN}</td>' in found
    assert "time has no value in any run." in found
    assert not re.search(r"\b(nan|inf|None)\b", found)
    elements(found)


def test_page_of_huge_equal_and_single_values(page):
    values = {0: 1e99, 1: -1e99, 2: 1e-99, 4: 0.0}

    def made(run, _levels):
        return Row(run, "succeeded", success=True, measures={"time": values.get(run.number)})

    elements(page(made))
    elements(page(lambda run, _levels: Row(run, "succeeded", success=True, measures={"time": 1e15 + 0.25})))
    elements(page(lambda run, levels: times(run, levels) if run.number == 3 else None))


def test_single_value_is_a_point():
    estimate = Estimate(estimate=2.0, low=None, high=None, n=1)

    assert 'class="point" d="M500 12h0"' in interval_chart(estimate, Axis(1.0, 3.0), "a")
    assert "reach" not in interval_chart(estimate, Axis(1.0, 3.0), "a")


def test_interval_chart_has_the_positions_of_its_numbers():
    """On 0 … 10: from 2 to 4, with a margin around 5."""
    estimate = Estimate(estimate=3.0, low=2.0, high=4.0, n=9)
    found = interval_chart(estimate, Axis(0.0, 10.0), "a", line=5.0, margin=1.0)

    assert 'class="reach" d="M200 12H400"' in found
    assert 'class="point" d="M300 12h0"' in found
    assert 'class="margin" x="400" y="0" width="200"' in found


def test_bars_are_as_high_as_their_shares():
    found = histogram_chart([0.0, 1.0, 2.0, 3.0], [2, 0, 1], 2 / 3, "a")

    assert ["96", "48"] == re.findall(r'height="([\d.]+)"', found)
    assert "0 to 1: 2 runs, 66.7%" in found


def test_running_means_are_drawn_over_replications():
    given = [
        Point(replications=each, mean=Estimate(estimate=mean, low=mean - 1, high=mean + 1, n=each))
        for each, mean in ((1, 0.0), (2, 5.0), (3, 10.0))
    ]

    assert 'class="line" d="M0 100L150 50L300 0"' in running_chart(given, Axis(0.0, 10.0), 3, "a")


def test_ticks_are_round_numbers():
    assert [(0.0, "100"), (20.0, "120"), (40.0, "140"), (60.0, "160"), (80.0, "180"), (100.0, "200")] == [
        *ticks_of(Axis(100.0, 200.0))
    ]
    assert ["0", "0.2", "0.4", "0.6", "0.8", "1"] == [tick.text for tick in ticks_of(Axis(0.0, 1.0))]


def test_axis_of_equal_or_no_values_has_a_length():
    assert 0 < axis_of([3.0, 3.0]).high - axis_of([3.0]).low
    assert (-0.06, 1.06) == axis_of([None])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, UNKNOWN),
        (0.0, "0"),
        (-0.0, "0"),
        (1383.4, "1,383"),
        (175.507, "175.5"),
        (32.0, "32"),
        (0.012345, "0.01235"),
        (-2.5, "-2.5"),
        (123456.7, "123,457"),
        (9.9999, "10"),
        (1e-7, "1.000e-07"),
        (2.5e12, "2.500e+12"),
    ],
)
def test_numbers_have_four_digits(value, text):
    assert text == figure(value)


def test_differences_of_shares_are_signed_points():
    assert ["+1.4 %", "-10 %", "0 %", "0 %", UNKNOWN] == [points(each) for each in (0.0137, -0.1, 0.0, -0.0001, None)]
