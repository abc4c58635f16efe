"""Sleep, Delay and Timeout, by BehaviorTree.CPP's documentation, in simulated time."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.actions.btcpp import Sleep
from bt_controller.nodes.controls.sequences import ReactiveSequence
from bt_controller.nodes.decorators.gates import Delay, Timeout
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

SECOND = {"msec": "1000"}
LATE = {"delay_msec": "2000"}


@rows(
    {
        "sleep runs for a time": Row(Sleep, "", "RRS", {"msec": "1500"}, (10.0, 11.4, 11.5)),
        "sleep needs no look before its end": Row(Sleep, "", "R", {"msec": "1500"}, (10.25,), due=11.75),
        "sleep begins anew after a halt": Row(Sleep, "", "R!RRS", SECOND, (10.0, 10.5, 11.0, 11.5)),
        "no sleep succeeds at once": Row(Sleep, "", "S", {"msec": "0"}),
        "delay ticks its child after a time": Row(Delay, "RF", "RRRF", LATE, (5.0, 6.9, 7.0, 7.1), ticks="2"),
        "delay ticks no child before that": Row(Delay, "RF", "RR", LATE, (5.0, 6.9), ticks="0"),
        "delay needs no look before its end": Row(Delay, "R", "R", LATE, (5.25,), due=7.25),
        "delay needs no look while its child runs": Row(Delay, "R", "RR", LATE, (5.25, 7.25), due=NEVER),
        "delay begins anew": Row(Delay, "S", "RSR!RS", {"delay_msec": "1000"}, (0.0, 1.0, 1.5, 2.0, 3.0)),
        "delay is skipped with its child": Row(Delay, "-", "-", {"delay_msec": "0"}),
        "timeout ends as its child does": Row(Timeout, "RS", "RS", SECOND, (4.0, 4.9)),
        "timeout halts a child that takes too long": Row(Timeout, "R", "RRF", SECOND, (4.0, 4.9, 5.0), halts="1"),
        "timeout accepts an end at the last moment": Row(Timeout, "RS", "RS", SECOND, (4.0, 5.0)),
        "timeout is due when the time is over": Row(Timeout, "R", "R", {"msec": "60000"}, (10.25,), due=70.25),
        "timeout of zero is none": Row(Timeout, "R", "RR", {"msec": "0"}, (0.0, 1e6), due=NEVER),
        "timeout begins anew": Row(Timeout, "R", "RFRRF", SECOND, (0.0, 1.0, 1.5, 2.4, 2.5)),
        "timeout is skipped with its child": Row(Timeout, "-", "-", {"msec": "0"}),
    }
)
def test_timing(behaves, row):
    behaves(row)


def test_sleep_that_has_ended_is_looked_at_where_it_is_ticked_again(node, tree, told):
    root = tree(node(ReactiveSequence, node(Sleep, msec="0"), told("R")))
    root.tick(10.25)

    assert 11.0 == root.due()


def test_a_malformed_number_is_an_error(node, tree):
    with pytest.raises(PortError, match="port 'msec': 'soon' is not a whole number"):
        tree(node(Sleep, msec="soon"))
