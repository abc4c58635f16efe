"""Batteries: what drains them, what they tell, and what happens when they are empty."""

from __future__ import annotations

import math
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hmrsim.actions import registry
from hmrsim.components.battery import Battery, BatterySettings
from hmrsim.protocol.answers import Refused
from hmrsim.protocol.commands import CancelGoal, Read, SendGoal
from hmrsim.protocol.outputs import Sampled
from hmrsim.protocol.topics import Topic
from tests.simulation import simulate

A, B, C = (letter * 32 for letter in "abc")
STATUS_CHARGING, STATUS_DISCHARGING, STATUS_NOT_CHARGING, STATUS_FULL = 1, 2, 3, 4


@pytest.fixture
def make_run():
    """Return what makes simulations that listen to no more than these tests look at: some last for long."""
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


def send(action, goal_id=A, **goal):
    """Return the command that sends a goal to the robot."""
    kind = registry()[action].goal
    return SendGoal("eve", action, kind.model_validate(goal, strict=False), goal_id, goal_id)


def go(x, goal_id=A):
    """Return the command to drive to a point on the x axis."""
    return send("navigate_to_pose", goal_id, pose={"pose": {"position": {"x": x}}})


def wait(seconds, goal_id=A):
    """Return the command to wait."""
    return send("wait", goal_id, time={"sec": seconds})


def put_at(run, x):
    """Put the robot somewhere else."""
    run.ask("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": x}}}})


def charge(run):
    """Return the units of energy in the robot's battery now."""
    return run.simulator.robots["eve"].energy.battery.charge(run.simulator.now)


def state(run):
    """Return the robot's battery state as a message."""
    return run.simulator.robots["eve"].energy.state()


class TestDrain:
    """What takes energy."""

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
    def test_time_distance_and_actions_drain_it(self, make_run, drain, left):
        """20 s and 20 m of driving, then 10 s of waiting."""
        run = make_run(world(drain=drain))
        run((0.0, go(20.0)), (20.0, wait(10, B)), until=30.0)

        assert left == pytest.approx(charge(run))

    def test_what_it_carries_drains_it_and_so_does_picking_up(self, make_run):
        """20 s with nothing, 5 units to pick 4 kg up, 20 s with them, 5 units to put them down, 10 s without."""
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

    def test_a_slow_lane_takes_the_same_distance(self, make_run):
        """What is by distance is so at any speed, with acceleration, too."""
        drain = {"default": 0.0, "distance": 1.0}
        run = make_run(world({"speed": 0.4, "acceleration": 0.1}, drain=drain))
        run((0.0, go(20.0)))

        assert 80.0 == pytest.approx(charge(run))

    def test_it_is_a_formula_of_time(self, make_run):
        """Nothing is scheduled for it while nothing changes, and time does not go on for its sake."""
        run = make_run(world())
        run((0.0, wait(10)))

        assert 10.0 == run.simulator.now
        assert math.inf == run.simulator.next_event

    def test_a_second_robot_changes_nothing(self, make_run):
        """What one needs is its own matter."""
        one, two = world(initial_charge=30), world(initial_charge=30)
        two["robots"]["wall_e"] = {"at": "far", "components": {"battery": {}}}
        logs = [make_run(each)((0.0, go(100.0)), until=99.0) for each in (one, two)]

        assert logs[0].happened("battery_empty") == logs[1].happened("battery_empty")


class TestLevels:
    """What is told on the way down."""

    def test_low_critical_and_empty_are_told_when_they_are_reached(self, make_run):
        """At 20 and at 5 of 100 units, one a second."""
        log = make_run(world(initial_charge=50))((0.0, wait(100)), until=100.0)
        told = [
            (at, kind, fields["charge"], fields["percentage"])
            for kind in ("low", "critical", "empty")
            for at, fields in log.happened(f"battery_{kind}")
        ]

        assert [(30.0, "low", 20.0, 0.2), (45.0, "critical", 5.0, 0.05), (50.0, "empty", 0.0, 0.0)] == told

    def test_levels_can_be_set(self, make_run):
        """Both at once, if they are the same."""
        run = make_run(world(low=0.5, critical=0.5))
        log = run((0.0, wait(60)), until=60.0)

        assert [50.0] == [at for at, _ in log.happened("battery_low")]
        assert [50.0] == [at for at, _ in log.happened("battery_critical")]

    def test_what_is_low_from_the_beginning_is_not_told(self, make_run):
        """It shows as a tag."""
        run = make_run(world(initial_charge=20))
        log = run(until=10.0)

        assert [] == log.happened("battery_low")
        assert "battery_low" in run.ask("get_entity_info", {"entity": "eve"}).info.tags

    def test_a_level_that_handling_jumps_over_is_told_at_that_instant(self, make_run):
        """Three levels at once; the goal that it was done for has succeeded."""
        run = make_run(world(initial_charge=60, drain={"default": 1.0, "handling": 50.0}))
        log = run((0.0, go(20.0)), (20.0, send("pickup", B, target_name="parcel")))

        assert (23.0, "SUCCEEDED") == log.changes(B)[-1]
        assert [[23.0]] * 3 == [
            [at for at, _ in log.happened(f"battery_{level}")] for level in ("low", "critical", "empty")
        ]
        assert 0.0 == charge(run)


