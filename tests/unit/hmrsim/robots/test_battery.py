"""Batteries: consumption, reported levels, empty robots, and charging."""

from __future__ import annotations

import math
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hmrsim.components.battery import Battery, BatterySettings
from hmrsim.protocol.commands import CancelGoal, Read
from hmrsim.protocol.goal import Refused
from hmrsim.protocol.outputs import Sampled
from hmrsim.protocol.topics import Topic
from tests import simulation
from tests.simulation import simulate

A, B, C = (letter * 32 for letter in "abc")
STATUS_CHARGING, STATUS_DISCHARGING, STATUS_NOT_CHARGING, STATUS_FULL = 1, 2, 3, 4


@pytest.fixture
def make_run():
    """Return the function that makes simulations with only the outputs that these tests read, as some are long."""
    return partial(simulate, topics=frozenset({Topic.EVENTS}))


def world(base=None, docks=None, **battery):
    """Return a world of one robot, 10 m from a dock, whose battery has these settings."""
    return {
        "waypoints": {"home": [0, 0], "shelf": [20, 0], "far": [100, 0]},
        "lanes": [["home", "shelf"], ["shelf", "far"]],
        "docks": {"charger": {"at": [-10, 0], "type": "charger", "power": 2.0}} if docks is None else docks,
        "items": {"parcel": {"at": [20, 0], "weight": 4.0}},
        "robots": {
            "eve": {
                "at": "home",
                "base": base or {},
                "components": {"battery": {"capacity": 100, **battery}, "claw": {"handling_time": 3}},
            }
        },
    }


send = partial(simulation.send, robot="eve")


def go(x, goal_id=A):
    return send("navigate_to_pose", goal_id, pose={"pose": {"position": {"x": x}}})


def wait(seconds, goal_id=A):
    return send("wait", goal_id, time={"sec": seconds})


def put_at(run, x):
    run.ask("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": x}}}})


def charge(run):
    return run.simulator.robots["eve"].energy.battery.charge(run.simulator.now)


def state(run):
    return run.simulator.robots["eve"].energy.state()


def test_the_state_is_in_the_frame_of_the_robot(make_run):
    run = make_run(world())

    assert "eve/base_link" == state(run).header.frame_id


class TestDrain:
    @pytest.mark.parametrize(
        ("drain", "left"),
        [
            ({}, 70.0),
            ({"default": 0.5}, 85.0),
            ({"still": 0.1, "moving": 2.0}, 59.0),
            ({"still": 0.0, "default": 1.0}, 80.0),
            ({"default": 0.0, "distance": 1.5}, 70.0),
            ({"still": 1.0, "moving": 0.0, "distance": 0.25}, 85.0),
            ({"default": 0.0, "actions": {"wait": 3.0}}, 70.0),
            ({"default": 0.0, "actions": {"navigate_to_pose": 0.5, "wait": 1.0}}, 80.0),
        ],
    )
    def test_time_distance_and_actions_drain_a_battery(self, make_run, drain, left):
        """20 s and 20 m of driving, then 10 s of waiting."""
        run = make_run(world(drain=drain))
        run((0.0, go(20.0)), (20.0, wait(10, B)), until=30.0)

        assert left == pytest.approx(charge(run))

    def test_carrying_and_handling_drain_a_battery(self, make_run):
        """20 s empty, 5 units to pick 4 kg up, 20 s with them, 5 units to put them down, 10 s empty."""
        run = make_run(world(drain={"default": 0.5, "load": 0.1, "handling": 5.0}))
        run(
            (0.0, go(20.0)),
            (20.0, send("pickup", B, target_name="parcel")),
            (23.0, go(37.0, C)),
            (40.0, send("place", "d" * 32)),
            until=53.0,
        )

        # 53 s at 0.5; 0.4 a second from 23 s to 43 s; two times 5.
        assert 100.0 - 26.5 - 8.0 - 10.0 == pytest.approx(charge(run))

    def test_consumption_by_distance_does_not_depend_on_speed(self, make_run):
        drain = {"default": 0.0, "distance": 1.0}
        run = make_run(world({"speed": 0.4, "acceleration": 0.1}, drain=drain))
        run((0.0, go(20.0)))

        assert 80.0 == pytest.approx(charge(run))

    def test_a_battery_schedules_no_events_while_nothing_changes(self, make_run):
        run = make_run(world())
        run((0.0, wait(10)))

        assert 10.0 == run.simulator.now
        assert math.inf == run.simulator.next_event

    def test_another_robot_does_not_change_the_consumption(self, make_run):
        one, two = world(initial_charge=30), world(initial_charge=30)
        two["robots"]["wall_e"] = {"at": "far", "components": {"battery": {}}}
        logs = [make_run(each)((0.0, go(100.0)), until=99.0) for each in (one, two)]

        assert logs[0].happened("battery_empty") == logs[1].happened("battery_empty")


