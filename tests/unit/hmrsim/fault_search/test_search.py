"""Searches: the failures that they find, the schedules that they try, and their limits."""

from __future__ import annotations

import math
import time
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import pytest

from hmrsim.fault_search.campaign import Campaign, Options, limited
from hmrsim.fault_search.candidates import Candidates
from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.guide import without_twins
from hmrsim.fault_search.run import VERDICTS, run_case, run_within
from hmrsim.fault_search.schedule import Case, Injection, Moment
from hmrsim.fault_search.search import BATCH, Search
from hmrsim.trials.batches import Serial
from tests.porters import check_of, searched
from tests.torture.planted import catalogue
from tests.torture.planted import check_of as planted

DELIVERED = {"properties": {"delivered": {"eventually": {"item": "box", "at": "shelf", "carried": False}}}}

SAME_ITEMS = {"properties": {"as_before": {"eventually": {"items": "as_without_faults"}}}}


def failures(summary):
    """Return the failures of a search, with the minimal schedules in words."""
    return {
        finding.failure.property: [injection.describe() for injection in finding.schedule]
        for finding in summary.findings
    }


def test_finds_a_controller_that_retries_for_ever():
    """After a breakdown, the goals of its robot are rejected again and again."""
    summary = searched(check_of("vain", budget={"runs": 64}, space={"only": ["breakdown", "slip"]}))

    (finding,) = summary.findings
    assert finding.failure.property == "no_vain_goals"
    assert [injection.kind for injection in finding.schedule] == ["breakdown"]
    assert summary.nominal.ending == "succeeded"


def test_finds_nothing_in_a_robust_controller():
    """A controller may fail, as long as it ends and reports it."""
    summary = searched(check_of("careful", budget={"runs": 96}))

    assert failures(summary) == {}
    assert summary.tried.runs == 96
    assert summary.tried.endings["failed"] > 0


def test_finds_a_controller_that_crashes():
    summary = searched(check_of("crashing", budget={"runs": 32}, space={"only": ["goals_aborted"]}))

    assert [*failures(summary)] == ["controller_lives"]


def test_search_ends_when_nothing_is_left_to_try():
    space = {"only": ["speed"], "at_most": 1}
    summary = searched(check_of("careful", space=space, budget="60s"))

    assert summary.tried.runs == 3
    assert summary.unreached.singles == 0


def test_singles_beyond_the_last_batch_are_left():
    """Two runs are the one without faults and one of the two speeds."""
    space = {"only": ["speed"], "at_most": 1}
    summary = searched(check_of("careful", space=space, budget={"runs": 2}))

    assert (summary.tried.runs, summary.unreached.singles) == (2, 1)


def test_finds_a_failure_without_faults_at_once():
    summary = searched(check_of("broken", budget={"runs": 32}), first_only=True)

    (finding,) = summary.findings
    assert (finding.failure.property, finding.schedule, finding.run) == ("controller_lives", (), 1)


def test_schedules_depend_on_the_seed_alone():
    check = check_of("careful", seed=3)
    runs = []
    for make, workers in ((Serial, 1), (lambda: ThreadPoolExecutor(1), 5)):
        with Evaluator(check, make, workers) as evaluator:
            nominal = evaluator.outcomes([Case()])[0]
            candidates = Candidates(check.world, check.file.space, nominal.moments)
            search = Search(check, evaluator, candidates, nominal)
            tried = []
            evaluator.stream = lambda cases, until, tried=tried, whole=evaluator.stream: (
                tried.extend(case.key for case in cases) or whole(cases, until)
            )
            for _ in range(2):
                search.next(BATCH)
            runs.append(tried)

    assert runs[0] == runs[1]
    assert len(runs[0]) == len({*runs[0]}) == 2 * BATCH


def test_skips_schedules_that_contain_a_known_failure():
    check = check_of("careful")
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        search = Search(check, evaluator, Candidates(check.world, check.file.space, nominal.moments), nominal)
        (first,) = search._new(search._singles, 1)
        search.pass_over(first)

        assert not search._is_new((*first, Injection({"type": "slip", "robot": "porter", "factor": 0.5})))
        assert search._is_new((Injection({"type": "slip", "robot": "porter", "factor": 0.5}),))


