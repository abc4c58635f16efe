"""Repeated runs: replications without randomness count once."""

from __future__ import annotations

from statistics import fmean

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.cli import main
from hmrsim.errors import ResultsError
from hmrsim.experiments.contrast import contrast, sides_of
from hmrsim.experiments.repeats import Repeats, counted, pairs_that_count
from hmrsim.experiments.report import summary_of
from hmrsim.experiments.statistics.intervals import mean_interval, proportion_interval
from hmrsim.experiments.store import Row
from hmrsim.experiments.table import groups_by


def rows(*cells):
    """Return runs with a scenario and a fingerprint each."""
    return [{"scenario": scenario, "treatment": "a", "fingerprint": fingerprint} for scenario, fingerprint in cells]


def count(runs):
    """Return the effective number of runs."""
    return counted(len(runs), sum(square for _, square in Repeats.of(runs).weighed(runs)))


@pytest.mark.parametrize(
    ("runs", "number"),
    [
        (rows(), 0),
        (rows((0, "f")), 1),
        (rows((0, "f"), (0, "f"), (0, "f")), 1),
        (rows((0, ""), (0, ""), (0, "")), 3),
        (rows((0, "f"), (0, "f"), (0, "g")), 3),
        (rows((0, "f"), (0, "f"), (0, "")), 3),
        (rows((0, "f"), (1, "f")), 2),
        (rows(*((scenario, "f") for scenario in range(81) for _ in range(8))), 81),
    ],
)
def test_equal_replications_count_once_unless_something_varies(runs, number):
    """If random numbers were drawn, or other runs of the cell differ, equal runs are equal by chance."""
    assert number == count(runs)


def test_scenarios_that_are_repeated_have_more_weight_than_single_runs():
    """80 scenarios of 8 equal runs and 8 different ones count as little more than one run per scenario."""
    runs = rows(*((scenario, "f") for scenario in range(80) for _ in range(8)), *((80, "") for _ in range(8)))

    assert 81 == count(runs)


@given(st.lists(st.tuples(st.integers(0, 4), st.sampled_from(["", "f", "g"])), max_size=40))
def test_runs_count_as_one_at_least_and_as_all_at_most(cells):
    runs = rows(*cells)

    assert min(1, len(runs)) <= count(runs) <= len(runs)


@given(st.lists(st.floats(-100, 100), min_size=1, max_size=20), st.integers(1, 8))
def test_interval_of_repeated_values_is_that_of_one_of_each(values, times):
    once, again = mean_interval(values), mean_interval(values * times, n=len(values))

    for one, two in ((once.estimate, again.estimate), (once.low, again.low), (once.high, again.high)):
        assert one == two if one is None else one == pytest.approx(two, abs=1e-9)
    assert len(values) == again.n


def equal(run, _levels):
    """Return a success that is equal in all replications; b takes 1 s more."""
    value = 10.0 + run.scenario + (run.treatment == "b")
    return Row(run, "succeeded", success=True, at=value, measures={"time": value}, fingerprint=run.treatment)


def half(run, levels):
    """Return an equal result at speed 0.5; at 1.0, 5 s less plus the replication."""
    if levels["speed"] == 0.5:
        return equal(run, levels)
    value = 10.0 + run.replication + (-5.0 if run.treatment == "b" else 0.0)
    return Row(run, "succeeded", success=True, at=value, measures={"time": value})


def test_eight_repeats_of_81_scenarios_have_the_interval_of_81(results):
    found = results(equal, factors={"speed": [*range(81)]}, replications=8)

    rate = groups_by(found)[0].rate()
    assert (1.0, 81) == (rate.estimate, rate.n)
    assert pytest.approx(0.955, abs=5e-4) == rate.low
    (one, _) = summary_of(found).treatments
    assert (648, 81, rate.low) == (one.runs, one.success.n, one.success.low)
    assert 81 == one.measures["time"].mean.n
    (group, *_) = groups_by(found, ["speed"])
    assert (8, 1, None) == (group.runs, group.mean("time").n, group.mean("time").low)