class TestLevels:
    def test_low_critical_and_empty_are_reported_when_reached(self, make_run):
        """The levels are 20 and 5 of 100 units, one of which is used per second."""
        log = make_run(world(initial_charge=50))((0.0, wait(100)), until=100.0)
        told = [
            (at, kind, fields["charge"], fields["percentage"])
            for kind in ("low", "critical", "empty")
            for at, fields in log.happened(f"battery_{kind}")
        ]

        assert [(30.0, "low", 20.0, 0.2), (45.0, "critical", 5.0, 0.05), (50.0, "empty", 0.0, 0.0)] == told

    def test_equal_levels_are_reported_together(self, make_run):
        run = make_run(world(low=0.5, critical=0.5))
        log = run((0.0, wait(60)), until=60.0)

        assert [50.0] == [at for at, _ in log.happened("battery_low")]
        assert [50.0] == [at for at, _ in log.happened("battery_critical")]

    def test_a_battery_that_starts_low_has_a_tag_and_no_event(self, make_run):
        run = make_run(world(initial_charge=20))
        log = run(until=10.0)

        assert [] == log.happened("battery_low")
        assert "battery_low" in run.ask("get_entity_info", {"entity": "eve"}).info.tags

    def test_levels_skipped_by_handling_are_reported_at_once(self, make_run):
        """Three levels at once, and the goal has succeeded."""
        run = make_run(world(initial_charge=60, drain={"default": 1.0, "handling": 50.0}))
        log = run((0.0, go(20.0)), (20.0, send("pickup", B, target_name="parcel")))

        assert (23.0, "SUCCEEDED") == log.changes(B)[-1]
        assert [[23.0]] * 3 == [
            [at for at, _ in log.happened(f"battery_{level}")] for level in ("low", "critical", "empty")
        ]
        assert 0.0 == charge(run)


