"""Failures are reduced to what they need."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.fault_search.running.evaluator import Evaluator
from hmrsim.fault_search.running.single import Failure, run_case
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.fault_search.searching.reducer import Reducer, needed
from hmrsim.fault_search.searching.shrinking import parts_of, restricted, simpler, tidied
from hmrsim.trials.batches import Serial
from tests.porters import check_of

DRIVE = {"goal": "executing", "robot": "porter", "action": "navigate_to_pose"}
BREAKDOWN = Injection({"type": "breakdown", "robot": "porter", "duration": 25.0, "when": {**DRIVE, "after": 2.0}})
SLIP = Injection({"type": "slip", "robot": "porter", "factor": 0.5, "duration": 5.0, "when": DRIVE})
SLOW = Injection({"change": {"robots.other.base.speed": 0.1}})
VAIN = Failure("no_vain_goals", "rejected 5 times in a row")


def reduced(case, failure=VAIN, function="vain"):
    """Return a case of a porter as it is reduced."""
    check = check_of(function)
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        return Reducer(evaluator, check.definition, nominal).reduce(case, failure)


def test_injections_that_a_failure_does_not_need_are_removed():
    """Of three, the breakdown is enough; without it the run passes."""
    result = reduced(Case((SLIP, BREAKDOWN, SLOW)))

    assert [injection.kind for injection in result.case.schedule] == ["breakdown"]
    assert [outcome.failure for outcome in result.without] == [None]


def test_the_world_is_reduced_to_what_the_mission_needs():
    """Off the lanes robots drive straight, so that one waypoint is left; without the schedule the mission is done."""
    result = reduced(Case((BREAKDOWN,)))
    world = result.case.definition

    assert [*world["robots"]] == ["porter"]
    assert [*world["items"]] == ["box"]
    assert [*world["waypoints"]] == ["home"]
    assert result.without[0].ending == "succeeded"


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"robots.porter.base.speed": 1e4}, [1.2, 1.5, 2.0, 5.0, 10.0, 100.0]),
        ({"robots.porter.base.speed": 0.6}, [0.95, 0.9, 0.8, 0.7]),
        ({"robots.porter.base.speed": 1.2}, []),
        ({"demand.0.arrives": 0.01}, []),
    ],
)
def test_a_change_becomes_as_small_as_it_may_be(change, expected):
    """The least one first, down from 1 m/s or up."""
    world = check_of("careful").world

    values = [
        value
        for injection in simpler(Injection({"change": change}), world)
        for value in injection.spec["change"].values()
    ]
    assert values == expected


def test_a_smaller_battery_keeps_its_share():
    """Its charge is less by as much."""
    battery = {"capacity": 200.0, "initial_charge": 100.0}
    check = check_of("careful", overlay={"robots.porter.components.battery": battery})
    path = "robots.porter.components.battery"
    half = Injection({"change": {f"{path}.capacity": 100.0, f"{path}.initial_charge": 50.0}})

    first = next(simpler(half, check.world))
    assert [*first.spec["change"].values()] == [190.0, 95.0]


def test_what_properties_speak_of_stays():
    """Else they could not be checked when the failure is repeated."""
    spec = {
        "properties": {
            "far": {"never": {"robot": "porter", "at": "nook"}},
            "kept": {"never": {"item": "crate", "at": "home"}},
        }
    }
    check = check_of("vain", properties=spec)
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        result = Reducer(evaluator, check.definition, nominal, names=check.named).reduce(Case((BREAKDOWN,)), VAIN)

    assert [*result.case.definition["items"]] == ["box", "crate"]
    assert "nook" in result.case.definition["waypoints"]
    assert [*result.case.definition["robots"]] == ["porter"]


def test_a_failure_without_faults_keeps_its_world():
    """Where nothing is there, a controller fails in any case, also one that is fixed."""
    check = check_of("broken")
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        result = Reducer(evaluator, check.definition, nominal).reduce(Case(), nominal.failures[0])

    assert result.case.definition is None


def test_what_is_missing_does_not_stand_for_what_is_out_of_order():
    """Without its dock the robot could not dock either, which says nothing about a dock that is out of order."""
    world = {"docks": {"berth": {"at": [0.0, 0.5]}}, "robots.porter.at": "store"}
    fails = Injection({"type": "goals_aborted", "robot": "porter", "action": "pickup", "count": 1})
    shut = Injection({"type": "dock_out_of_order", "dock": "berth"})
    check = check_of("tired", overlay=world)
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        failure = Failure("no_vain_goals", "aborted 5 times in a row")
        result = Reducer(evaluator, check.definition, nominal).reduce(Case((fails, shut)), failure)

    assert [injection.kind for injection in result.case.schedule] == ["goals_aborted", "dock_out_of_order"]
    assert [*result.case.definition["docks"]] == ["berth"]


def test_a_robot_that_is_missing_does_not_stand_for_one_that_is_broken():
    """Also where the run without faults violates another property: goals were not rejected for that reason before."""
    never = {"properties": {"no_box": {"never": {"event": "picked"}}}}
    check = check_of("vain", properties=never)
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        assert ["no_box"] == [failure.property for failure in nominal.failures]
        result = Reducer(evaluator, check.definition, nominal).reduce(Case((BREAKDOWN,)), VAIN)

    assert [injection.kind for injection in result.case.schedule] == ["breakdown"]
    assert [*result.case.definition["robots"]] == ["porter"]


def test_values_become_simple():
    """A second is enough, from the first moment on."""
    (injection,) = reduced(Case((BREAKDOWN,))).case.schedule

    assert injection.spec["duration"] == 1.0
    assert injection.anchor == DRIVE


def test_a_failure_without_faults_has_no_schedule():
    """And of the world what its reason needs: nothing, as here the controller crashes at once."""
    (failure,) = run_case(check_of("broken"), Case()).failures
    result = reduced(Case((SLIP,)), failure, "broken")

    assert result.case.schedule == ()


def test_simpler_values_come_one_at_a_time():
    """First the anchor, then the count, then durations."""
    injection = Injection(
        {"type": "goals_rejected", "robot": "eve", "count": 3, "when": {**DRIVE, "nth": 2, "after": 1.25}}
    )
    whens = [each.anchor for each in simpler(injection)]

    assert whens[0] == {**DRIVE, "nth": 2}
    assert {**DRIVE, "nth": 2, "after": 1.0} in whens
    assert {**DRIVE, "after": 1.25} in whens
    assert [each.spec.get("count") for each in simpler(injection)][-1] == 1


def test_each_earlier_event_of_its_kind_is_tried():
    """The first of all comes first; one of the others may need no second injection."""
    injection = Injection({"type": "slip", "robot": "eve", "when": {**DRIVE, "nth": 4}})

    assert [1, 2, 3] == [each.anchor.get("nth", 1) for each in simpler(injection)]


def fails_with(wanted):
    """Return what tells of candidates that have all of some parts, and keeps how often it was asked."""

    def fails(candidates):
        return [wanted <= {*candidate} for candidate in candidates]

    return fails


@given(st.integers(1, 40).flatmap(lambda n: st.tuples(st.just(n), st.frozensets(st.integers(0, n - 1), max_size=6))))
def test_what_is_needed_is_found_whatever_it_is(case):
    """A failure that needs some parts is reduced to these, in their order."""
    count, wanted = case

    assert sorted(wanted) == needed(range(count), fails_with(wanted))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=12))
def test_no_part_of_what_is_found_can_be_left_out(parts):
    """Also of a failure that is there with many different parts: here, that the sum is at least half of all."""
    half = sum(parts) / 2

    def fails(candidates):
        return [sum(candidate) >= half for candidate in candidates]

    found = needed(parts, fails)

    assert sum(found) >= half
    assert all(sum(found) - each < half for each in found)


def test_what_fails_by_itself_needs_nothing():
    """A failure without any part is reduced to none with one test."""
    asked = []

    def fails(candidates):
        asked.append(len(candidates))
        return [True] * len(candidates)

    assert needed("abc", fails) == []
    assert asked == [1]


def test_candidates_of_a_round_are_tested_together():
    """So that they can be run at once; of several that fail the first one is taken."""
    rounds = []

    def fails(candidates):
        rounds.append(len(candidates))
        return ["d" in candidate for candidate in candidates]

    assert needed("abcdefgh", fails) == ["d"]
    assert max(rounds) > 1


WORLD = {
    "waypoints": {"a": [0, 0], "b": [1, 0], "c": [2, 0]},
    "lanes": [["a", "b"], {"from": "b", "to": "c", "one_way": True}],
    "places": {"shelf": {"at": [2, 1]}},
    "robot_types": {"nurse": {}, "drone": {}},
    "robots": {"wall_e": {"at": "a", "type": "nurse"}, "eve": {"at": "b", "type": "drone"}},
}


def test_parts_are_entries_by_name_or_by_index():
    """Of mappings the names, of lists the indices."""
    parts = parts_of(WORLD, ("robots", "lanes", "doors"))

    assert parts == [("robots", "wall_e"), ("robots", "eve"), ("lanes", 0), ("lanes", 1)]


def test_a_world_keeps_what_is_kept():
    """A key without entries is left out; other keys stay as they are."""
    world = restricted(WORLD, ("robots", "places"), [("robots", "eve")])

    assert world["robots"] == {"eve": {"at": "b", "type": "drone"}}
    assert "places" not in world
    assert world["lanes"] == WORLD["lanes"]


def test_a_tidy_world_has_no_waypoint_that_nothing_leads_to():
    """One at which a robot stands stays; a robot type goes with its last robot."""
    world = tidied(restricted(WORLD, ("robots", "lanes"), [("robots", "wall_e"), ("lanes", 1)]))

    assert [*world["waypoints"]] == ["a", "b", "c"]
    assert [*world["robot_types"]] == ["nurse"]
    assert [*tidied(restricted(WORLD, ("robots", "lanes"), [("robots", "eve")]))["waypoints"]] == ["b"]