def test_skips_schedules_with_an_injection_that_can_t_begin():
    """There are three drives, and one more for each that is aborted."""
    drive = "navigate_to_pose"
    first, second, third = (
        Injection({"type": "goals_aborted", "robot": "porter", "action": drive, "count": 1, "when": when.anchor()})
        for when in (Moment(0.0, "executing", "", "porter", drive, nth) for nth in (1, 4, 5))
    )
    slip = Injection({"type": "slip", "robot": "porter", "factor": 0.5})
    check = check_of("careful")
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        search = Search(check, evaluator, Candidates(check.world, check.file.space, nominal.moments), nominal)
        search.run([Case(), Case((first,)), Case((first, second))])

        assert search.guide.can_begin((first, second, third))
        assert not search.guide.can_begin((second,))
        assert not search.guide.can_begin((second, third))
        assert not search.guide.can_begin((first, third))
        assert search.guide.can_begin((slip, third))


def test_the_run_without_faults_is_made_once():
    runs = []
    for properties in ({}, SAME_ITEMS):
        check = check_of("careful", properties=properties)
        with Evaluator(check, Serial, 1) as evaluator:
            nominal = evaluator.outcomes([Case()])[0]
            evaluator.take(limited(check, nominal), nominal)
            evaluator.outcomes([Case()])
            runs.append(evaluator.runs)

    assert [1, 2] == runs


def test_outcome_notes_a_fault_that_never_began():
    never = Injection({"type": "breakdown", "robot": "porter", "when": {"event": "deadlock"}})
    soon = Injection(
        {"type": "slip", "robot": "porter", "factor": 0.5, "when": {"goal": "executing", "robot": "porter"}}
    )

    outcome = run_case(check_of("careful"), Case((never, soon)))

    assert [at is None for at in outcome.began] == [True, False]


def test_outcome_notes_a_disturbance_that_never_began():
    """The end of the second goal kills the controller; there is no twentieth goal."""
    check = check_of("careful")
    killed = [Injection({"disturbance": "controller_killed", "when": {"goal": "ended", "nth": nth}}) for nth in (20, 2)]

    never, once = run_case(check, Case(tuple(killed))).began

    assert never is None
    assert once is not None


def test_goals_of_a_killed_controller_are_not_its_successor_s():
    """The robot still drives for the first controller when the second one gives up."""
    driving = {"goal": "executing", "robot": "other", "action": "navigate_to_pose"}
    killed = Injection({"disturbance": "controller_killed", "when": {**driving, "after": 1.0}, "restart_after": 1.0})

    outcome = run_case(check_of("hasty"), Case((killed,)))

    assert outcome.ending == "failed"
    assert outcome.violations == ()


def test_second_controller_cut_off_at_the_end_is_no_failure():
    carrying = {"goal": "executing", "robot": "porter", "action": "place"}
    second = Injection({"disturbance": "second_controller", "when": carrying})

    outcome = run_case(check_of("careful"), Case((second,)))

    assert outcome.violations == ()


def test_run_ended_by_a_violation_is_stopped():
    broken = Injection({"type": "breakdown", "robot": "porter", "when": {"goal": "executing", "robot": "porter"}})

    outcome = run_case(check_of("vain"), Case((broken,)))

    assert outcome.ending == "stopped"
    assert [violation.property for violation in outcome.violations] == ["no_vain_goals"]


def test_impossible_case_is_an_error():
    outcome = run_case(check_of("careful"), Case((Injection({"change": {"robots.nobody.base.speed": 1.0}}),)))

    assert outcome.ending == "error"
    assert "nobody" in outcome.cause
    assert outcome.failure is None


@pytest.mark.parametrize("strategy", ["guided", "random"])
def test_searches_with_a_number_of_runs_are_equal(strategy):
    summaries = [searched(check_of("careful", budget={"runs": 64}), strategy=strategy) for _ in range(2)]

    assert summaries[0].tried == summaries[1].tried
    assert summaries[0].features == summaries[1].features


def test_finds_violations_of_custom_properties():
    """The porter reports success although the box is not there."""
    summary = searched(check_of("proud", budget={"runs": 64}, properties=DELIVERED))

    assert [injection.kind for finding in summary.findings for injection in finding.schedule] != []
    assert "delivered" in {finding.failure.property for finding in summary.findings}


