"""The results of a search: files of failures, stories, the page and JUnit XML."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from types import SimpleNamespace

import pytest

from hmrsim.fault_search.failure_page import failure_page, run_logged
from hmrsim.fault_search.reading import read_repro
from hmrsim.fault_search.results_folder import ResultsFolder, junit_text, page_of
from hmrsim.fault_search.run import Failure, Outcome, Wanted, run_case
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.fault_search.story import LONG, events_of, mark_of, story_of
from hmrsim.fault_search.summary import Finding, Reduced, by_begin
from hmrsim.trace.replay import replay
from tests.porters import check_of, searched


@pytest.fixture(scope="module")
def found():
    """Return the check of a porter that tries in vain, and the finding."""
    check = check_of("vain", budget={"runs": 64}, space={"only": ["breakdown"]})
    return check, searched(check)


def test_file_reproduces_the_failure(found, tmp_path):
    check, summary = found
    path = ResultsFolder(tmp_path / "results").keep(check, summary.findings[0])

    repro = read_repro(path)
    outcome = run_case(repro.check, repro.case, Wanted(trace=True))

    assert (repro.failure.property, repro.failure.reason) in outcome.failures
    assert outcome.trace == summary.findings[0].outcome.trace
    assert path.with_suffix(".jsonl").read_text("utf-8") == outcome.trace


def test_file_tells_its_page_what_the_search_has_left_out(found, tmp_path):
    check, summary = found
    repro = read_repro(ResultsFolder(tmp_path / "results").keep(check, summary.findings[0]))
    page = failure_page(repro.check, repro.case, *run_logged(repro.check, repro.case, Wanted()))

    assert repro.check.file.left_out.startswith("1 of 2 robots (other), ")
    assert f"The search has left out {repro.check.file.left_out}." in page


def test_world_name_may_have_two_words(tmp_path):
    check = check_of("broken", budget={"runs": 1}, overlay={"name": "two wings"})
    path = ResultsFolder(tmp_path).keep(check, searched(check).findings[0])

    assert read_repro(path).check.name == "two wings"


def test_moved_file_finds_its_controller(found, tmp_path, monkeypatch):
    check, summary = found
    path = ResultsFolder(tmp_path / "a" / "b").keep(check, summary.findings[0])
    moved = path.rename(tmp_path / "moved.yaml")
    monkeypatch.chdir(check.folder)

    assert read_repro(moved).check.folder == check.folder
    assert read_repro(moved, check.folder).check.folder == check.folder


def test_trace_of_a_failure_replays_without_its_controller(found):
    """The world in the trace includes faults that are anchored to events."""
    trace = found[1].findings[0].outcome.trace

    assert replay(trace.splitlines(keepends=True)).difference is None


def test_story_has_schedule_events_and_violation(found):
    story = story_of(found[1].findings[0])

    assert story[0].startswith("no_vain_goals: ")
    assert story[2] == "It fails with one thing:"
    assert story[3].startswith("  1. breakdown of porter for 1 s, when ")
    assert story[4].startswith("Without it it passes: the run ends as succeeded at ")
    assert any("has the fault breakdown_1" in line for line in story)
    assert any("VIOLATED no_vain_goals" in line for line in story)


def test_story_folds_repeated_events():
    """Events may differ in their numbers, and up to four may repeat together."""
    tries = [(float(at), f"{'abort' if at % 2 else 'accept'}ed (try {at // 2})") for at in range(20)]
    lines = [(0.0, "begins"), *tries, (20.0, "ends"), (20.0, "ends")]

    assert [
        (0.0, "begins"),
        (0.0, "accepted (try 0)"),
        (1.0, "aborted (try 0)"),
        (19.0, "… these 2 events 9 times more, up to here …"),
        (20.0, "ends"),
        (20.0, "ends"),
    ] == events_of(Outcome("failed", story=tuple(lines)))


def test_long_story_keeps_the_events_of_the_failure():
    """Events of its robot and item have priority over later events of others."""
    drives = [(float(at), f"{'eve' if at % 2 else 'chai'} navigate_to_pose w{at} accepted") for at in range(300)]
    cause = [(100.0, "mocha moves aside for eve"), (101.0, "mocha puts down box_1")]
    late = SimpleNamespace(at=290.5e9, property="orders_in_time", text="order_1 is late: box_1 is not there")
    outcome = Outcome("timeout", "", 300.0, (late,), story=tuple(sorted([*drives, *cause])))

    told = [text for _, text in events_of(outcome)]
    assert "mocha puts down box_1" in told
    assert told.index("mocha puts down box_1") < told.index(
        "VIOLATED orders_in_time: order_1 is late: box_1 is not there"
    )
    assert told[-9:] == [text for _, text in drives[-9:]]
    assert told[0].startswith("… ")
    assert 303 == len(events_of(outcome, LONG))


def test_junit_has_a_test_case_for_each_property(found):
    """A property that was never exercised is skipped."""
    _, summary = found
    suite = ET.fromstring(junit_text(summary.name, summary.exercised, summary.findings, 1.5)).find("testsuite")
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    skipped = [case.get("name") for case in suite if case.find("skipped") is not None]

    assert failed == ["no_vain_goals"]
    assert "orders_in_time" in skipped
    assert (suite.get("tests"), suite.get("failures")) == (str(len(summary.exercised)), "1")


def test_page_has_failures_and_gaps(found, tmp_path):
    check, summary = found
    page = page_of(check, summary, tmp_path)

    assert "breakdown of porter for 1 s" in page
    assert "Not reached" in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_folder_keeps_failures_for_later_searches(found, tmp_path):
    check, summary = found
    folder = ResultsFolder(tmp_path)
    path = folder.keep(check, summary.findings[0])

    assert folder.earlier() == [path]
    again = searched(check, earlier=[(read_repro(path).case, summary.findings[0].failure)])
    assert [finding.run for finding in again.findings] == [2]
    assert again.findings[0].known


LATE = Injection({"type": "slip", "robot": "porter", "factor": 0.5, "duration": 5.0, "when": {"event": "placed"}})
EARLY = Injection({"type": "breakdown", "robot": "porter", "duration": 5.0, "when": {"event": "picked"}})
STALLED = Injection({"disturbance": "controller_stalled", "duration": 1.0, "when": {"event": "picked", "after": 1.0}})
NEVER = Injection({"type": "breakdown", "robot": "other", "duration": 5.0, "when": {"event": "placed", "nth": 9}})
QUICK = Injection({"change": {"robots.porter.base.speed": 2.0}})


def test_outcome_has_the_begin_of_each_injection():
    """A change begins at 0, and an injection that never began has no time."""
    outcome = run_case(check_of("careful"), Case((LATE, EARLY, STALLED, NEVER, QUICK)))
    late, early, stalled, never, quick = outcome.began

    assert (quick, never) == (0.0, None)
    assert early == pytest.approx(stalled - 1.0)
    assert stalled < late


def test_story_orders_injections_by_their_begin():
    injections = (NEVER, LATE, EARLY)
    without = tuple(Outcome(name) for name in ("succeeded", "failed", "timeout"))
    told = Outcome("failed", began=(None, 9.0, 4.0))
    finding = Finding(Failure("p", "r"), 1, injections, Reduced(Case(injections), without, 3), told, 1.0)

    assert finding.in_order == [(EARLY, without[2]), (LATE, without[1]), (NEVER, without[0])]
    assert [line[:16] for line in story_of(finding)[3:6]] == [
        "  1. breakdown o",
        "  2. slip of por",
        "  3. breakdown o",
    ]
    assert story_of(finding)[6].startswith("Without thing 1 it passes: the run ends as timeout")


def test_injections_without_times_keep_their_order():
    assert by_begin((LATE, EARLY), Outcome("died")) == [0, 1]


def test_story_has_disturbances_at_their_times():
    outcome = run_case(check_of("careful"), Case((STALLED,)), Wanted(story=True))
    texts = [text for _, text in outcome.story]

    assert texts.count("disturbance: the controller is stalled for 1 s") == 1
    (at,) = outcome.began
    assert (at, "disturbance: the controller is stalled for 1 s") in outcome.story
    assert mark_of("disturbance: the controller is stalled for 1 s") == "thing"
