"""The file that repeats a failure, its story, and what continuous integration gets."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from types import SimpleNamespace

import pytest

from hmrsim.fault_search.reading import read_repro
from hmrsim.fault_search.results.folder import ResultsFolder, junit_text, page_of
from hmrsim.fault_search.results.story import LONG, events_of, mark_of, story_of
from hmrsim.fault_search.results.summary import Finding, Reduced, by_begin
from hmrsim.fault_search.running.single import Failure, Outcome, Wanted, run_case
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.trace.replay import replay
from tests.porters import check_of, searched


@pytest.fixture(scope="module")
def found():
    """Return the check of a porter that tries in vain, and what is found."""
    check = check_of("vain", budget={"runs": 64}, space={"only": ["breakdown"]})
    return check, searched(check)


def test_a_failure_is_repeated_from_its_file(found, tmp_path):
    """With the same failure, and the same trace, byte for byte."""
    check, summary = found
    path = ResultsFolder(tmp_path / "results").keep(check, summary.findings[0])

    repro = read_repro(path)
    outcome = run_case(repro.check, repro.case, Wanted(trace=True))

    assert (repro.failure.property, repro.failure.reason) in outcome.failures
    assert outcome.trace == summary.findings[0].outcome.trace
    assert path.with_suffix(".jsonl").read_text("utf-8") == outcome.trace


def test_a_world_may_be_called_what_no_program_is(tmp_path):
    """Such as two words: the file of a failure is read all the same."""
    check = check_of("broken", budget={"runs": 1}, overlay={"name": "two wings"})
    path = ResultsFolder(tmp_path).keep(check, searched(check).findings[0])

    assert read_repro(path).check.name == "two wings"


def test_a_file_that_was_moved_finds_its_controller_in_the_current_folder(found, tmp_path, monkeypatch):
    """Or in the folder that is given."""
    check, summary = found
    path = ResultsFolder(tmp_path / "a" / "b").keep(check, summary.findings[0])
    moved = path.rename(tmp_path / "moved.yaml")
    monkeypatch.chdir(check.folder)

    assert read_repro(moved).check.folder == check.folder
    assert read_repro(moved, check.folder).check.folder == check.folder


def test_the_trace_of_a_failure_is_replayed_without_its_controller(found):
    """Faults that are anchored to events are a part of the world in it."""
    trace = found[1].findings[0].outcome.trace

    assert replay(trace.splitlines(keepends=True)).difference is None


def test_the_story_says_what_it_needs_and_what_happened(found):
    """In words: the property, the schedule, what is without it, the events with the violation among them."""
    story = story_of(found[1].findings[0])

    assert story[0].startswith("no_vain_goals: ")
    assert story[2] == "It fails with one thing:"
    assert story[3].startswith("  1. breakdown of porter for 1 s, when ")
    assert story[4].startswith("Without it it passes: the run ends as succeeded at ")
    assert any("has the fault breakdown_1" in line for line in story)
    assert any("VIOLATED no_vain_goals" in line for line in story)


def test_events_that_repeat_themselves_are_told_once():
    """Whatever numbers are in them, and up to four together."""
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


def test_of_many_events_those_are_told_that_a_failure_is_about():
    """What its robot and its item did long before, rather than what the others did meanwhile."""
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
    """Of which one has failed, with the story; what was never exercised is skipped."""
    _, summary = found
    suite = ET.fromstring(junit_text(summary.name, summary.exercised, summary.findings, 1.5)).find("testsuite")
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    skipped = [case.get("name") for case in suite if case.find("skipped") is not None]

    assert failed == ["no_vain_goals"]
    assert "orders_in_time" in skipped
    assert (suite.get("tests"), suite.get("failures")) == (str(len(summary.exercised)), "1")


def test_the_page_tells_of_each_failure_and_of_what_was_not_reached(found, tmp_path):
    """In one file; texts of the user are escaped."""
    check, summary = found
    page = page_of(check, summary, tmp_path)

    assert "breakdown of porter for 1 s" in page
    assert "Not reached" in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_a_later_search_begins_with_what_was_found(found, tmp_path):
    """The folder has the failures."""
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


def test_a_run_knows_when_each_thing_began():
    """A change is there from the start; what has never begun has no time."""
    outcome = run_case(check_of("careful"), Case((LATE, EARLY, STALLED, NEVER, QUICK)))
    late, early, stalled, never, quick = outcome.began

    assert (quick, never) == (0.0, None)
    assert early == pytest.approx(stalled - 1.0)
    assert stalled < late


def test_the_first_cause_is_on_top():
    """Whatever the order of the schedule is; each with what comes of the run without it."""
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
    """As of one that was lost with its process."""
    assert by_begin((LATE, EARLY), Outcome("died")) == [0, 1]


def test_the_story_tells_of_a_disturbance_where_it_happens():
    """It is no event of the simulation, and the robots alone do not show what it was."""
    outcome = run_case(check_of("careful"), Case((STALLED,)), Wanted(story=True))
    texts = [text for _, text in outcome.story]

    assert texts.count("disturbance: the controller is stalled for 1 s") == 1
    (at,) = outcome.began
    assert (at, "disturbance: the controller is stalled for 1 s") in outcome.story
    assert mark_of("disturbance: the controller is stalled for 1 s") == "thing"
