"""Time that stops for a condition on a topic."""

from __future__ import annotations

import math
import operator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmrsim.protocol.goal import Refused
from hmrsim.protocol.topics import Comparison, Topic, Unwatch, Watch, Watching
from hmrsim.timing import battery_levels
from hmrsim.timing.conditions import MAX_WATCHED, Conditions
from tests import simulation
from tests.simulation import send
from tests.steps import Steps

LESS, AT_MOST, AT_LEAST = "<", "<=", ">="
OPERATORS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
NANOSECOND = 1e-9


def world(*faults, drain=None, **battery):
    """Return a world of two robots with batteries that last 100 s, 20 m from a charger."""
    settings = {"capacity": 100, "drain": drain or {"still": 1.0, "moving": 4.0}, **battery}
    return {
        "waypoints": {"west": [0, 0], "east": [20, 0]},
        "lanes": [["west", "east"]],
        "docks": {"charger": {"at": [20, 1], "type": "charger", "power": 10.0}},
        "robots": {name: {"at": "west", "components": {"battery": settings}} for name in ("eve", "wall_e")},
        "faults": list(faults),
    }


def battery(comparison, value, *, name="low", robot="eve", field="percentage"):
    """Return a condition on a robot's battery."""
    return Watch(name, Topic.BATTERY_STATE, robot, comparisons=(Comparison((field,), comparison, value),))


def event(called="seen", /, **fields):
    """Return a condition on an event with these fields."""
    return Watch(called, Topic.EVENTS, comparisons=tuple(Comparison((key,), "==", fields[key]) for key in fields))


def go(x, robot="eve"):
    return simulation.go(x, 0.0, None, robot)


def wait(seconds, robot="eve"):
    return simulation.wait(seconds, None, robot)


def joined(*faults, names=("nurse",), topics=frozenset(), traced=False, **battery):
    """Return a simulation that participants have joined."""
    steps = Steps(world=world(*faults, **battery), topics=topics, traced=traced, awaited=names)
    steps.join(*names)
    return steps


def ends(steps, *commands, until=math.inf, epoch=0, wake=()):
    """Advance once; return the time and the conditions that were met."""
    granted = steps.advance("nurse", epoch, until, *commands, wake=wake)
    return granted.now, granted.met


