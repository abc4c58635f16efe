"""Faults of batteries, docks, lifts and items."""

from __future__ import annotations

from functools import partial

import pytest

from hmrsim.errors import WorldError
from hmrsim.protocol.topics import Topic
from hmrsim.world_checks.loading import world_of
from tests import simulation
from tests.simulation import A, B, C, simulate

WORLD = {
    "waypoints": {"west": [0, 0], "east": [20, 0], "up": [120, 0], "stairs": [20, 100], "ward": [140, 0]},
    "lanes": [["west", "east"], ["up", "ward"]],
    "docks": {"charger": {"at": [10, 5], "type": "charger", "power": 2.0}, "bay": {"at": [15, 5]}},
    "lifts": {"lift": {"stops": ["east", "up"], "travel_time": 6.0, "door_time": 2.0}},
    "items": {"parcel": {"at": [20, 0]}},
    "robots": {
        name: {"at": "west", "components": {"battery": {"capacity": 1000, "drain": {"default": 1.0}}, "claw": {}}}
        for name in ("eve", "bob")
    },
}


def faulty(*faults, **keys):
    return simulate({**WORLD, **keys, "faults": [*faults]}, topics=frozenset({Topic.EVENTS}))


send = partial(simulation.send, robot="eve")


def go(x, goal_id=A, robot="eve"):
    return simulation.go(x, 0.0, goal_id, robot)


dock = partial(send, "dock_robot", dock_id="charger")


def tags(run, entity):
    return run.ask("get_entity_info", {"entity": entity}).info.tags


def charge(run, robot="eve"):
    return run.simulator.robots[robot].energy.battery.share(run.simulator.now)


def drop(share, **keys):
    return {"type": "battery_drop", "robot": "eve", "share": share, **keys}


@pytest.mark.parametrize(("share", "charge_after"), [(0.4, 0.4), (0.95, 0.9)])
def test_the_charge_drops_to_a_share_but_does_not_rise(share, charge_after):
    run = faulty(drop(share, at=100.0))
    run(until=99.0)
    before = charge(run)
    run(until=100.0)

    assert (0.901, charge_after) == (pytest.approx(before), pytest.approx(charge(run)))


def test_passed_charge_levels_are_published():
    log = faulty(drop(0.0, at=3.0))((0.0, go(20)))

    assert [3.0] * 3 == [log.happened(f"battery_{level}")[0][0] for level in ("low", "critical", "empty")]
    assert ((3.0, "ABORTED"), "battery_empty") == (log.changes(A)[-1], log.goal_changes(A)[-1].cause)


def test_charging_continues_from_the_lower_charge():
    run = faulty(drop(0.5, at=30.0))
    log = run((0.0, dock()), until=32.0)

    assert ("SUCCEEDED", 0.504) == (log.changes(A)[-1][1], pytest.approx(charge(run)))


def out(**keys):
    return {"type": "dock_out_of_order", "dock": "charger", **keys}


def test_docking_at_a_broken_dock_fails_after_lining_up():
    log = faulty(out())((0.0, dock()))
    end, result = log.goal_changes(A)[-1], log.result(A)

    assert ((10.0, "ABORTED"), "dock_out_of_order") == (log.changes(A)[-1], end.cause)
    assert (904, "'charger' is out of order") == (result.error_code, result.error_msg)


def test_a_robot_that_is_driving_in_fails_to_dock():
    run = faulty(out(at=12.0))
    log = run((0.0, dock()))

    assert ((15.0, "ABORTED"), 905) == (log.changes(A)[-1], log.result(A).error_code)
    assert "docked:eve" not in tags(run, "charger")


def test_a_docked_robot_is_not_charged_during_the_fault():
    run = faulty(out(at=20.0, until=30.0))
    charges = []
    for at in (20.0, 30.0, 35.0):
        log = run(*[] if charges else [(0.0, dock())], until=at)
        charges.append(charge(run))

    assert [20.0] == [time for time, _ in log.happened("charging_ended")]
    assert [15.0, 30.0] == [time for time, _ in log.happened("charging_began")]
    assert charges[0] > charges[1] < charges[2]


def test_docking_again_at_a_broken_charger_fails():
    log = faulty(out(at=20.0))((0.0, dock()), (21.0, dock(B)), until=25.0)

    assert ((21.0, "ABORTED"), 906) == (log.changes(B)[-1], log.result(B).error_code)


def test_a_queued_robot_fails_when_its_turn_comes():
    run = faulty(out(at=20.0))
    log = run((0.0, dock(robot="bob")), (1.0, dock(B)), (25.0, go(0, C, "bob")))

    assert ((35.0, "ABORTED"), 904) == (log.changes(B)[-1], log.result(B).error_code)
    assert "free" in tags(run, "charger")