class TestEmpty:
    def test_an_empty_robot_stops_and_its_goal_is_aborted_with_the_place(self, make_run):
        run = make_run(world(initial_charge=12.5))
        log = run((0.0, go(20.0)))

        assert (12.5, "ABORTED") == log.changes(A)[-1]
        assert (9000, "battery empty at (12.5, 0)") == (log.result(A).error_code, log.result(A).error_msg)
        assert [(12.5, [12.5, 0.0])] == [(at, fields["at"]) for at, fields in log.happened("battery_empty")]
        assert (12.5, 0.0) == run.simulator.robots["eve"].pose().point
        assert "battery_empty" in run.ask("get_entity_info", {"entity": "eve"}).info.tags

    def test_an_empty_robot_rejects_goals(self, make_run):
        log = make_run(world(initial_charge=5))((0.0, wait(10)), (8.0, go(20.0, B)))
        answer = log.answer(B)

        assert (False, "not_ready", "battery empty at (0, 0)") == (answer.accepted, answer.reason, answer.error_msg)

    def test_a_robot_can_start_empty(self, make_run):
        log = make_run(world(initial_charge=0))((0.0, go(20.0)))

        assert "not_ready" == log.answer(A).reason

    def test_a_charging_robot_is_ready_when_it_is_not_critical(self, make_run):
        """Two units a second make 5 of 100 after 2.5 s."""
        run = make_run(world(initial_charge=5))
        run((0.0, wait(10)), until=10.0)
        put_at(run, -10.0)
        run((12.0, go(20.0, B)), (12.5, go(20.0, C)), until=13.0)

        assert "not_ready" == run.log.answer(B).reason
        assert run.log.answer(C).accepted
        assert [(12.5, 0.05)] == [(at, told["percentage"]) for at, told in run.log.happened("battery_revived")]

    def test_without_a_critical_level_a_robot_is_ready_at_a_hundredth(self, make_run):
        """Otherwise it would stop again at once."""
        run = make_run(world(initial_charge=5, critical=0.0))
        run((0.0, wait(10)), until=10.0)
        put_at(run, -10.0)
        run(until=12.0)

        assert [10.5] == [at for at, _ in run.log.happened("battery_revived")]

    def test_the_empty_level_can_be_above_zero(self, make_run):
        run = make_run(world(initial_charge=40, stops_below=0.3, critical=0.3, low=0.3))
        log = run((0.0, wait(60)), until=20.0)
        put_at(run, -10.0)
        run(until=30.0)

        assert [(10.0, 30.0, 0.3)] == [
            (at, told["charge"], told["percentage"]) for at, told in log.happened("battery_empty")
        ]
        assert (10.0, "ABORTED") == log.changes(A)[-1]
        assert [(20.5, 31.0)] == [(at, told["charge"]) for at, told in log.happened("battery_revived")]

    def test_an_empty_robot_blocks_its_lane(self, make_run):
        run = make_run(world(initial_charge=12.5))
        run((0.0, go(20.0)), until=13.0)
        put_at(run, -10.0)

        assert [12.5, 12.5] == [at for at, _ in run.log.happened("lane_closed")]
        assert [13.0, 13.0] == [at for at, _ in run.log.happened("lane_opened")]


class TestCharging:
    def test_charging_is_constant_and_then_tapers(self, make_run):
        """From 0.8 of 100 on, two units a second fall to a twentieth at 100, by an exponential."""
        run = make_run(world(initial_charge=40))
        put_at(run, -10.0)
        limit = (100 - 0.05 * 80) / 0.95
        slowness = (limit - 80) / 2
        full = 20 + slowness * math.log(20)
        run(until=10.0)
        assert (60.0, 2.0) == pytest.approx((charge(run), run.simulator.robots["eve"].energy.battery.flow(10.0)))
        run(until=30.0)
        assert limit - (limit - 80) * math.exp(-10 / slowness) == pytest.approx(charge(run))
        log = run(until=60.0)

        assert [0.0] == [at for at, _ in log.happened("charging_began")]
        assert [full] == pytest.approx([at for at, _ in log.happened("battery_full")])
        assert log.happened("battery_full")[0][1] == log.happened("charging_ended")[0][1]
        assert 100.0 == charge(run)

    def test_without_a_taper_charging_is_constant(self, make_run):
        run = make_run(world(initial_charge=40, taper_from=1.0))
        put_at(run, -10.0)
        log = run(until=60.0)

        assert [30.0] == [at for at, _ in log.happened("battery_full")]

    def test_a_charger_without_a_power_fills_in_a_quarter_of_an_hour(self, make_run):
        """Only the taper takes longer than that."""
        run = make_run(world(docks={"charger": {"at": [-10, 0], "type": "charger"}}, initial_charge=0, taper_from=1.0))
        put_at(run, -10.0)
        log = run(until=1000.0)

        assert [900.0] == pytest.approx([at for at, _ in log.happened("battery_full")])

    def test_a_dock_charges_only_with_a_power(self, make_run):
        run = make_run(world(docks={"charger": {"at": [-10, 0]}}))
        put_at(run, -10.0)
        run(until=10.0)

        assert 90.0 == charge(run)

    def test_leaving_the_dock_ends_charging(self, make_run):
        run = make_run(world(initial_charge=40))
        put_at(run, -10.0)
        log = run((10.0, go(0.0)), until=20.0)

        assert [(10.0, 60.0)] == [(at, told["charge"]) for at, told in log.happened("charging_ended")]
        assert 50.0 == charge(run)

    def test_low_is_reported_again_after_charging(self, make_run):
        run = make_run(world(initial_charge=25))
        run(until=10.0)
        put_at(run, -10.0)
        run((20.0, go(0.0)), until=60.0)

        assert [5.0, 35.0] == [at for at, _ in run.log.happened("battery_low")]


