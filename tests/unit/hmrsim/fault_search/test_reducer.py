"""The reduction of failures to minimal cases."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.reducer import Reducer, needed, parts_of, restricted, simpler, tidied
from hmrsim.fault_search.run import Failure, run_case
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.trials.batches import Serial
from tests.porters import check_of

DRIVE = {"goal": "executing", "robot": "porter", "action": "navigate_to_pose"}
BREAKDOWN = Injection({"type": "breakdown", "robot": "porter", "duration": 25.0, "when": {**DRIVE, "after": 2.0}})
SLIP = Injection({"type": "slip", "robot": "porter", "factor": 0.5, "duration": 5.0, "when": DRIVE})
SLOW = Injection({"change": {"robots.other.base.speed": 0.1}})
VAIN = Failure("no_vain_goals", "rejected 5 times in a row")


def reduced(case, failure=VAIN, function="vain"):
    """Return the reduction of a case of a porter."""
    check = check_of(function)
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        return Reducer(evaluator, check.definition, nominal).reduce(case, failure)


def test_removes_unneeded_injections():
    result = reduced(Case((SLIP, BREAKDOWN, SLOW)))

    assert [injection.kind for injection in result.case.schedule] == ["breakdown"]
    assert [outcome.failure for outcome in result.without] == [None]


def test_reduces_the_world_to_the_needs_of_the_mission():
    """Robots drive straight off the lanes, so one waypoint is enough."""
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
def test_changes_become_as_small_as_possible(change, expected):
    world = check_of("careful").world

    values = [
        value
        for injection in simpler(Injection({"change": change}), world)
        for value in injection.spec["change"].values()
    ]
    assert values == expected


def test_a_smaller_battery_keeps_its_share():
    battery = {"capacity": 200.0, "initial_charge": 100.0}
    check = check_of("careful", overlay={"robots.porter.components.battery": battery})
    path = "robots.porter.components.battery"
    half = Injection({"change": {f"{path}.capacity": 100.0, f"{path}.initial_charge": 50.0}})

    first = next(simpler(half, check.world))
    assert [*first.spec["change"].values()] == [190.0, 95.0]


def test_objects_of_properties_stay():
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
    """Without its objects, even a fixed controller would fail."""
    check = check_of("broken")
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        result = Reducer(evaluator, check.definition, nominal).reduce(Case(), nominal.failures[0])

    assert result.case.definition is None


def test_missing_dock_does_not_replace_a_broken_dock():
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


def test_missing_robot_does_not_replace_a_broken_robot():
    """Goals may not be rejected for a reason that the whole world does not have."""
    never = {"properties": {"no_box": {"never": {"event": "picked"}}}}
    check = check_of("vain", properties=never)
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        assert ["no_box"] == [failure.property for failure in nominal.failures]
        result = Reducer(evaluator, check.definition, nominal).reduce(Case((BREAKDOWN,)), VAIN)

    assert [injection.kind for injection in result.case.schedule] == ["breakdown"]
    assert [*result.case.definition["robots"]] == ["porter"]


def test_values_become_simple():
    (injection,) = reduced(Case((BREAKDOWN,))).case.schedule

    assert injection.spec["duration"] == 1.0
    assert injection.anchor == DRIVE


def test_a_failure_without_faults_has_no_schedule():
    """The world becomes empty as well, since the controller crashes at once."""
    (failure,) = run_case(check_of("broken"), Case()).failures
    result = reduced(Case((SLIP,)), failure, "broken")

    assert result.case.schedule == ()


def test_simpler_values_come_one_at_a_time():
    """First the anchor changes, then the count, then durations."""
    injection = Injection(
        {"type": "goals_rejected", "robot": "eve", "count": 3, "when": {**DRIVE, "nth": 2, "after": 1.25}}
    )
    whens = [each.anchor for each in simpler(injection)]

    assert whens[0] == {**DRIVE, "nth": 2}
    assert {**DRIVE, "nth": 2, "after": 1.0} in whens
    assert {**DRIVE, "after": 1.25} in whens
    assert [each.spec.get("count") for each in simpler(injection)][-1] == 1


def test_tries_each_earlier_event_of_the_same_kind():
    injection = Injection({"type": "slip", "robot": "eve", "when": {**DRIVE, "nth": 4}})

    assert [1, 2, 3] == [each.anchor.get("nth", 1) for each in simpler(injection)]


def fails_with(wanted):
    """Return a test that fails candidates with all of some parts, and a list of its calls."""

    def fails(candidates):
        return [wanted <= {*candidate} for candidate in candidates]

    return fails


@given(st.integers(1, 40).flatmap(lambda n: st.tuples(st.just(n), st.frozensets(st.integers(0, n - 1), max_size=6))))
def test_needed_finds_the_parts_that_fail(case):
    count, wanted = case

    assert sorted(wanted) == needed(range(count), fails_with(wanted))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=12))
def test_needed_parts_are_1_minimal(parts):
    """Here many selections fail: those whose sum is at least half of the total."""
    half = sum(parts) / 2

    def fails(candidates):
        return [sum(candidate) >= half for candidate in candidates]

    found = needed(parts, fails)

    assert sum(found) >= half
    assert all(sum(found) - each < half for each in found)


def test_failure_without_parts_needs_one_test():
    asked = []

    def fails(candidates):
        asked.append(len(candidates))
        return [True] * len(candidates)

    assert needed("abc", fails) == []
    assert asked == [1]


def test_candidates_of_a_round_are_tested_together():
    """They can run at the same time; of several that fail, the first one counts."""
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
    parts = parts_of(WORLD, ("robots", "lanes", "doors"))

    assert parts == [("robots", "wall_e"), ("robots", "eve"), ("lanes", 0), ("lanes", 1)]


def test_restricted_world_drops_empty_keys():
    world = restricted(WORLD, ("robots", "places"), [("robots", "eve")])

    assert world["robots"] == {"eve": {"at": "b", "type": "drone"}}
    assert "places" not in world
    assert world["lanes"] == WORLD["lanes"]


def test_tidied_world_has_no_isolated_waypoints():
    world = tidied(restricted(WORLD, ("robots", "lanes"), [("robots", "wall_e"), ("lanes", 1)]))

    assert [*world["waypoints"]] == ["a", "b", "c"]
    assert [*world["robot_types"]] == ["nurse"]
    assert [*tidied(restricted(WORLD, ("robots", "lanes"), [("robots", "eve")]))["waypoints"]] == ["b"]
