"""The time of a run: alarms ring between events, and an instant is settled when it is over."""

from __future__ import annotations

import pytest

from hmrsim.events import from_json
from hmrsim.events.facilities import DoorOpened
from hmrsim.history.occurrence import BatterySeen, Occurrence
from hmrsim.history.timeline import Phase, Timeline


@pytest.fixture
def told():
    """Return the log of callbacks, in order."""
    return []


@pytest.fixture
def timeline(told):
    """Return a started timeline, with an observer of doors that open."""
    made = Timeline()
    made.begin(0)
    made.on(DoorOpened, lambda at, event: told.append((at, event.door)))
    return made


def opened(at, door="gate"):
    return Occurrence(at, from_json({"kind": "door_opened", "door": door}))


def test_alarms_ring_in_order_before_later_events(timeline, told):
    timeline.alarm(7, Phase.CHANGE, lambda at: told.append((at, "second")))
    timeline.alarm(5, Phase.CHANGE, lambda at: told.append((at, "first")))
    timeline.take(opened(9))

    assert [(5, "first"), (7, "second"), (9, "gate")] == told


def test_at_one_instant_changes_come_first_and_expiries_last(timeline, told):
    timeline.alarm(5, Phase.EXPIRY, lambda at: told.append((at, "late")))
    timeline.alarm(5, Phase.CHANGE, lambda at: told.append((at, "change")))
    timeline.take(opened(5))
    timeline.settle(lambda at: told.append((at, "settled")))
    timeline.take(opened(6))

    assert [(5, "change"), (5, "gate"), (5, "settled"), (5, "late"), (6, "gate")] == told


def test_alarms_set_by_settling_an_instant_ring_before_later_events(timeline, told):
    timeline.take(opened(2))
    timeline.settle(lambda at: timeline.alarm(at + 2, Phase.CHANGE, lambda due: told.append((due, "rings"))))
    timeline.take(opened(9))

    assert [(2, "gate"), (4, "rings"), (9, "gate")] == told


def test_a_canceled_alarm_does_not_ring(timeline, told):
    timeline.alarm(5, Phase.CHANGE, lambda at: told.append((at, "rings"))).cancel()
    timeline.take(opened(9))

    assert [(9, "gate")] == told


def test_times_after_a_reset_continue_from_the_last_one(timeline, told):
    for at in (10_000_000_000, 2_000_000_000, 5_000_000_000):
        timeline.take(opened(at))

    assert ([10_000_000_000, 10_000_000_000, 13_000_000_000], 1) == ([at for at, _ in told], timeline.restarts)


def test_a_late_sample_is_no_reset(timeline):
    """Samples of a battery may come late."""
    timeline.take(opened(10_000_000_000))
    timeline.take(Occurrence(2_000_000_000, BatterySeen("eve", 0.5)))

    assert 0 == timeline.restarts


def test_an_announced_reset_has_its_time(timeline, told):
    timeline.take(opened(1_000_000_000))
    timeline.restart(7_000_000_000)
    timeline.take(opened(2_000_000_000))

    assert [1_000_000_000, 9_000_000_000] == [at for at, _ in told]


def test_alarms_due_at_the_end_ring(timeline, told):
    timeline.alarm(5, Phase.EXPIRY, lambda at: told.append((at, "late")))
    timeline.alarm(6, Phase.EXPIRY, lambda at: told.append((at, "later")))
    timeline.end(5)

    assert [(5, "late")] == told