class TestMessage:
    def test_every_field_of_the_message_is_set(self, make_run):
        """Half of 3600 units, which are a watt hour, at 10 V; two watts go out."""
        settings = {"capacity": 3600, "initial_charge": 1800, "nominal_voltage": 10.0, "cells": 4, "temperature": 25.0}
        message = state(make_run(world(**settings, drain={"still": 2.0}, technology="lipo")))

        assert (10.0, 25.0, -0.2) == pytest.approx((message.voltage, message.temperature, message.current))
        assert (0.05, 0.1, 0.1, 0.5) == pytest.approx(
            (message.charge, message.capacity, message.design_capacity, message.percentage)
        )
        assert (STATUS_DISCHARGING, 1, 3, True) == (
            message.power_supply_status,
            message.power_supply_health,
            message.power_supply_technology,
            message.present,
        )
        assert [2.5] * 4 == pytest.approx(message.cell_voltage)
        assert [25.0] * 4 == message.cell_temperature
        assert ("", "eve") == (message.location, message.serial_number)

    @pytest.mark.parametrize(("initial_charge", "volts"), [(0, 9.0), (50, 10.0), (100, 11.0)])
    def test_the_voltage_falls_with_the_charge(self, make_run, initial_charge, volts):
        """It is a tenth of the nominal voltage to either side."""
        run = make_run(world(initial_charge=initial_charge, nominal_voltage=10.0))

        assert volts == pytest.approx(state(run).voltage)

    def test_the_status_is_discharging_charging_full_or_not_charging(self, make_run):
        run = make_run(world(initial_charge=40))
        seen = [state(run).power_supply_status]
        put_at(run, -10.0)
        seen.append(state(run).power_supply_status)
        run(until=60.0)
        seen.append(state(run).power_supply_status)
        put_at(run, 0.0)
        run(until=161.0)
        seen.append(state(run).power_supply_status)

        assert [STATUS_DISCHARGING, STATUS_CHARGING, STATUS_FULL, STATUS_NOT_CHARGING] == seen

    def test_the_current_is_the_rate_of_the_charge(self, make_run):
        """Both agree while charging tapers, too."""
        run = make_run(world(initial_charge=85))
        put_at(run, -10.0)
        before = state(run)
        run(until=0.001)

        assert before.current == pytest.approx((state(run).charge - before.charge) * 3600 / 0.001, rel=1e-3)

    def test_a_failed_cell_takes_its_share_of_capacity_and_charge(self, make_run):
        run = make_run(world(nominal_voltage=10.0, cells=4, initial_charge=80))
        energy = run.simulator.robots["eve"].energy
        energy.fail_cell(2)
        failed = state(run)
        energy.mend(2)

        assert (0.75, 0.8, 5) == pytest.approx(
            (failed.capacity / failed.design_capacity, failed.percentage, failed.power_supply_health)
        )
        assert 60.0 == pytest.approx(failed.charge * 3600 * 10)
        assert [True, True, False, True] == [volts > 0 for volts in failed.cell_voltage]
        assert sum(failed.cell_voltage) == failed.voltage
        assert (80.0, 1) == pytest.approx((charge(run), state(run).power_supply_health))

    def test_without_any_cell_a_battery_is_dead(self, make_run):
        run = make_run(world(cells=1))
        run.simulator.robots["eve"].energy.fail_cell(0)
        log = run((1.0, go(20.0)))

        assert (3, 0.0) == (state(run).power_supply_health, state(run).percentage)
        assert "not_ready" == log.answer(A).reason

    def test_the_state_is_published_each_second_and_at_events(self, make_run):
        run = make_run(world(initial_charge=22.5), topics=frozenset({Topic.BATTERY_STATE}))
        log = run(until=4.0)

        assert [1.0, 2.0, 2.5, 3.0, 4.0] == [at for at, event in log.events if isinstance(event, Sampled)]

    def test_the_rate_can_be_set(self, make_run):
        run = make_run(world(), battery_rate=0.5, topics=frozenset({Topic.BATTERY_STATE}))
        log = run(until=6.0)

        assert [2.0, 4.0, 6.0] == [at for at, event in log.events if isinstance(event, Sampled)]

    def test_the_latest_state_can_be_read_if_there_is_a_battery(self, make_run):
        made = world()
        made["robots"]["cart"] = {"at": "far"}
        run = make_run(made)
        log = run(
            (7.0, Read(Topic.BATTERY_STATE, "eve", reply_to="eve")),
            (7.0, Read(Topic.BATTERY_STATE, "cart", reply_to="cart")),
        )

        assert 0.93 == pytest.approx(log.answer("eve").message.percentage)
        assert Refused("robot", "cart", "cart has no battery") == log.answer("cart")