def test_reports_that_repeats_count_once(results, capsys):
    found = results(equal, factors={"speed": [0.5, 1.0]}, replications=5)

    main(["experiment", "show", str(found.folder)])
    (note,) = summary_of(found).notes

    assert "a: 10 runs count as 2, as the others repeat them: nothing was left to" in capsys.readouterr().out
    assert "20 runs count as 4, as the others repeat them: nothing was left to chance in these." == note


def test_reports_repeats_once_per_treatment(results, capsys):
    found = results(equal, factors={"speed": [*range(20)]}, replications=5)

    main(["experiment", "show", "--by", "speed", str(found.folder)])
    out = capsys.readouterr().out
    assert 2 == out.count("repeat them")
    assert "a: 100 runs count as 20, " in out


def test_effects_and_running_means_count_repeats_once(results):
    found = results(equal, factors={"speed": [0.5, 1.0], "load": [1, 2, 3]}, replications=5)

    summary = summary_of(found)
    assert [6, 6] == [each.mean.n for each in summary.effects["time"].levels if each.factor == "speed"]
    assert [6] * 5 == [point.mean.n for point in summary.running["time"]["a"]]
    last = summary.running["time"]["a"][-1].mean
    mean = summary.treatments[0].measures["time"].mean
    assert (last.low, last.high) == pytest.approx((mean.low, mean.high))


def test_a_side_without_runs_is_not_compared(results):
    folder = results(lambda *_run: None).folder

    with pytest.raises(ResultsError, match=r":a has no runs yet; `hmrsim experiment run FILE -o .*` makes them"):
        contrast(*sides_of(f"{folder}:a", f"{folder}:b"))


def test_pairs_that_repeat_others_are_compared_once(results):
    found = results(equal, factors={"speed": [*range(40)]}, replications=8)

    compared = contrast(*sides_of(f"{found.folder}:a", f"{found.folder}:b"), measures=["time"])
    assert 320 == compared.pairs
    assert 40 == compared.comparisons["time"].difference.n
    said = "320 pairs count as 40, as the others repeat them: nothing was left to chance in these"
    assert (said,) == compared.notes
    (comparison,) = summary_of(found).comparisons
    assert (40, said) == (comparison.measures["time"].difference.n, comparison.notes[0])


def test_scenarios_with_and_without_chance_keep_their_weights(results):
    """Each replication is one value, so that random scenarios have no more weight than others."""
    found = results(half, replications=50)

    compared = contrast(*sides_of(f"{found.folder}:a", f"{found.folder}:b"), measures=["time"])
    difference = compared.comparisons["time"].difference
    means = {group.name: fmean(group.values["time"]) for group in groups_by(found)}
    assert (50, -2.0) == (difference.n, difference.estimate)
    assert difference.estimate == pytest.approx(means["b"] - means["a"])
    (comparison,) = summary_of(found).comparisons
    assert -2.0 == comparison.measures["time"].difference.estimate
    assert "100 pairs count as 50, as nothing was left to chance in 50 of them: one value" in comparison.notes[0]


def test_repeated_pair_belongs_to_all_replications():
    cells = [(0, 0), (1, 0), (0, 1), (1, 1), (1, 2)]
    repeated = [True, False, True, False, False]

    assert [[0, 1], [0, 3], [0, 4]] == pairs_that_count(cells, repeated)


def test_reports_means_that_include_failed_runs(results, capsys):
    def fails(run, levels):
        failed = run.treatment == "b" and run.replication == 0
        return Row(run, "failed", success=False, measures={"time": 1.0}) if failed else equal(run, levels)

    found = results(fails)

    main(["experiment", "show", str(found.folder)])
    assert "b: means include values of runs without success: 2 of time\n" in capsys.readouterr().out
    summary = summary_of(found)
    assert [0, 2] == [treatment.measures["time"].failed for treatment in summary.treatments]
    assert "time: 2 of 10 pairs have a run without success" in summary.comparisons[0].notes
    compared = contrast(*sides_of(f"{found.folder}:a", f"{found.folder}:b"))
    assert "time: 2 of 10 pairs have a run without success" in compared.notes


def test_wilsons_interval_of_a_share_of_fewer_runs():
    """The interval is interpolated for a share that is impossible for so few runs."""
    low, middle, high = (proportion_interval(successes, 10).low for successes in (5, 5.5, 6))

    assert low < middle < high