def test_an_item_is_where_its_carrier_is():
    never = {"properties": {name: {"never": {"item": "box", "at": name}} for name in ("home", "store", "shelf")}}

    outcome = run_case(check_of("careful", properties=never), Case())

    assert [(violation.property, violation.at / 1e9) for violation in outcome.violations] == [
        ("store", 0.0),
        ("shelf", 19.0),
    ]


def test_tree_without_its_robot_does_not_crash():
    """The tree is restarted while its robot has no connection, and ends with a clear error."""
    check = planted(catalogue()["wrong_sign"], "twin")
    when = {"goal": "executing", "robot": "wall_e"}
    lost = Injection({"type": "messages_lost", "robot": "wall_e", "duration": 30.0, "when": when})
    killed = Injection({"disturbance": "controller_killed", "restart_after": 5.0, "when": when})

    outcome = run_case(check, Case((lost, killed)))

    assert outcome.ending == "failed"
    assert outcome.cause.startswith("NotServed: ")
    assert "controller_lives" not in [failure.property for failure in outcome.failures]


def test_death_of_a_worker_is_a_failure_of_its_case():
    class Fragile(Serial):
        def submit(self, function, /, *args, **kwargs):
            if any(injection.kind == "slip" for case in args[0].cases for injection in case.schedule):
                raise BrokenProcessPool("a segmentation fault")
            return super().submit(function, *args, **kwargs)

    check = check_of("careful")
    slip = Injection({"type": "slip", "robot": "porter", "factor": 0.5})
    with Evaluator(check, Fragile, 1) as evaluator:
        fine, died = evaluator.outcomes([Case(), Case((slip,))])

    assert (fine.ending, fine.failure) == ("succeeded", None)
    assert (died.ending, died.failure.property) == ("died", "controller_lives")


def test_coverage_includes_all_runs():
    with Evaluator(planted(catalogue()["wrong_sign"], "twin"), Serial, 1) as evaluator:
        evaluator.rerun(Case())

        assert evaluator.covered.share


def test_keeps_a_failure_whose_reduction_is_interrupted():
    """Ctrl-C ends the search; the summary has the smallest schedule so far."""

    class Interrupted(Evaluator):
        interrupted = False

        def outcomes(self, cases, until=math.inf):
            if not self.interrupted and any(case.definition is not None for case in cases):
                self.interrupted = True
                raise KeyboardInterrupt
            return super().outcomes(cases, until)

    check = check_of("vain", budget={"runs": 64}, space={"only": ["breakdown", "slip"]})
    with Interrupted(check, Serial, 1) as evaluator:
        summary = Campaign(check, evaluator, evaluator.outcomes([Case()])[0], Options()).run()

    assert not summary.complete
    assert {"no_vain_goals": 1} == {each.failure.property: len(each.schedule) for each in summary.findings}


def test_finds_a_controller_that_does_not_recover():
    spec = {
        "properties": {"built_in": {"recovers": {"within": 31.0}}},
        "space": {"only": ["goals_aborted", "goals_rejected", "speed"], "at_most": 1},
        "budget": {"runs": 64},
    }
    hasty, careful = (searched(check_of(name, **spec)) for name in ("hasty", "careful"))

    assert {"recovers"} == {*failures(hasty)}
    assert [1] * len(hasty.findings) == [len(finding.schedule) for finding in hasty.findings]
    assert {} == failures(careful)


def test_finds_a_false_report_of_success():
    """The items have to be where they are without faults."""
    spec = {
        "properties": {"properties": {"true": {"reports": "succeeded", "then": {"items": "as_without_faults"}}}},
        "space": {"only": ["goals_aborted", "claw_misses"]},
        "budget": {"runs": 40},
    }
    proud, careful = (searched(check_of(name, **spec)) for name in ("proud", "careful"))

    assert {"true"} == {*failures(proud)}
    assert {} == failures(careful)
    assert careful.tried.exercised["true"] > 0


def test_failed_nominal_run_is_no_reference():
    same = {"true": {"reports": "failed", "then": {"items": "as_without_faults"}}}
    check = check_of("hasty", properties={"properties": same}, overlay={"items.crate.at": [0, 0]})
    nominal = run_case(check, Case())

    assert nominal.ending == "failed"
    assert limited(check, nominal).reference is None


def test_search_for_the_first_failure_ends_with_its_run():
    summary = searched(check_of("vain", budget={"runs": 64}, space={"only": ["breakdown", "slip"]}), first_only=True)

    (finding,) = summary.findings
    assert summary.tried.runs == finding.run < BATCH


