"""The summary of the results of an experiment."""

from __future__ import annotations

import random
import sys

import pytest

from hmrsim.errors import MissingExtra
from hmrsim.experiments.report import comparisons, summary_of
from hmrsim.experiments.report.columns import MAX_LISTED
from hmrsim.experiments.statistics import (
    Criterion,
    compare,
    interactions,
    main_effects,
    mean_interval,
    proportion_interval,
)
from hmrsim.experiments.store import Row
from tests.unit.hmrsim.experiments.report.conftest import TREE, times


def bounds(estimate):
    return pytest.approx((estimate.estimate, estimate.low, estimate.high))


def interval(found):
    return found.estimate, found.low, found.high


def noisy(run, levels):
    """Return a random result; some have no value."""
    rng = random.Random(run.number)
    if rng.random() < 0.2:
        return Row(run, "timeout", "time: no value", at=3600.0, measures={})
    value = rng.gauss(10 + len(str(levels)), 3) + (run.treatment == "b")
    return Row(run, "succeeded", success=True, at=value, measures={"time": value})


def test_means_medians_and_shares_by_treatment(results):
    """Of 4 … 8 and 10 … 14: mean 9 ± t(9) √(110 / 9 / 10), median 9, and 95 % at 13 + 0.55."""
    first, _ = summary_of(results()).treatments
    column = first.measures["time"]

    assert (10, 9.0, 9.0, 13.55, 4.0, 14.0) == (
        column.mean.n,
        column.mean.estimate,
        column.median,
        pytest.approx(column.p95),
        column.least,
        column.most,
    )
    assert 9 - 2.262157 * (110 / 9 / 10) ** 0.5 == pytest.approx(column.mean.low, abs=1e-5)


def test_success_has_wilsons_interval(results):
    def made(run, levels):
        return Row(run, "timeout") if run.number == 0 else times(run, levels)

    first, second = summary_of(results(made)).treatments

    assert (0.9, 0.5958, 0.9821) == pytest.approx(interval(first.success), abs=5e-5)
    assert ({"timeout": 1, "succeeded": 9}, {"succeeded": 10}) == (first.endings, second.endings)


def test_treatments_are_compared_pair_by_pair(results):
    """B takes 1 s less if slow, and 3 s less if fast; the verdict is that of `compare`, with half of alpha."""
    seen = {}

    def made(run, levels):
        row = times(run, levels)
        seen.setdefault((run.replication, run.seed), {})[run.treatment] = row.measures["time"]
        return row

    found = summary_of(results(made, replications=20))
    (comparison,) = found.comparisons
    verdict = comparison.measures["time"]
    # Within a replication the seeds, which are pseudo-random, decide which scenario comes first.
    pairs = [[*values.values()] for _, values in sorted(seen.items())]
    expected = compare(*zip(*pairs, strict=True), Criterion(larger_is_better=False, alpha=0.025))

    assert (40, (0, 0), -2.0, 40, 0.025) == (
        comparison.pairs,
        comparison.alone,
        verdict.difference.estimate,
        verdict.differing,
        verdict.alpha,
    )
    assert ("better", expected.decided_after) == (verdict.verdict, verdict.decided_after)
    assert bounds(verdict.difference) == interval(expected.difference)


def test_runs_without_a_counterpart_are_left_out(results):
    found = summary_of(results(lambda run, levels: None if run.number in {1, 3, 4} else times(run, levels)))
    (comparison,) = found.comparisons

    assert (7, (2, 1)) == (comparison.pairs, comparison.alone)
    assert (17, 20, 20) == (found.runs, found.least, found.most)
    assert [
        "17 of 20 runs have a result: the experiment still runs, or was stopped; the same command goes on with it."
    ] == [*found.notes]


def test_all_verdicts_share_alpha(results):
    found = summary_of(results(treatments={"a": TREE, "b": TREE, "c": TREE}))

    assert {0.0125} == {each.alpha for one in found.comparisons for each in one.measures.values()}


def test_deciding_measure_has_its_own_alpha(results):
    until = {"measure": "time", "decided": True, "confidence": 0.9}
    found = summary_of(results(replications={"min": 2, "max": 20, "until": until}))
    alphas = {name: each.alpha for name, each in found.comparisons[0].measures.items()}

    assert {"success": 0.05, "time": pytest.approx(0.1)} == alphas


