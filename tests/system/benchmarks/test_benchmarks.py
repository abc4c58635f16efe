"""The benchmarks run and print their figures, at any speed of the machine."""

from __future__ import annotations

import importlib
import json
import pkgutil
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

import benchmarks
from benchmarks import _browser, _report
from benchmarks.__main__ import main
from benchmarks._report import Row
from benchmarks._spread import Spread
from benchmarks._timing import Rounds, Variant, interleaved
from tests.paths import ROOT

TINY = {
    "calls": {},
    "comparison": {"experiments": 20, "pairs": 20, "powered": 20, "effects": (0.9,)},
    "controller": {"sizes": (1, 3), "results": 24, "polled": 6, "runs": 1, "side": 4},
    "density": {
        "crowds": ((4, 20.0),),
        "side": 3,
        "racks": 1,
        "pickers": ((2, 60.0),),
        "shipped": (("zoo/crossing", 60.0),),
    },
    "experiments": {"replications": 1, "rounds": 1},
    "first_fleets": {"seeds": 4, "policies": ("planned",)},
    "goals_at_once": {"robots": 2, "rounds": 1, "side": 2},
    "fault_search": {"schedules": 8, "rounds": 1, "pairs": 1, "seeds": 1, "most": 8},
    "gym": {"rounds": 1, "horizon": 100.0},
    "in_process": {"rounds": 1, "runs": 1, "missions": 1},
    "properties": {"rounds": 1, "samples": 100, "missions": 1},
    "listeners": {"sizes": (3,), "rates": (10.0,), "window": 0.2, "robots": 3, "rounds": 1, "side": 4},
    "loading": {"side": 10, "lanes": 20, "walls": 3, "rounds": 1},
    "lockstep": {"sizes": (3,), "rounds": 10, "missions": 1, "factor": 100.0, "side": 4, "scripts": "zoo/crossing"},
    "mesa_agents": {"robots": 3, "rounds": 1, "seconds": 20.0, "side": 4},
    "memory": {"sizes": (2, 4), "side": 3},
    "perturbed": {"controllers": (2,), "runs": 3},
    "realtime": {"factors": (10.0,), "robots": 2, "window": 1.0},
    "recording": {"sizes": (3,), "seconds": 1.0, "side": 4},
    "roomy": {"robots": 3, "rounds": 1, "seconds": 0.01, "filling": 0.1, "side": 4},
    "ros2": {"rounds": 10, "side": 2},
    "ros2_fleet": {"fleets": (2,), "idle": 0.1, "side": 2, "commanded": 2},
    "scale": {"sizes": (1, 10), "window": 0.02, "side": 4},
    "scenario2": {"rounds": 2, "crowd": 3, "side": 4},
    "security": {"rounds": 1, "messages": 10},
    "start_up": {"rounds": 1},
    "traffic": {"rounds": 1, "seconds": 50.0, "robots": 4, "side": 4, "scripts": "zoo/crossing"},
    "view": {"sizes": (3,), "window": 0.5, "side": 4},
}

MAY_BE_NOTHING = {
    "passes",
    "% of experiments",
    "% of a core",
    "MB/1,000 robots",
    "% of goals",
    "% of the time",
    "a minute",
    "goals",
    "pairs",
    "robots",
}


def test_every_benchmark_is_tested():
    names = {info.name for info in pkgutil.iter_modules(benchmarks.__path__) if not info.name.startswith("_")}

    assert names == TINY.keys()


@pytest.mark.skipif(not Path("/proc/self/smaps_rollup").exists(), reason="reads Linux's /proc")
@pytest.mark.parametrize("name", TINY)
def test_each_row_of_a_benchmark_has_its_name_and_a_nonzero_figure(name, monkeypatch):
    monkeypatch.setattr("benchmarks._timing._TURN", 2)
    # That Dask gives the same results is tested with experiments.
    monkeypatch.delitem(importlib.import_module("benchmarks.experiments")._WHERE, "Dask, two workers")
    monkeypatch.setattr("benchmarks.listeners._EVENTS_A_ROUND", 100)
    monkeypatch.setattr("benchmarks.listeners._SETTLING", 0.1)
    monkeypatch.setattr("benchmarks.ros2._AT_ONCE", 10)
    monkeypatch.setattr("benchmarks.ros2._SPAN", 10.0)
    monkeypatch.setattr("benchmarks.traffic._MAX_SECONDS", 300.0)
    if name == "view" and not any(map(shutil.which, _browser.NAMES)):
        pytest.skip("it needs a browser")
    rows = importlib.import_module(f"benchmarks.{name}").run(**TINY[name])

    assert len(rows) == len({row.what for row in rows})
    assert [] == [row for row in rows if row.value <= 0 and row.unit not in MAY_BE_NOTHING]
    # Only ratios that any machine reaches are checked; other targets depend on speed.
    assert [] == [row for row in rows if "different" in row.what + row.unit and not row.met]