def test_each_kind_has_its_turn_first():
    check = check_of("careful")
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        candidates = Candidates(check.world, check.file.space, nominal.moments)
        search = Search(check, evaluator, candidates, nominal)
        kinds = {candidate.injection.kind for candidate in candidates.entries}
        search.next(len(kinds))

    assert dict.fromkeys(kinds, 1) == dict(search.tried.kinds)
    assert search.tried.singles_left == search.tried.singles - len(kinds)


def test_doors_and_lanes_fail_from_the_start_first():
    check = check_of("careful", space={"only": ["lane_closed", "breakdown"]})
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        candidates = Candidates(check.world, check.file.space, nominal.moments)
        tried = []
        evaluator.stream = lambda cases, until, whole=evaluator.stream: tried.extend(cases) or whole(cases, until)
        search = Search(check, evaluator, candidates, nominal)
        search.next(2)

    starts = {injection.kind: injection.at_start for case in tried for injection in case.schedule}
    assert starts == {"lane_closed": True, "breakdown": False}
    assert search.tried.begun == {"lane_closed": 1, "breakdown": 1}


@pytest.mark.parametrize("initial", [100.0, 50.0])
def test_nominal_run_measures_battery_draws(initial):
    """The porter drives for 40 s, the last 20 s of them at once; the other robot stands."""
    battery = {"capacity": 100.0, "initial_charge": initial, "drain": {"moving": 1.0, "still": 0.0}}
    check = check_of("careful", overlay={"robots.*.components.battery": battery})

    draws = dict(run_case(check, Case()).draws)

    assert draws["porter"] == (pytest.approx(0.4), pytest.approx(0.2))
    assert draws["other"] == (0.0, 0.0)


def test_schedule_has_one_change_per_robot():
    slow, small = ({"change": {f"robots.eve.{path}": 1.0}} for path in ("base.speed", "components.battery.capacity"))
    other = {"change": {"robots.wall_e.base.speed": 1.0}}

    assert without_twins(tuple(map(Injection, (slow, small, other)))) == (Injection(slow), Injection(other))


def test_nothing_runs_after_the_time_limit():
    """A run that exceeds the limit is no failure."""
    check = check_of("sleepy")
    with Evaluator(check, Serial, 1) as evaluator:
        late = evaluator.outcomes([Case()], time.monotonic())

    assert (late, evaluator.runs) == ([], 0)
    assert run_within(check, Case(), VERDICTS, 0.01) is None


@pytest.mark.parametrize(
    ("budget", "began", "allowed"),
    [
        ({"time": 100.0}, 50.0, 30.0),
        ({"time": 100.0}, 95.0, 5.0),
        ({"time": 100.0, "runs": 5}, 50.0, 30.0),
        ({"runs": 5}, 1.0, 10.0),
        ({"runs": 5}, 60.0, 60.0),
    ],
)
def test_reduction_keeps_to_the_budget(budget, began, allowed):
    """With a budget of runs alone, it takes no longer than the search."""
    check = check_of("careful", budget=budget)
    with Evaluator(check, Serial, 1) as evaluator:
        campaign = Campaign(check, evaluator, evaluator.outcomes([Case()])[0], Options(), began=0.0)

    assert campaign.reduces_until(began) == began + allowed


def test_reduction_reports_its_progress():
    told = []
    check = check_of("vain", budget={"runs": 64, "time": 10_000.0}, space={"only": ["breakdown", "slip"]})
    searched(check, first_only=True, tell=told.append)

    steps = [(each.reducing, each.reduced_in) for each in told if each.reducing]
    assert {"no_vain_goals"} == {name for name, _ in steps}
    assert [0, *sorted({runs for _, runs in steps} - {0})] == [*dict.fromkeys(runs for _, runs in steps)]
    assert len({runs for _, runs in steps}) > 2


def test_kept_outcomes_have_no_features():
    check = check_of("careful")
    slip = Case((Injection({"type": "slip", "robot": "porter", "factor": 0.5}),))
    with Evaluator(check, Serial, 1) as evaluator:
        first, again = (evaluator.outcomes([Case(), slip]) for _ in range(2))

    assert [True, True] == [bool(outcome.features) for outcome in first]
    assert [True, False] == [bool(outcome.features) for outcome in again]
    assert first[1].verdicts == again[1].verdicts
