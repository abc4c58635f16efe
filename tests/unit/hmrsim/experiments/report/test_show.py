"""The table on a terminal, as a whole and by factors, and the runs without success."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main
from hmrsim.experiments.store import Row


@pytest.fixture
def shown(results, capsys):
    """Return a function that shows results; it returns exit code, output and errors."""

    def show(*words, **changes):
        folder = results(**changes).folder
        code = main(["experiment", "show", str(folder), *words])
        said = capsys.readouterr()
        return code, said.out, said.err

    return show


def test_each_level_of_a_factor_has_a_row(shown):
    _, out, _ = shown("--by", "speed")

    rows = [line.split() for line in out.splitlines()]
    assert ["speed", "treatment", "runs", "success", "time"] == rows[0]
    assert [("0.5", "a", "5", "12"), ("0.5", "b", "5", "11"), ("1.0", "a", "5", "6"), ("1.0", "b", "5", "3")] == [
        (row[0], row[1], row[2], row[6]) for row in rows[1:]
    ]


def test_json_has_the_levels(shown):
    treatments = json.loads(shown("--by", "speed", "--json")[1])["treatments"]

    assert [({"speed": 0.5}, "a"), ({"speed": 0.5}, "b"), ({"speed": 1.0}, "a"), ({"speed": 1.0}, "b")] == [
        (each["levels"], each["name"]) for each in treatments
    ]
    assert all("levels" not in each for each in json.loads(shown("--json")[1])["treatments"])


def test_failed_run_has_its_levels(shown):
    def one_crash(run, levels):
        crashed = levels["speed"] == 1.0 and run.treatment == "b" and run.replication == 0
        return Row(run, "crashed" if crashed else "succeeded", "it fell", success=not crashed, measures={"time": 1.0})

    _, out, _ = shown(made=one_crash)

    assert "(b, speed 1.0) crashed: it fell" in out


def test_unknown_factor_gets_a_suggestion(shown):
    assert (2, "") == (shown("--by", "sped")[0], shown("--by", "sped")[1])
    assert "--by: no factor 'sped'; did you mean 'speed'?" in shown("--by", "sped")[2]


def test_shows_the_original_file(shown):
    assert shown("--file")[1].startswith("name: pace\nworld: zoo/crossing\n")


def test_measure_of_yes_and_no_has_the_interval_of_a_share(shown):
    def late_once(run, _levels):
        return Row(run, "succeeded", success=True, measures={"time": float(run.number == 3)})

    (_, treatment) = json.loads(shown("--json", made=late_once)[1])["treatments"]

    mean = treatment["measures"]["time"]
    assert (0.1, 10) == (mean["estimate"], mean["n"])
    assert (0.018, 0.404) == (round(mean["low"], 3), round(mean["high"], 3))
