"""Decorators that change or repeat what their child does, by BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.decorators.gates import ForceFailure, ForceSuccess, Inverter, Precondition, RunOnce
from bt_controller.nodes.decorators.repetition import KeepRunningUntilFailure, Repeat, RetryUntilSuccessful
from bt_controller.scripting.parser import ScriptError, parse
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

Retry = RetryUntilSuccessful
Keep = KeepRunningUntilFailure


def cycles(number):
    return {"num_cycles": str(number)}


def attempts(number):
    return {"num_attempts": str(number)}


def only_if(script):
    return Precondition.bind({"if": parse(script)})


@rows(
    {
        "Inverter changes success and failure": Row(Inverter, "RSF-", "RFS-"),
        "ForceSuccess changes failure": Row(ForceSuccess, "RSF-", "RSS-"),
        "ForceFailure changes success": Row(ForceFailure, "RSF-", "RFF-"),
        "a running child is not looked at": Row([Inverter, ForceSuccess, ForceFailure], "R", "R", due=NEVER),
        "repeat ticks its child as often as its port says": Row(Repeat, "S", "S", cycles(3), ticks="3", begun="3"),
        "repeat counts over ticks": Row(Repeat, "RSRS", "RRS", cycles(2), ticks="4", begun="2"),
        "repeat fails with its child": Row(Repeat, "SFSSS", "FS", cycles(3), ticks="5"),
        "repeat is skipped with its child": Row(Repeat, "-", "-", cycles(3)),
        "repeat of no cycles succeeds": Row(Repeat, "F", "S", cycles(0), ticks="0"),
        "repeat for ever has one turn a tick": Row(Repeat, "SSF", "RR", cycles(-1), ticks="2", begun="2", due=2.0),
        "repeat for ever ends with a failure only": Row(Repeat, "SSF", "RRF", cycles(-1), ticks="3", begun="3"),
        "repeat for ever begins the next turn in the tick in which a longer one ended": Row(
            Repeat, "RSRSR", "RRR", cycles(-1), ticks="5", begun="3", due=NEVER
        ),
        "repeat counts anew after a halt": Row(Repeat, "SRSSS", "R!S", cycles(3), ticks="5"),
        "retry ticks its child until it succeeds": Row(Retry, "FFS", "S", attempts(5), ticks="3", begun="3"),
        "retry fails after as many failures as its port says": Row(Retry, "RF", "RF", attempts(3), ticks="4"),
        "retry for ever looks each tick": Row(Retry, "FFS", "RR", attempts(-1), ticks="2", due=2.0),
        "retry for ever ends with a success": Row(Retry, "FFS", "RRS", attempts(-1), ticks="3"),
        "retry is skipped with its child": Row(Retry, "-", "-", attempts(3)),
        "retry looks at its port again": Row(
            Retry, "FRF", ["R", {"tries": 2}, "F"], {"num_attempts": "{tries}"}, before={"tries": 3}, ticks="3"
        ),
        "a last turn that took no time is the end": Row(Retry, "RF", "RF", attempts(1), (3, 3)),
        "keep running runs until a failure": Row(Keep, "SR-SF", "RRRRF", ticks="5"),
        "keep running is looked at where its child has ended": Row(Keep, "S", "R", due=1.0),
        "keep running is not looked at while its child runs": Row(Keep, "R", "R", due=NEVER),
        "run once is skipped afterwards": Row(RunOnce, "RF", "RF--", ticks="2"),
        "run once may return its child's status again": Row(RunOnce, "RF", "RFFF", {"then_skip": "false"}, ticks="2"),
        "run once remembers over a halt": Row(RunOnce, "S", "S!-"),
        "run once forgets a run that was halted": Row(RunOnce, "RS", "R!S"),
        "run once does not count a skipped child": Row(RunOnce, "-S", "-S"),
        "a false precondition may succeed": Row(only_if("1 > 2"), "S", "S", {"else": "SUCCESS"}, ticks="0"),
        "a false precondition may run and is looked at": Row(
            only_if("1 > 2"), "S", "R", {"else": "RUNNING"}, ticks="0", due=1.0
        ),
        "a false precondition may be skipped": Row(only_if("1 > 2"), "S", "-", {"else": "SKIPPED"}, ticks="0"),
        "a false precondition fails by default": Row(only_if("false"), "S", "F", ticks="0"),
        "a precondition is not looked at while the child runs": Row(
            only_if("go"), "RSS", ["R", {"go": False}, "SF"], before={"go": True}, ticks="2"
        ),
        "a running child needs no look below a precondition": Row(only_if("true"), "R", "R", due=NEVER),
    }
)
def test_decorators(behaves, row):
    behaves(row)


@pytest.mark.parametrize(("kind", "ports", "status"), [(Repeat, cycles(2500), "S"), (Retry, attempts(2500), "F")])
def test_a_thousand_turns_are_enough_for_one_tick(behaves, kind, ports, status):
    """The others have to have their turn, too; the tree is to be ticked again."""
    behaves(Row(kind, status, "R", ports, ticks="1000", due=1.0))
    behaves(Row(kind, status, f"RR{status}", ports, ticks="2500"))


@pytest.mark.parametrize(
    ("kind", "ports", "statuses"),
    [
        (Repeat, cycles(-1), "RSR"),
        (Repeat, cycles(9), "RSR"),
        (Retry, attempts(-1), "RFR"),
        (Retry, attempts(9), "RFR"),
        (Keep, {}, "RSR"),
    ],
)
def test_a_child_that_ran_and_took_no_time_begins_again_a_period_later(behaves, kind, ports, statuses):
    """A goal that ends at once must not keep time from going on, however often something else happens at that time."""
    behaves(Row(kind, statuses, "RRR", ports, (3, 3, 3), begun="1", due=4.0))
    behaves(Row(kind, statuses, "RRRR", ports, (3, 3, 3, 4), begun="2"))


def test_a_precondition_takes_statuses_only(node, tree, told):
    with pytest.raises(
        PortError, match="port 'else': 'MAYBE' is not a status; expected SUCCESS, FAILURE, RUNNING or SKIPPED"
    ):
        tree(node(only_if("false"), told("S"), **{"else": "MAYBE"}))


def test_a_precondition_without_a_value_is_an_error(node, tree, told):
    with pytest.raises(ScriptError, match=r"^Precondition1: script 'missing > 1': 'missing' has no value"):
        tree(node(only_if("missing > 1"), told("S"))).tick()


def test_an_entry_of_a_script_is_not_named_as_a_port():
    with pytest.raises(ScriptError, match=r"script 'else > 1': 'else' is a port of Precondition, not an entry"):
        only_if("else > 1")