def test_measure_of_yes_and_no_is_compared_like_success(results):
    def made(run, _levels):
        success = run.treatment == "b" or run.replication % 2 == 0
        return Row(run, "succeeded", success=success, measures={"time": float(success)})

    measures = {"time": {"value": "ends.success", "better": "larger", "margin": 0.1}}
    (comparison,) = summary_of(results(made, measures=measures, replications=12)).comparisons
    time, success = comparison.measures["time"], comparison.measures["success"]

    assert ("better", success.decided_after, success.difference) == (time.verdict, time.decided_after, time.difference)
    assert 30 > time.decided_after


def test_margin_of_zero_is_none(results):
    """A relative margin of a measure below 0 is dropped, with a note."""

    def made(run, _levels):
        return Row(run, "succeeded", success=True, measures={"time": 1.0, "height": -1.0})

    measures = {
        "time": {"value": "end.at", "margin": 0.0},
        "height": {"value": "end.at", "margin": 0.1, "relative": True},
    }
    (comparison,) = summary_of(results(made, measures=measures)).comparisons

    assert {None} == {each.margin for each in comparison.measures.values()}
    assert (
        "height: has values below 0, of which no margin can be a share; compared without a margin",
    ) == comparison.notes


def test_compares_the_first_of_very_many_pairs(results, monkeypatch):
    monkeypatch.setattr(comparisons, "MAX_PAIRS", 6)
    (comparison,) = summary_of(results()).comparisons

    assert 6 == comparison.measures["time"].difference.n
    assert "time: the first 6 of 10 pairs are compared" in comparison.notes


def test_effects_of_factors(results):
    """Means 12, 6, 11 and 3: slow is 3.5 above 8, a is 1 above; both together 0.5 less."""
    effects = summary_of(results()).effects["time"]
    told = {(each.factor, each.level): (each.mean.estimate, each.effect) for each in effects.levels}
    (together,) = effects.interactions

    assert 8.0 == effects.mean
    assert told == {
        ("speed", "0.5"): (11.5, 3.5),
        ("speed", "1.0"): (4.5, -3.5),
        ("treatment", "a"): (9.0, 1.0),
        ("treatment", "b"): (7.0, -1.0),
    }
    assert (("speed", "treatment"), ("0.5", "a"), 12.5) == (together.factors, together.levels, together.expected)
    # t(4) at 97.5 % is 2.776, and 10 … 14 have a standard deviation of √2.5.
    half = 2.776445 * 0.5**0.5
    assert bounds(together.mean) == (12.0, 12 - half, 12 + half)


def test_effects_are_those_of_the_statistics(results):
    made = results(noisy, factors={"speed": [0.5, 1.0], "pace": ["slow", "medium", "fast"]}, replications=40)
    found = summary_of(made).effects["time"]
    rows = [row for row in made.rows() if row["time"] is not None]
    runs = [{name: str(row[name]) for name in ("speed", "pace", "treatment")} for row in rows]
    values = [row["time"] for row in rows]
    expected = {(each.factor, each.level): each for each in main_effects(runs, values)}
    both = {(each.factors, each.levels): each for each in interactions(runs, values)}

    assert 7 == len(found.levels)
    for level in found.levels:
        each = expected[level.factor, level.level]
        assert bounds(level.mean) == interval(each.mean)
        assert each.effect == pytest.approx(level.effect)
    assert 3 == len(found.interactions)
    for told in found.interactions:
        each = both[told.factors, told.levels]
        assert bounds(told.mean) == interval(each.mean)
        assert each.effect == pytest.approx(told.mean.estimate - told.expected)
        assert abs(each.effect) == max(abs(one.effect) for (names, _), one in both.items() if names == told.factors)


def test_factors_that_do_not_vary_together_have_no_interactions(results):
    found = summary_of(results(design="one_at_a_time", factors={"speed": [0.5, 1.0], "charge": [1, 2]})).effects["time"]

    assert {("speed", "treatment"), ("charge", "treatment")} >= {each.factors for each in found.interactions}
    assert "not all levels occur together, so that interactions are not known: speed and charge" == found.notes[0]


def test_a_latin_hypercube_has_interactions(results):
    ranges = {"speed": {"low": 0.5, "high": 1.5}, "charge": {"low": 0.2, "high": 0.9}}
    found = summary_of(results(noisy, design={"latin_hypercube": 200}, factors=ranges, replications=2)).effects["time"]

    assert ("speed", "charge") in {each.factors for each in found.interactions}
    assert "contains some of the other's: speed and charge" in found.notes[-1]


def test_many_levels_are_put_into_bands(results):
    found = summary_of(
        results(
            design={"latin_hypercube": 40},
            factors={"speed": {"low": 0.5, "high": 1.5}},
            replications=1,
        )
    ).effects["time"]

    assert [16] * 5 == [each.mean.n for each in found.levels if each.factor == "speed"]
    assert ("speed has 40 levels, which are put into 5 bands",) == found.notes