class TestEmpty:
    """A robot without energy."""

    def test_it_stops_where_it_is_and_says_so(self, make_run):
        """The goal ends ABORTED with the place; so does what happened."""
        run = make_run(world(initial_charge=12.5))
        log = run((0.0, go(20.0)))

        assert (12.5, "ABORTED") == log.changes(A)[-1]
        assert (9000, "battery empty at (12.5, 0)") == (log.result(A).error_code, log.result(A).error_msg)
        assert [(12.5, [12.5, 0.0])] == [(at, fields["at"]) for at, fields in log.happened("battery_empty")]
        assert (12.5, 0.0) == run.simulator.robots["eve"].pose().point
        assert "battery_empty" in run.ask("get_entity_info", {"entity": "eve"}).info.tags

    def test_later_goals_are_rejected(self, make_run):
        """With a reason for programs, and one for people."""
        log = make_run(world(initial_charge=5))((0.0, wait(10)), (8.0, go(20.0, B)))
        answer = log.answer(B)

        assert (False, "not_ready", "battery empty at (0, 0)") == (answer.accepted, answer.reason, answer.error_msg)

    def test_one_that_begins_without_energy_can_do_nothing(self, make_run):
        """From the first instant."""
        log = make_run(world(initial_charge=0))((0.0, go(20.0)))

        assert "not_ready" == log.answer(A).reason

    def test_put_onto_a_charger_it_is_of_use_again_when_it_is_not_critical(self, make_run):
        """Two units a second: 5 of 100 after 2.5 s."""
        run = make_run(world(initial_charge=5))
        run((0.0, wait(10)), until=10.0)
        put_at(run, -10.0)
        run((12.0, go(20.0, B)), (12.5, go(20.0, C)), until=13.0)

        assert "not_ready" == run.log.answer(B).reason
        assert run.log.answer(C).accepted
        assert [(12.5, 0.05)] == [(at, told["percentage"]) for at, told in run.log.happened("battery_revived")]

    def test_one_that_is_never_critical_needs_a_hundredth(self, make_run):
        """So that it does not stop again at once."""
        run = make_run(world(initial_charge=5, critical=0.0))
        run((0.0, wait(10)), until=10.0)
        put_at(run, -10.0)
        run(until=12.0)

        assert [10.5] == [at for at, _ in run.log.happened("battery_revived")]

    def test_it_may_stop_before_nothing_is_left(self, make_run):
        """The rest stays in it; it is of use again a hundredth above that, if it is never critical."""
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
        """Until it is away."""
        run = make_run(world(initial_charge=12.5))
        run((0.0, go(20.0)), until=13.0)
        put_at(run, -10.0)

        assert [12.5, 12.5] == [at for at, _ in run.log.happened("lane_closed")]
        assert [13.0, 13.0] == [at for at, _ in run.log.happened("lane_opened")]


class TestCharging:
    """At a dock that charges."""

    def test_it_charges_constantly_and_then_tapers(self, make_run):
        """Two units a second from 0.8 of 100 on fall to a twentieth at 100, by an exponential."""
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

    def test_without_a_taper_it_is_constant_to_the_end(self, make_run):
        """If the battery says so."""
        run = make_run(world(initial_charge=40, taper_from=1.0))
        put_at(run, -10.0)
        log = run(until=60.0)

        assert [30.0] == [at for at, _ in log.happened("battery_full")]

    def test_a_charger_of_no_power_fills_it_in_a_quarter_of_an_hour(self, make_run):
        """But for the taper."""
        run = make_run(world(docks={"charger": {"at": [-10, 0], "type": "charger"}}, initial_charge=0, taper_from=1.0))
        put_at(run, -10.0)
        log = run(until=1000.0)

        assert [900.0] == pytest.approx([at for at, _ in log.happened("battery_full")])

    def test_another_dock_does_not_charge(self, make_run):
        """Unless it has a power."""
        run = make_run(world(docks={"charger": {"at": [-10, 0]}}))
        put_at(run, -10.0)
        run(until=10.0)

        assert 90.0 == charge(run)

    def test_leaving_ends_it(self, make_run):
        """Told with what is in it, which goes down again."""
        run = make_run(world(initial_charge=40))
        put_at(run, -10.0)
        log = run((10.0, go(0.0)), until=20.0)

        assert [(10.0, 60.0)] == [(at, told["charge"]) for at, told in log.happened("charging_ended")]
        assert 50.0 == charge(run)

    def test_what_is_low_is_told_again_the_next_time(self, make_run):
        """Charged above it and come down once more."""
        run = make_run(world(initial_charge=25))
        run(until=10.0)
        put_at(run, -10.0)
        run((20.0, go(0.0)), until=60.0)

        assert [5.0, 35.0] == [at for at, _ in run.log.happened("battery_low")]