class TestBeginningAnew:
    def test_a_reset_restores_the_initial_charge(self, make_run):
        run = make_run(world(initial_charge=50))
        run((0.0, wait(60)), until=60.0)
        run.ask("reset_simulation")
        run(until=10.0)

        assert (10.0, 40.0) == (run.simulator.now, charge(run))
        assert [] == [*run.simulator.robots["eve"].disabled_reasons]

    def test_a_reset_of_time_keeps_the_charge(self, make_run):
        run = make_run(world())
        run(until=70.0)
        run.ask("reset_simulation", {"scope": 1})
        log = run(until=15.0)

        assert 15.0 == charge(run)
        assert [10.0] == [at for at, _ in log.happened("battery_low")]

    def test_a_deleted_robot_reports_no_levels(self, make_run):
        run = make_run(world())
        run.ask("delete_entity", {"entity": "eve"})
        log = run(until=200.0)

        assert [] == log.happened("battery_low")


class TestSettings:
    @pytest.mark.parametrize(
        ("settings", "wrong"),
        [
            ({"capacity": 0}, "greater than 0"),
            ({"initial_charge": 9, "capacity": 5}, "initial_charge 9 is more than the capacity 5"),
            ({"low": 0.1, "critical": 0.2}, "critical 0.2 is more than low 0.1"),
            ({"stops_below": 0.1}, "stops_below 0.1 is more than critical 0.05"),
            ({"drain": {"mooving": 1}}, "mooving"),
            ({"drain": {"still": -1}}, "greater than or equal to 0"),
            ({"technology": "steam"}, "technology"),
            ({"cells": 0}, "greater than or equal to 1"),
        ],
    )
    def test_invalid_settings_are_refused(self, settings, wrong):
        with pytest.raises(ValidationError, match=wrong):
            BatterySettings.model_validate(settings)


MISSION = st.lists(
    st.one_of(
        st.tuples(st.just("go"), st.sampled_from([0.0, 7.0, 20.0, 100.0])),
        st.tuples(st.just("wait"), st.integers(0, 40)),
        st.tuples(st.just("dock"), st.just(0)),
        st.tuples(st.just("undock"), st.just(0)),
        st.tuples(st.just("pickup"), st.just(0)),
        st.tuples(st.just("place"), st.just(0)),
        st.tuples(st.just("cell"), st.integers(0, 6)),
        st.tuples(st.just("rescue"), st.just(0)),
    ),
    max_size=12,
)
_GOALS = {
    "go": lambda value: ("navigate_to_pose", {"pose": {"pose": {"position": {"x": value}}}}),
    "wait": lambda value: ("wait", {"time": {"sec": value}}),
    "dock": lambda _value: ("dock_robot", {"dock_id": "charger"}),
    "undock": lambda _value: ("undock_robot", {}),
    "pickup": lambda _value: ("pickup", {"target_name": "parcel"}),
    "place": lambda _value: ("place", {}),
}


