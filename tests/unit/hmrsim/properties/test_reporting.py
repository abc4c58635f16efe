"""Conditions on reported outcomes, and the comparison with the run without faults."""

from __future__ import annotations

import pytest

from hmrsim.errors import PropertyError
from hmrsim.events import from_json
from hmrsim.history.occurrence import Occurrence
from hmrsim.properties import Ended, Monitor, properties_of
from hmrsim.properties.results import ItemEnd, reference_of
from tests.watching import OFF, Feed, seconds, ward

ARRIVED = {"item": "medicine", "at": "ward_a", "carried": False}
SAID = {"told": {"reports": "succeeded", "then": ARRIVED}}


def placed(feed: Feed, at: float, x: float = 20.0) -> Feed:
    """Feed that the medicine is put down at a point of the line."""
    return feed.event(at, "placed", robot="eve", item="medicine", at=[x, 0.0])


def test_a_false_report_of_success_is_a_violation():
    feed = Feed(SAID).end(9)

    assert feed.violations == [
        (9.0, "told", "", "reported succeeded, but not: medicine is at ward_a and is not carried")
    ]
    assert "reports succeeded, but it is not true that medicine is at ward_a" in feed.monitor.violations[0].text


@pytest.mark.parametrize("report", ["succeeded", "failed"])
def test_a_reported_failure_promises_nothing(report):
    feed = Feed({"told": {"reports": report, "then": ARRIVED}})
    feed.end(9, "failed" if report == "succeeded" else "succeeded")

    assert feed.verdict("told").state == "never_exercised"


def test_a_true_report_holds():
    """The medicine is put down in the last instant."""
    assert placed(Feed(SAID), 9).end(9).verdict("told").state == "holds"


@pytest.mark.parametrize("ending", [None, "stopped"])
def test_a_run_whose_end_is_not_known_is_undecided(ending):
    assert Feed(SAID).end(9, ending).verdict("told").state == "undecided"


def test_a_label_of_end_run_is_a_report_at_its_instant():
    """Neither later changes of the medicine nor other labels count."""
    feed = Feed({"told": {"reports": "arrived", "then": ARRIVED}})
    feed.event(1, "run_reported", label="other", values={})
    placed(feed, 5).event(5, "run_reported", label="arrived", values={})
    placed(feed, 7, x=0.0).event(8, "run_reported", label="arrived", values={})
    feed.end(9)

    assert [at for at, *_ in feed.violations] == [8.0]


def test_a_report_can_be_about_each_robot():
    feed = Feed({"full": {"reports": "succeeded", "then": {"robot": "*", "at": "lab"}}}).end(9)

    assert [subject for _, _, subject, _ in feed.violations] == ["wall_e", "cart"]


def test_a_report_is_one_word():
    with pytest.raises(PropertyError, match=r"told\.reports"):
        properties_of({"properties": {"told": {"reports": "it worked", "then": ARRIVED}}})


AS_BEFORE = {"same": {"reports": "succeeded", "then": {"items": "as_without_faults"}}}


def compared(reference, *events, properties=AS_BEFORE, **world):
    """Return the monitor of a run that succeeds at 9 s, after some events."""
    monitor = Monitor(properties_of({"properties": properties, "built_in": OFF}), ward(**world), reference)
    monitor.begin(0)
    for at, kind, fields in events:
        monitor.take(Occurrence(seconds(at), from_json({"kind": kind, **fields})))
    monitor.end(seconds(9), Ended("succeeded"))
    return monitor


PLACED = (5, "placed", {"robot": "eve", "item": "medicine", "at": [20.5, 0.0]})
PICKED = (4, "picked", {"robot": "eve", "item": "medicine"})


@pytest.mark.parametrize(
    ("reference", "events", "state"),
    [
        (ItemEnd((20.0, 0.0), carried=False), (PICKED, PLACED), "holds"),
        (ItemEnd((20.0, 0.0), carried=False), (), "violated"),
        (ItemEnd((20.0, 0.0), carried=False), (PICKED,), "violated"),
        (ItemEnd((20.0, 0.0), carried=True), (PICKED,), "holds"),
        (ItemEnd((20.0, 0.0), carried=True), (PICKED, PLACED), "violated"),
    ],
)
def test_items_are_compared_with_those_of_the_run_without_faults(reference, events, state):
    """They match within the reach of a claw, or if they are carried in both runs."""
    (verdict,) = compared({"medicine": reference}, *events).verdicts()

    assert verdict.state == state


def test_without_a_reference_run_the_comparison_is_undecided():
    (verdict,) = compared(None).verdicts()

    assert (verdict.state, verdict.text) == ("undecided", "there is no run without faults to compare with")


def test_items_that_a_smaller_world_lacks_are_not_compared():
    """The reduction of a failure removes items, and items of orders come later."""
    reference = {"letter": ItemEnd((20.0, 0.0), carried=False), "medicine": ItemEnd((0.0, 0.5), carried=False)}
    (lacking,) = compared(reference).verdicts()
    (ordered,) = compared({"pills_1": ItemEnd((20.0, 0.0), carried=False)}).verdicts()

    assert (lacking.state, ordered.state) == ("holds", "violated")


def test_the_comparison_can_be_used_as_any_condition():
    eventually = {"same": {"eventually": {"items": "as_without_faults"}}}
    (verdict,) = compared({"medicine": ItemEnd((20.0, 0.0), carried=False)}, PLACED, properties=eventually).verdicts()

    assert verdict.state == "holds"


def test_a_reference_has_the_place_and_carrier_of_each_item():
    items = [{"name": "a", "at": [1.0, 2.0], "carrier": None}, {"name": "b", "at": [0.0, 0.0], "carrier": "eve"}]

    assert reference_of({"items": items}) == {
        "a": ItemEnd((1.0, 2.0), carried=False),
        "b": ItemEnd((0.0, 0.0), carried=True),
    }