class TestBatteries:
    """Battery levels, which are formulas of time."""

    @pytest.mark.parametrize(
        ("comparison", "value", "at"),
        [(AT_MOST, 0.75, 25.0), (LESS, 0.75, 25.0 + NANOSECOND), (AT_MOST, 0.0, 100.0), (AT_MOST, 1.0, 0.0)],
    )
    def test_time_stops_when_a_level_is_reached(self, comparison, value, at):
        """Time stops at the first nanosecond at which the condition holds, whatever else is scheduled."""
        assert (at, ("low",)) == ends(joined(), battery(comparison, value))

    def test_a_charge_is_in_ampere_hours(self):
        watch = battery(AT_MOST, 50 / 25.2 / 3600, field="charge")

        assert (50.0, ("low",)) == ends(joined(), watch)

    def test_another_load_brings_it_nearer(self):
        """A moving robot consumes four times as much as one that stands still."""
        steps = joined()
        ends(steps, battery(AT_MOST, 0.75), until=3.0)

        assert (3 + 22 / 4, ("low",)) == ends(steps, go(20), epoch=1)

    def test_a_load_that_ends_puts_it_off(self):
        """20 of 100 are gone after 5 m; the rest lasts as many seconds."""
        assert (5 + 30, ("low",)) == ends(joined(), battery(AT_MOST, 0.5), go(5))

    def test_a_jump_is_seen_when_it_happens(self):
        """A failed cell takes its share of the charge with it."""
        steps = joined({"type": "battery_cell", "robot": "eve", "cell": 0, "at": 10})

        assert (10.0, ("low",)) == ends(steps, battery(AT_MOST, 60 / 25.2 / 3600 * 1.3, field="charge"))

    def test_charging_is_seen_as_well(self):
        """The robot docks after 21 m with an eighth of its charge, and charges 10 a second."""
        steps = joined()
        docked = send("dock_robot", None, "eve", dock_id="charger")
        (end, met) = ends(steps, docked, wake={"result"})
        energy = steps.simulator.robots["eve"].energy
        expected = energy.battery.reaches(70.0)

        assert ((), True) == (met, end < expected < math.inf)
        assert (pytest.approx(expected, abs=2 * NANOSECOND), ("full",)) == ends(
            steps, battery(AT_LEAST, 0.7, name="full"), epoch=1
        )

    def test_a_full_battery_is_full_no_longer_after_the_first_instant(self):
        """The first instant is two nanoseconds long, so that time has to leave it before the next check."""
        assert (2 * NANOSECOND, ("low",)) == ends(joined(), battery("<", 1.0), until=5.0)
        assert (2 * NANOSECOND, ("low",)) == ends(joined(), battery("<", 1.0), go(5), until=5.0)

    def test_other_fields_are_looked_at_with_each_message(self):
        """The field `power_supply_status` is DISCHARGING from the beginning, and never CHARGING."""
        never = battery("==", 1, name="charges", field="power_supply_status")
        now = battery("==", 2, name="drains", field="power_supply_status")

        assert (0.0, ("drains",)) == ends(joined(), never, now, until=5.0)

    @given(
        comparison=st.sampled_from(sorted(OPERATORS)),
        value=st.floats(0.0, 1.0),
        drain=st.floats(1e-3, 5.0),
        moving=st.floats(1e-3, 5.0),
        x=st.floats(0.0, 20.0),
    )
    def test_it_holds_from_this_nanosecond_on(self, comparison, value, drain, moving, x):
        """A simulation without the condition reaches the level at the same time, with the same trace."""
        drains = {"still": drain, "moving": moving}
        with_, without = joined(drain=drains, traced=True), joined(drain=drains, traced=True)
        now, met = ends(with_, battery(comparison, value), go(x), until=50.0)
        without.ask("nurse", 0, 50.0, go(x), wake=())
        without.move()
        with_.ask("nurse", 1, 50.0, wake=())
        with_.move()

        def holds(at):
            twin = joined(drain=drains)
            granted = twin.advance("nurse", 0, at, go(x), wake=())
            assert granted.now >= at
            return OPERATORS[comparison](twin.simulator.robots["eve"].energy.state().percentage, value)

        assert holds(now) is bool(met)
        assert now == 0.0 or not holds(now - 2 * NANOSECOND)
        assert with_.run.lines() == without.run.lines()


class TestEvents:
    """Conditions that events of the world meet."""

    def test_a_fault_begins_and_ends(self):
        steps = joined({"type": "breakdown", "robot": "eve", "name": "stuck", "at": 7, "until": 9})
        began = event("began", kind="fault_began", name="stuck")
        ended = event("ended", kind="fault_ended", robot="eve")
        other = event("other", kind="fault_began", robot="wall_e")

        assert (7.0, ("began",)) == ends(steps, began, ended, other, until=60.0)
        assert (9.0, ("ended",)) == ends(steps, epoch=1, until=60.0)

    def test_an_event_of_a_goal(self):
        succeeded = event(kind="status", status=4, action="wait")

        assert (3.0, ("seen",)) == ends(joined(), succeeded, wait(3), go(20, "wall_e"))

    def test_any_event_will_do(self):
        assert (0.0, ("seen",)) == ends(joined(), event(), wait(3))