def do(run, steps, gaps):
    """Run commands with gaps; return the charge after each."""
    seen = []
    energy = run.simulator.robots["eve"].energy
    for i, ((what, value), gap) in enumerate(zip(steps, gaps, strict=True)):
        if what == "cell":
            (energy.mend if value in energy.battery.failed else energy.fail_cell)(value)
        elif what == "rescue":
            put_at(run, -10.0)
        else:
            action, goal = _GOALS[what](value)
            run.simulator.submit(send(action, f"{i + 1:032x}", **goal))
        run.simulator.advance(run.simulator.now + gap)
        seen.append(energy.battery.charge(run.simulator.now))
        assert 0.0 <= seen[-1] <= energy.battery.usable * (1 + 1e-12)
    return seen


@given(steps=MISSION, data=st.data())
def test_energy_is_conserved(steps, data):
    amount = st.floats(0, 3)
    gaps = data.draw(st.lists(st.floats(0.01, 60), min_size=len(steps), max_size=len(steps)))
    drain = data.draw(st.fixed_dictionaries(dict.fromkeys(("still", "moving", "distance", "load", "handling"), amount)))
    settings = {
        "drain": {**drain, "actions": {"wait": data.draw(amount), "pickup": data.draw(amount)}},
        "initial_charge": data.draw(st.floats(0, 100)),
        "taper_from": data.draw(st.sampled_from([0.0, 0.5, 0.8, 1.0])),
    }
    some = frozenset({Topic.EVENTS, Topic.BATTERY_STATE})
    heard, alone = (simulate(world(**settings), topics=topics) for topics in (some, frozenset()))
    seen = do(heard, steps, gaps)

    assert seen == do(alone, steps, gaps)
    battery, now = heard.simulator.robots["eve"].energy.battery, heard.simulator.now
    battery.settle(now)
    there = settings["initial_charge"] + battery.charged
    assert battery.drained + battery.charge(now) == pytest.approx(there, rel=1e-6, abs=1e-6)


@given(
    st.floats(0, 100),
    st.floats(0.01, 50),
    st.sampled_from([0.0, 0.3, 0.8, 1.0]),
    st.lists(st.floats(0, 100), min_size=1, max_size=5),
)
def test_charging_is_the_same_in_one_go_or_in_several(begin, power, taper, gaps):
    """The curve depends only on the charge."""
    settings = BatterySettings(capacity=100.0, initial_charge=begin, taper_from=taper)
    once, often = Battery(settings), Battery(settings)
    for battery in (once, often):
        battery.charging = power
    now = 0.0
    for gap in gaps:
        now += gap
        often.settle(now)

    assert once.charge(now) == pytest.approx(often.charge(now), rel=1e-9, abs=1e-9)
    assert once.charge(now) <= 100.0
    middle = begin + (100.0 - begin) / 2
    assert middle == pytest.approx(once.charge(once.reaches(middle)), rel=1e-9, abs=1e-9)


def test_a_canceled_goal_stops_draining(make_run):
    run = make_run(world(drain={"default": 0.0, "actions": {"wait": 2.0}}))
    run((0.0, wait(30)), (10.0, CancelGoal("eve", "wait", A)), until=60.0)

    assert 80.0 == charge(run)


def test_a_reset_drops_the_levels_expected_before(make_run):
    eve = {"at": "ch", "components": {"battery": {"capacity": 100, "initial_charge": 50}}}
    run = make_run({"docks": {"ch": {"at": [0, 0], "type": "charger", "power": 10}}, "robots": {"eve": eve}})
    run.simulator.advance(1.0)
    run.ask("reset_simulation", {"scope": 2})
    log = run(until=200.0)

    assert [10.307] == [round(time, 3) for time, _ in log.happened("battery_full")]
    assert [1.0] == [time for time, _ in log.happened("charging_began")]