@pytest.mark.parametrize("name", TINY)
def test_a_benchmark_has_a_quick_form_and_a_place_in_the_docs(name):
    module = importlib.import_module(f"benchmarks.{name}")
    document = (ROOT / "docs" / "explanation" / "benchmarks.md").read_text()

    assert module.QUICK.keys() <= TINY[name].keys()
    assert f"<!-- begin {name} -->" in document
    assert f"<!-- end {name} -->" in document


def test_a_goal_within_one_process_takes_no_more_calls():
    """It also makes no more passes through JSON. Counts are exact, so a reduction should lower the limits.

    The process does nothing else, and has no other threads and children. Over Zenoh the counts are the
    mean of fifty goals, and for the environment the mean of an episode's decisions.
    """
    said = (
        "from benchmarks.calls import *\n"
        "cases = goal, tree, schedule, served_goal, experiment, decision\n"
        "print([[of.total, of.passes] for of in [case() for case in cases]])"
    )
    done = subprocess.run([sys.executable, "-c", said], cwd=ROOT, check=True, capture_output=True, text=True)
    counts = json.loads(done.stdout)

    limits = [[245, 0], [2_200, 4], [1_270, 4], [222, 3], [5_050, 12], [1_160, 1]]
    pairs = [pair for count, limit in zip(counts, limits, strict=True) for pair in zip(count, limit, strict=True)]
    assert [] == [(value, most) for value, most in pairs if value > most]


@pytest.mark.parametrize(
    ("row", "met"),
    [
        (Row("a", 5.0, "s"), None),
        (Row("a", 5.0, "s", at_most=5.0), True),
        (Row("a", 5.1, "s", at_most=5.0), False),
        (Row("a", 4.9, "s", at_least=5.0), False),
        (Row("a", 9.0, "s", 1.2, ratio_at_most=1.3), True),
        (Row("a", 1.0, "s", 1.4, ratio_at_most=1.3), False),
    ],
)
def test_a_row_meets_its_target(row, met):
    assert met is row.met


def test_a_row_shows_the_median_and_range_of_its_rounds():
    row = Row("a", Spread.of([7.0, 1.0, 200.0]), "s", Spread.of([1.0, 1.5, 1.25]), at_most=8.0)

    assert ("a", "7 s (1 … 200)", "1.25x (1.00 … 1.50)", "≤ 8 s", "yes") == row.cells


def test_a_ratio_is_of_the_same_round():
    """A round in which the machine was twice as slow changes no ratio."""
    took = Rounds({"bare": [1.0, 2.0, 4.0], "whole": [3.0, 6.0, 12.0]})

    ratio = took.ratio("whole", to="bare")

    assert (3.0, 3.0, 3.0) == (ratio.least, ratio, ratio.most)


def test_variants_take_turns():
    called = []

    took = interleaved([Variant(name, partial(called.append, name)) for name in "ab"], 6)

    assert ["a"] * 6 + ["b"] * 6 + ["a"] * 6 + ["b"] * 6 == called
    assert [2, 2] == [len(took.taken[name]) for name in "ab"]


def test_write_replaces_one_table(tmp_path):
    path = tmp_path / "doc.md"
    path.write_text("# Title\n<!-- begin a -->\nold\n<!-- end a -->\nmiddle\n<!-- begin b -->\nkept\n<!-- end b -->\n")

    _report.write(path, "a", "2026-01-31", [Row("bare query", 1234.5, "µs", 1.0, ratio_at_most=1.5)])

    head, _, tail = path.read_text().partition("<!-- begin a -->\n2026-01-31: ")
    assert head == "# Title\n"
    assert tail.partition("\n\n")[2] == (
        "| what | value | ratio | target | met |\n| --- | ---: | ---: | ---: | ---: |\n"
        "| bare query | 1,234 µs | 1.00x | ≤ 1.5 x | yes |\n"
        "<!-- end a -->\nmiddle\n<!-- begin b -->\nkept\n<!-- end b -->\n"
    )


def test_write_refuses_a_document_without_its_comments(tmp_path):
    path = tmp_path / "doc.md"
    path.write_text("# Title\n")

    with pytest.raises(ValueError, match="no <!-- begin a --> … <!-- end a --> to write between"):
        _report.write(path, "a", "2026-01-31", [])


def test_json_has_the_machine_and_every_row_with_its_verdict(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.start_up.run", lambda: [Row("hmrsim --help", 0.1, "s", at_most=0.3)])
    file = tmp_path / "figures.json"

    main(["start_up", "--json", str(file)])

    figures = json.loads(file.read_text())
    assert _report.machine() == figures["machine"]
    (row,) = figures["benchmarks"]["start_up"]
    assert ("hmrsim --help", 0.1, "s", 0.3, True) == tuple(
        row[key] for key in ("what", "value", "unit", "at_most", "met")
    )