def test_running_means_are_those_of_the_first_replications(results):
    made = results(noisy, replications=30)
    found = summary_of(made).running
    points = {each.replications: each.mean for each in found["time"]["b"]}
    for until in (1, 7, 30):
        rows = [row for row in made.rows(where={"treatment": "b"}) if row["replication"] < until]
        values = [row["time"] for row in rows if row["time"] is not None]

        assert bounds(points[until]) == interval(mean_interval(values))
        share = {each.replications: each.mean for each in found["success"]["b"]}[until]
        assert bounds(share) == interval(proportion_interval(sum(row["success"] for row in rows), len(rows)))


def test_long_running_means_are_thinned(results):
    points = summary_of(results(noisy, replications=500)).running["time"]["a"]

    assert (120, 1, 500) == (len(points), points[0].replications, points[-1].replications)


def test_histograms_share_their_edges(results):
    found = summary_of(results()).distributions["time"]

    assert (0.5, 14.5, 14) == (found.edges[0], found.edges[-1], len(found.edges) - 1)
    assert [4, 5, 6, 7, 8, 10, 11, 12, 13, 14] == [i + 1 for i, count in enumerate(found.counts["a"]) if count]
    assert [1, 2, 3, 4, 5, 9, 10, 11, 12, 13] == [i + 1 for i, count in enumerate(found.counts["b"]) if count]


def test_histograms_of_real_numbers_have_all_values(results):
    made = results(noisy, replications=100)
    found = summary_of(made).distributions["time"]

    assert 8 <= len(found.edges) - 1 <= 40
    assert sum(row["time"] is not None for row in made.rows()) == sum(map(sum, found.counts.values()))


def test_pairs_that_ended_differently(results):
    def made(run, levels):
        return Row(run, "flat" if run.number == 5 else "timeout") if run.number in {1, 5, 9} else times(run, levels)

    (comparison,) = summary_of(results(made)).comparisons

    assert 3 == comparison.differing
    assert [("succeeded", "timeout", 2), ("succeeded", "flat", 1)] == [
        (each.first, each.other, each.pairs) for each in comparison.changes
    ]
    assert [(0, 1), (4, 5), (8, 9)] == [(each.first, each.other) for each in comparison.runs]
    assert {"speed": 0.5} == comparison.runs[0].levels


def test_runs_without_success_are_listed_with_their_causes(results):
    def made(run, _levels):
        return Row(run, "crashed", f"KeyError: {run.number % 3}")

    found = summary_of(results(made, replications=100)).failures

    assert (400, MAX_LISTED) == (found.total, len(found.runs))
    assert [("KeyError: 0", 134, 0), ("KeyError: 1", 133, 1), ("KeyError: 2", 133, 2)] == [
        (each.cause, each.runs, each.first) for each in found.causes
    ]
    assert (0, "a", {"speed": 0.5}, "crashed") == (
        found.runs[0].number,
        found.runs[0].treatment,
        found.runs[0].levels,
        found.runs[0].ending,
    )


def test_values_without_statistics(results):
    def made(run, _levels):
        return Row(run, "succeeded", success=True, measures={"time": "late" if run.replication else 1e200})

    found = summary_of(results(made))

    assert (0, 10) == (found.treatments[0].measures["time"].mean.n, found.treatments[0].measures["time"].missing)
    assert ("time is a text in 16 runs, of which there are no means.",) == found.notes
    assert {} == found.distributions


def test_an_experiment_without_results(results):
    found = summary_of(results(lambda _run, _levels: None))

    assert (0, ("No run has a result yet.",), {}, 0) == (
        found.runs,
        found.notes,
        found.effects,
        found.comparisons[0].pairs,
    )
    assert [None, None] == [each.success.estimate for each in found.treatments]


def test_summary_describes_the_experiment(results):
    found = summary_of(results()).experiment

    assert ("pace", 7, "zoo/crossing", ("speed",), 2) == (
        found.name,
        found.seed,
        found.world,
        found.factors,
        found.scenarios,
    )
    assert "name: pace" in found.text


@pytest.mark.parametrize("missing", ["numpy", "scipy.stats"])
def test_missing_library_names_the_extra(results, monkeypatch, missing):
    made = results()
    monkeypatch.setitem(sys.modules, missing, None)

    with pytest.raises(MissingExtra, match=r"pip install 'hmrsim\[experiments\]'"):
        summary_of(made)