class TestSamples:
    """Conditions on topics that are published at a rate."""

    def test_a_place_is_reached_with_the_sample_that_says_so(self):
        """Odometry is sampled ten times a second."""
        far = Comparison(("pose", "pose", "position", "x"), ">", 3.14)
        watch = Watch("far", Topic.ODOM, "eve", comparisons=(far,))

        assert (pytest.approx(3.2, abs=1e-3), ("far",)) == ends(joined(), watch, go(20))

    def test_feedback_of_an_action(self):
        near = Comparison(("feedback", "distance_remaining"), "<", 5.0)
        watch = Watch("near", Topic.FEEDBACK, "eve", "navigate_to_pose", (near,))

        assert (pytest.approx(15.1), ("near",)) == ends(joined(), watch, go(1, "wall_e"), go(20))


class TestWatching:
    """Adding conditions during lockstep, and removing them."""

    def test_a_condition_is_met_once(self):
        steps = joined()

        assert (25.0, ("low",)) == ends(steps, battery(AT_MOST, 0.75), until=60.0)
        assert (60.0, ()) == ends(steps, epoch=1, until=60.0)

    def test_it_stays_until_then(self):
        steps = joined()

        assert (3.0, ()) == ends(steps, battery(AT_MOST, 0.75), until=3.0)
        assert (25.0, ("low",)) == ends(steps, epoch=1)

    def test_it_is_taken_back_by_its_name(self):
        steps = joined()
        first = steps.advance("nurse", 0, 0.0, battery(AT_MOST, 0.75), battery(AT_MOST, 0.5, name="half"), wake=())
        second = steps.advance("nurse", 1, 40.0, Unwatch("low"), Unwatch("low"), battery(AT_MOST, 0.4, name="half"))

        assert (Watching(watching=True),) * 2 == first.accepted
        assert (Watching(watching=False), Watching(watching=False), Watching(watching=True)) == second.accepted
        assert (60.0, ("half",)) == ends(steps, epoch=2)

    def test_several_are_told_at_once(self):
        conditions = [battery(AT_MOST, 0.75, name=name, robot=robot) for name, robot in (("b", "eve"), ("a", "wall_e"))]

        assert (25.0, ("a", "b")) == ends(joined(), *conditions)

    def test_the_first_level_of_several_stops_time(self):
        steps = joined()
        levels = [battery(AT_MOST, level, name=str(level)) for level in (0.5, 0.75, 0.6)]

        assert (25.0, ("0.75",)) == ends(steps, *levels)
        assert (40.0, ("0.6",)) == ends(steps, epoch=1)

    def test_many_levels_of_one_battery_cost_little(self, monkeypatch):
        """Adding a condition computes the time of that condition alone."""
        computed = []
        reached = battery_levels._reached
        monkeypatch.setattr(battery_levels, "_reached", lambda *args: computed.append(args) or reached(*args))
        levels = [battery(AT_MOST, 0.5 - number / 10_000, name=str(number)) for number in range(1_000)]

        assert (50.0, ("0",)) == ends(joined(), *levels)
        assert len(computed) < 3 * len(levels)

    @pytest.mark.parametrize("further", [(), (Comparison(("charge",), "<", 0.0),)], ids=["met", "never met"])
    def test_levels_that_are_reached_one_after_the_other_cost_the_same_each(self, monkeypatch, further):
        """The cost of a check does not depend on how many conditions wait."""
        looks = []
        level, holds = battery_levels._level, Watch.holds
        monkeypatch.setattr(battery_levels, "_level", lambda *args: looks.append(args) or level(*args))
        monkeypatch.setattr(Watch, "holds", lambda *args: looks.append(args) or holds(*args))

        def cost(number):
            values = [0.9 - each / 1_000 for each in range(number)]
            levels = [Comparison(("percentage",), AT_MOST, value) for value in values]
            watches = [
                Watch(str(i), Topic.BATTERY_STATE, "eve", comparisons=(at_most, *further))
                for i, at_most in enumerate(levels)
            ]
            steps, met, epoch = joined(), [], 0
            looks.clear()
            ends(steps, *watches, until=10.0 - NANOSECOND)
            while steps.simulator.now < 90.0:
                epoch += 1
                met += ends(steps, until=90.0, epoch=epoch)[1]
            assert len(met) == (0 if further else number)
            return len(looks)

        assert cost(400) < 5 * cost(100)

    def test_a_message_costs_nothing_where_all_can_be_computed(self, monkeypatch):
        """Other subscribers make no difference."""
        steps = joined(topics=frozenset(Topic))
        levels = [battery(AT_MOST, 0.1, name=str(number)) for number in range(100)]
        ends(steps, *levels, until=1.0)
        looks = []
        monkeypatch.setattr(Watch, "holds", lambda *args: looks.append(args))

        assert (10.0, ()) == ends(steps, epoch=1, until=10.0)
        assert [] == looks

    @pytest.mark.parametrize(
        ("comparison", "value", "met"),
        [
            (AT_LEAST, 10**400, False),
            (AT_MOST, 10**400, True),
            (AT_MOST, -(10**400), False),
            (AT_MOST, math.nan, False),
            (AT_LEAST, "0.5", False),
            (AT_LEAST, True, False),
            (AT_LEAST, None, False),
        ],
        ids=["huge", "most", "least", "nan", "text", "bool", "null"],
    )
    def test_a_level_is_compared_with_any_value(self, comparison, value, met):
        other = Comparison(("charge",), AT_LEAST, 0.0)
        both = Watch(
            "both", Topic.BATTERY_STATE, "eve", comparisons=(Comparison(("percentage",), comparison, value), other)
        )

        assert (0.0 if met else 5.0, ("both",) if met else ()) == ends(joined(), both, until=5.0)

    @settings(max_examples=40)
    @given(
        wanted=st.lists(
            st.lists(
                st.tuples(
                    st.sampled_from(["percentage", "charge", "power_supply_status"]),
                    st.sampled_from(sorted(OPERATORS)),
                    st.floats(0.0, 1.0),
                ),
                min_size=1,
                max_size=3,
            ),
            min_size=2,
            max_size=6,
        ),
        x=st.floats(0.0, 20.0),
    )
    def test_it_makes_no_difference_what_else_is_watched(self, wanted, x):
        """Each condition is met when it is met alone, whether the battery is used, charged or loses a cell."""
        scale = {"percentage": 1.0, "charge": 100 / 25.2 / 3600, "power_supply_status": 4.0}
        watches = [
            Watch(
                str(i),
                Topic.BATTERY_STATE,
                "eve",
                comparisons=tuple(Comparison((field,), order, value * scale[field]) for field, order, value in each),
            )
            for i, each in enumerate(wanted)
        ]

        def met_at(*watches):
            cell = {"type": "battery_cell", "robot": "eve", "cell": 0, "at": 50, "until": 60}
            steps, times = joined(cell), {}
            dock = send("dock_robot", None, "eve", dock_id="charger")
            commands, epoch = (*watches, go(x), wait(4)), 0
            while steps.simulator.now < 80.0:
                until = 30.0 if steps.simulator.now < 30.0 else 80.0
                now, met = ends(steps, *commands, until=until, epoch=epoch)
                times |= dict.fromkeys(met, now)
                commands = (dock,) if now == 30.0 and dock else ()
                dock = None if commands else dock
                epoch += 1
            return times

        together = met_at(*watches)

        assert together == {name: at for watch in watches for name, at in met_at(watch).items()}

    def test_one_that_is_taken_back_is_not_told_although_it_was_met(self):
        watched = Conditions(joined().simulator, lambda: None)
        for name in ("low", "half"):
            watched.watch("nurse", battery(AT_MOST, 1.0, name=name))
        watched.unwatch("nurse", "low")

        assert ("half",) == watched.take_met("nurse")

    def test_who_takes_all_back_is_not_woken(self):
        watched = Conditions(joined().simulator, lambda: None)
        watched.watch("nurse", battery(AT_MOST, 1.0))
        watched.unwatch("nurse", "low")

        assert {} == watched.met

    def test_only_its_own_participant_is_told(self):
        """Time stops for every participant."""
        steps = joined(names=("nurse", "porter"))
        held = steps.ask("porter", 0, wake=())

        assert (25.0, ("low",)) == ends(steps, battery(AT_MOST, 0.75))
        assert (25.0, "event", ()) == (steps.answers(held).now, steps.answers(held).reason, steps.answers(held).met)

    def test_those_of_a_participant_that_leaves_are_forgotten(self):
        steps = joined(names=("nurse", "porter"))
        steps.ask("porter", 0, 1.0, battery(AT_MOST, 0.75), wake=())
        ends(steps, until=1.0)
        steps.leave("porter")

        assert (50.0, ()) == ends(steps, epoch=1, until=50.0)

    def test_what_is_not_there_is_refused(self):
        steps = joined()
        nobody = battery(AT_MOST, 0.5, robot="zoe")
        blind = Watch("seen", Topic.DETECTIONS, "eve")
        granted = steps.advance("nurse", 0, 9.0, nobody, blind)

        assert [Refused, Refused] == [type(each) for each in granted.accepted]
        assert "no such robot" in granted.accepted[0].message
        assert 0.0 == granted.now

    def test_there_is_a_limit(self):
        steps = joined()
        many = [event(str(number), kind="never") for number in range(MAX_WATCHED + 1)]
        granted = steps.advance("nurse", 0, 1.0, *many, wake=())

        assert [MAX_WATCHED] == [
            number for number, answer in enumerate(granted.accepted) if not isinstance(answer, Watching)
        ]

    def test_a_robot_that_can_not_be_reached_says_nothing(self):
        lost = {"type": "messages_lost", "robot": "eve", "at": 10, "until": 40}

        assert (40.0, ("low",)) == ends(joined(lost), battery(AT_MOST, 0.75))

    def test_after_a_reset_it_is_watched_still(self):
        steps = joined()
        ends(steps, battery(AT_MOST, 0.75), until=20.0)
        steps.run.ask("reset_simulation")
        steps.lockstep.restart()

        assert (25.0, ("low",)) == ends(steps)

    def test_a_robot_that_is_gone_is_not_watched(self):
        steps = joined()
        ends(steps, battery(AT_MOST, 0.75), until=20.0)
        steps.run.ask("delete_entity", {"entity": "eve"})

        assert (50.0, ()) == ends(steps, epoch=1, until=50.0)

    @pytest.mark.parametrize("watch", [battery(LESS, 0.8), battery(AT_MOST, 0.8), event(kind="battery_low")])
    def test_who_listens_makes_no_difference(self, watch):
        """Messages for another subscriber are checked only for conditions that can't be computed."""
        times = set()
        for topics in (frozenset(), frozenset(Topic)):
            steps = joined(drain={"default": 3.0}, topics=topics)
            times.add(ends(steps, watch, go(20)))

        assert 1 == len(times)


@pytest.mark.parametrize(
    ("path", "comparison", "value", "holds"),
    [
        (("n",), "==", 3, True),
        (("n",), "==", 3.0, True),
        (("n",), "!=", 4, True),
        (("n",), "==", "3", False),
        (("n",), "<", "4", False),
        (("t",), ">", "a", True),
        (("yes",), "==", True, True),
        (("yes",), "==", 1, False),
        (("yes",), ">=", 0, False),
        (("none",), "==", None, True),
        (("none",), "!=", 0, True),
        (("list", "1"), "==", 6, True),
        (("list", "2"), "!=", 6, False),
        (("list", "x"), "!=", 6, False),
        (("gone",), "!=", 6, False),
        (("n", "x"), "!=", 6, False),
        ((), "!=", 6, True),
    ],
)
def test_a_comparison(path, comparison, value, holds):
    """Numbers are compared with numbers, and texts with texts; a missing field never matches."""
    message = {"n": 3, "t": "b", "yes": True, "none": None, "list": [5, 6]}

    assert holds is Comparison(path, comparison, value).holds(message)