def test_other_docks_keep_working():
    assert (20.0, "SUCCEEDED") == faulty(out())((0.0, send("dock_robot", dock_id="bay"))).changes(A)[-1]


def test_a_robot_that_is_moved_into_a_broken_dock_is_not_docked():
    run = faulty(out())
    run.ask("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": 10.0, "y": 5.0}}}})

    assert "docked" not in tags(run, "eve")


def test_a_dock_works_after_both_of_its_faults_end():
    run = faulty(out(until=5.0), out(until=8.0))
    seen = []
    for at in (4.0, 6.0, 9.0):
        run(until=at)
        seen.append("out_of_order" in tags(run, "charger"))

    assert [True, True, False] == seen


def test_a_broken_lift_takes_no_robot():
    log = faulty({"type": "lift_out_of_order", "lift": "lift"})((0.0, go(140)))
    result = log.result(A)

    assert (0.0, "ABORTED") == log.changes(A)[-1]
    assert (208, True) == (result.error_code, "lift is out of order" in result.error_msg)


def test_a_robot_at_the_lift_waits_for_the_repair():
    fault = {"type": "lift_out_of_order", "lift": "lift", "at": 15.0, "until": 40.0}
    log = faulty(fault, traffic={"policy": "free", "patience": 60.0})((0.0, go(140)))

    assert (70.0, "SUCCEEDED") == log.changes(A)[-1]


def test_a_ride_ends_during_the_fault():
    fault = {"type": "lift_out_of_order", "lift": "lift", "at": 22.0}
    log = faulty(fault)((0.0, go(140)), (23.0, go(140, B, "bob")), until=80.0)

    assert ((50.0, "SUCCEEDED"), "ABORTED") == (log.changes(A)[-1], log.changes(B)[-1][1])


def test_a_call_is_served_after_the_repair():
    run = faulty({"type": "lift_out_of_order", "lift": "lift", "until": 5.0})
    run(until=1.0)
    run.ask("call_lift", {"name": "lift", "stop": "up"})
    log = run(until=20.0)

    assert [5.0] == [time for time, _ in log.happened("lift_departed")]


def test_a_lost_item_can_not_be_picked_up():
    run = faulty({"type": "item_lost", "item": "parcel", "at": 1.0})
    log = run((0.0, go(20)), (20.0, send("pickup", B, target_name="parcel")))

    assert [(1.0, {"entity": "parcel"})] == log.happened("deleted")
    assert -19 == log.result(B).error_code.val


def test_a_robot_loses_its_item():
    run = faulty({"type": "item_lost", "item": "parcel", "when": {"event": "picked", "after": 2.0}})
    log = run((0.0, go(20)), (20.0, send("pickup", B, target_name="parcel")), (23.0, send("place", C)))

    assert ([22.0], -19) == ([time for time, _ in log.happened("deleted")], log.result(C).error_code.val)
    assert [] == run.simulator.robots["eve"].held


def test_losing_a_lost_item_is_missed():
    log = faulty(*({"type": "item_lost", "item": "parcel", "at": at} for at in (1.0, 2.0)))(until=3.0)

    assert [2.0] == [time for time, _ in log.happened("fault_missed")]


def test_an_order_whose_item_is_gone_is_lost():
    """The item of such an order is named by its kind and a number."""
    demand = [{"name": "meals", "item": "tray", "at": "west", "to": "east", "arrives": 10.0, "count": 2}]
    log = faulty({"type": "item_lost", "item": "tray_2", "at": 25.0}, demand=demand)(until=30.0)

    assert [(25.0, "meals_2")] == [(time, fields["order"]) for time, fields in log.happened("order_lost")]


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        (drop(1.5), "share: must be at most 1, got 1.5"),
        ({"type": "battery_drop", "robot": "eve"}, "share: is missing"),
        (out(dock="charge"), "dock: no dock 'charge'; did you mean 'charger'?"),
        ({"type": "lift_out_of_order", "lift": "left"}, "lift: no lift 'left'; did you mean 'lift'?"),
        ({"type": "item_lost", "item": "parcels"}, "item: no item 'parcels'; did you mean 'parcel'?"),
        ({"type": "item_lost", "item": "tray_2"}, "item: no item 'tray_2'; there are parcel"),
        (drop(0.1, when={"event": "dock_docked", "where": {"dock": "chargr"}}), "no dock 'chargr'; did you mean 'char"),
    ],
)
def test_invalid_faults_are_rejected(fault, why):
    with pytest.raises(WorldError) as raised:
        world_of({**WORLD, "faults": [fault]}, "small")

    assert why in str(raised.value)