class TestMessage:
    """sensor_msgs/BatteryState."""

    def test_every_field_means_something(self, make_run):
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
        """By a tenth of the nominal one to either side."""
        run = make_run(world(initial_charge=initial_charge, nominal_voltage=10.0))

        assert volts == pytest.approx(state(run).voltage)

    def test_the_status_follows(self, make_run):
        """Discharging, charging, full; and not charging when it is empty."""
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

    def test_the_current_is_what_the_charge_changes_by(self, make_run):
        """Ampere hours and amperes agree while it tapers, too."""
        run = make_run(world(initial_charge=85))
        put_at(run, -10.0)
        before = state(run)
        run(until=0.001)

        assert before.current == pytest.approx((state(run).charge - before.charge) * 3600 / 0.001, rel=1e-3)

    def test_a_cell_that_fails_shows(self, make_run):
        """A quarter of what it holds, and of what is in it, is gone until it is mended."""
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

    def test_without_any_cell_it_is_dead_and_empty(self, make_run):
        """Whatever was in it."""
        run = make_run(world(cells=1))
        run.simulator.robots["eve"].energy.fail_cell(0)
        log = run((1.0, go(20.0)))

        assert (3, 0.0) == (state(run).power_supply_health, state(run).percentage)
        assert "not_ready" == log.answer(A).reason

    def test_it_is_sampled_and_told_at_once_when_something_happens(self, make_run):
        """Each second, and at 2.5 s, when it is low."""
        run = make_run(world(initial_charge=22.5), topics=frozenset({Topic.BATTERY_STATE}))
        log = run(until=4.0)

        assert [1.0, 2.0, 2.5, 3.0, 4.0] == [at for at, event in log.events if isinstance(event, Sampled)]

    def test_the_rate_can_be_set(self, make_run):
        """In simulated seconds."""
        run = make_run(world(), battery_rate=0.5, topics=frozenset({Topic.BATTERY_STATE}))
        log = run(until=6.0)

        assert [2.0, 4.0, 6.0] == [at for at, event in log.events if isinstance(event, Sampled)]

    def test_the_latest_can_be_read(self, make_run):
        """Unless there is no battery."""
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
    """Reset, and another time."""

    def test_a_reset_fills_it_as_in_the_beginning(self, make_run):
        """And it is drained from there."""
        run = make_run(world(initial_charge=50))
        run((0.0, wait(60)), until=60.0)
        run.ask("reset_simulation")
        run(until=10.0)

        assert (10.0, 40.0) == (run.simulator.now, charge(run))
        assert [] == [*run.simulator.robots["eve"].disabled_reasons]

    def test_time_alone_begins_anew(self, make_run):
        """What is in it stays, and low is told when it is."""
        run = make_run(world())
        run(until=70.0)
        run.ask("reset_simulation", {"scope": 1})
        log = run(until=15.0)

        assert 15.0 == charge(run)
        assert [10.0] == [at for at, _ in log.happened("battery_low")]

    def test_a_deleted_robot_tells_nothing_any_more(self, make_run):
        """Its battery is gone with it."""
        run = make_run(world())
        run.ask("delete_entity", {"entity": "eve"})
        log = run(until=200.0)

        assert [] == log.happened("battery_low")


class TestSettings:
    """What a world file may say."""

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
    def test_what_makes_no_sense_is_refused(self, settings, wrong):
        """With what is wrong."""
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
    """Do one thing after the other, each after a gap; return what was in the battery after each."""
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
    """The initial energy and what is charged equal what is used and what is left; subscribers change nothing."""
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
    """The curve depends on what is in it alone, and reaches a level when it says that it does."""
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


def test_a_canceled_goal_drains_no_more(make_run):
    """What an action takes, it takes as long as its goal runs."""
    run = make_run(world(drain={"default": 0.0, "actions": {"wait": 2.0}}))
    run((0.0, wait(30)), (10.0, CancelGoal("eve", "wait", A)), until=60.0)

    assert 80.0 == charge(run)


def test_a_reset_of_state_leaves_one_account_of_a_battery(make_run):
    """What the one before expected does not happen any more."""
    eve = {"at": "ch", "components": {"battery": {"capacity": 100, "initial_charge": 50}}}
    run = make_run({"docks": {"ch": {"at": [0, 0], "type": "charger", "power": 10}}, "robots": {"eve": eve}})
    run.simulator.advance(1.0)
    run.ask("reset_simulation", {"scope": 2})
    log = run(until=200.0)

    assert [10.307] == [round(time, 3) for time, _ in log.happened("battery_full")]
    assert [1.0] == [time for time, _ in log.happened("charging_began")]
