"""The orders of a run: their state is that of the demand, also when an item is dropped."""

from __future__ import annotations

import pytest

from hmrsim.events import from_json
from hmrsim.history.history import History
from hmrsim.history.occurrence import Occurrence
from hmrsim.history.timeline import Timeline
from hmrsim.world.model import World


@pytest.fixture
def timeline():
    """Return the timeline of a run that has begun."""
    timeline = Timeline()
    timeline.begin(0)
    return timeline


@pytest.fixture
def orders(timeline):
    return History(timeline, World()).orders


@pytest.fixture
def happen(timeline):
    """Return a function that lets an event of the order *o* and its item *box* happen at a second."""

    def take(second, kind, **fields):
        event = from_json({"kind": kind, "item": "box", **fields})
        timeline.take(Occurrence(second * 1_000_000_000, event))

    return take


def test_an_order_waits_again_when_its_item_is_dropped(orders, happen):
    """The robot that dropped the item no longer carries the order."""
    happen(1, "order_placed", order="o", **{"from": "a", "to": "b"})
    happen(2, "order_picked_up", order="o", robot="eve")
    happen(3, "dropped", robot="eve", at=[0.0, 0.0])

    (order,) = orders.all
    assert ("waiting", "", 2_000_000_000) == (order.state, order.robot, order.picked_up)


def test_an_order_from_before_a_recording_has_a_state_but_no_account(orders, happen):
    """A recording that begins late lacks the event of an order's beginning."""
    happen(1, "order_delivered", order="o", lead_time=5.0, robot="eve")

    assert (True, []) == (orders.is_("o", "delivered"), orders.all)


def test_a_part_is_followed_only_once_it_is_read(timeline):
    """A history subscribes to no events of parts that no consumer reads."""
    history = History(timeline, World())
    before = {*timeline.handlers}

    assert history.batteries
    assert (2, True) == (len(before), len(timeline.handlers) > len(before))
