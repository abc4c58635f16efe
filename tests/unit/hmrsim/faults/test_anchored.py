"""Faults that begin after an event."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import WorldError
from hmrsim.protocol.topics import Topic
from hmrsim.trace.replay import replay
from hmrsim.world_checks.loading import world_of
from tests import simulation
from tests.profiles import examples
from tests.simulation import SMALL_WORLD, A, B, C, send, simulate, wait

DRIVES = {"goal": "executing", "robot": "wall_e", "action": "navigate_to_pose"}
STOPS = {"type": "breakdown", "robot": "wall_e", "name": "stops", "duration": 1.0}


def go(x, goal_id, robot="wall_e"):
    return simulation.go(x, 2.0, goal_id, robot)


def faulty(*faults, **keys):
    settings = {name: keys.pop(name) for name in ("topics", "traced") if name in keys}
    return simulate({**SMALL_WORLD, **keys, "faults": [*faults]}, **settings)


def began(log):
    return [(time, fields["name"]) for time, fields in log.happened("fault_began")]


@pytest.mark.parametrize("after", [0.0, 0.5])
def test_a_fault_begins_after_its_event_and_lasts_for_its_duration(after):
    log = faulty({**STOPS, "when": {**DRIVES, "after": after}})((3.0, go(9, A)))

    assert [(3.0 + after, "stops")] == began(log)
    assert (3.0 + after, "ABORTED") == log.changes(A)[-1]
    assert [4.0 + after] == [time for time, _ in log.happened("fault_ended")]


def test_the_nth_event_counts():
    run = faulty({**STOPS, "when": {**DRIVES, "nth": 2}})
    log = run((0.0, go(5, "1" * 32, "eve")), (0.0, go(3, A)), (5.0, go(5, B)), (9.0, go(9, C)))

    assert [(5.0, "stops")] == began(log)


def test_a_fault_happens_only_once():
    log = faulty({**STOPS, "when": DRIVES})((0.0, go(9, A)), (2.0, go(9, B)))

    assert [(0.0, "stops")] == began(log)


def test_the_event_can_be_one_of_the_world():
    falls = {"type": "claw_drops", "robot": "eve", "at": 4.0}
    run = faulty({**STOPS, "when": {"event": "dropped", "where": {"item": "parcel"}}}, falls)
    log = run((1.0, send("pickup", A, "eve", target_name="parcel")), until=6.0)

    assert [(4.0, "claw_drops_1"), (4.0, "stops")] == began(log)


def test_the_event_can_be_the_end_of_another_fault():
    first = {"type": "slip", "robot": "eve", "factor": 0.5, "at": 2.0, "duration": 3.0}
    log = faulty(first, {**STOPS, "when": {"event": "fault_ended", "robot": "eve"}})(until=8.0)

    assert [(2.0, "slip_1"), (5.0, "stops")] == began(log)


def test_the_event_can_be_a_rejected_goal():
    run = faulty({"type": "breakdown", "robot": "eve"}, {**STOPS, "when": {"goal": "rejected", "robot": "eve"}})
    log = run((2.0, go(5, A, "eve")), until=3.0)

    assert [(0.0, "breakdown_1"), (2.0, "stops")] == began(log)


def test_the_event_can_be_an_abort_with_a_cause():
    when = {"event": "status", "where": {"cause": "preempted"}}
    log = faulty({**STOPS, "when": when})((0.0, go(9, A)), (1.0, go(5, B)), until=3.0)

    assert [(1.0, "stops")] == began(log)


def test_the_event_can_be_one_that_is_not_traced():
    when = {"event": "motion", "where": {"robot": "wall_e", "lane": ["home", "door"]}, "after": 4.0}
    log = faulty({**STOPS, "when": when}, topics=frozenset({Topic.EVENTS}))((0.0, go(9, A)))

    assert [(4.0, "stops")] == began(log)


def test_faults_of_one_event_begin_in_file_order():
    both = [{**STOPS, "name": name, "robot": robot, "when": DRIVES} for name, robot in (("b", "eve"), ("a", "cart"))]

    assert [(1.0, "b"), (1.0, "a")] == began(faulty(*both)((1.0, go(9, A))))


def test_a_fault_of_a_deleted_robot_is_missed():
    run = faulty({**STOPS, "robot": "eve", "when": {**DRIVES, "after": 1.0}})
    run.simulator.advance(1.0)
    run.ask("delete_entity", {"entity": "eve"})
    log = run((2.0, go(9, A)))

    assert [3.0] == [time for time, _ in log.happened("fault_missed")]


def test_a_fault_begins_after_the_robot_of_its_event_is_deleted():
    run = faulty({**STOPS, "when": {"goal": "aborted", "robot": "eve", "after": 1.0}})
    run((0.0, go(1, A, "eve")), until=2.0)
    run.ask("delete_entity", {"entity": "eve"})

    assert [(3.0, "stops")] == began(run(until=5.0))


def test_the_event_of_a_fault_has_its_anchor():
    log = faulty({**STOPS, "when": {**DRIVES, "nth": 1}})((1.0, go(9, A)))
    ((_, fields),) = log.happened("fault_began")

    assert {**DRIVES, "where": {}, "nth": 1, "after": 0.0} == fields["when"]


def test_a_world_without_anchored_faults_has_no_sink_for_them():
    run = faulty({"type": "breakdown", "robot": "eve", "at": 1.0}, topics=frozenset())

    assert not run.simulator.interest.events


def test_the_sink_unsubscribes_after_the_last_fault():
    run = faulty({**STOPS, "when": DRIVES}, topics=frozenset())
    before = run.simulator.interest.events
    run((0.0, go(9, A)), until=1.0)

    assert (True, False) == (before, run.simulator.interest.events)


def inject(run, fault):
    """Inject a fault, with all keys but its type as JSON text; return the answer."""
    settings = {key: value for key, value in fault.items() if key != "type"}
    return run.ask("inject_fault", {"type": fault["type"], "settings": json.dumps(settings)})


def test_an_injected_fault_counts_from_its_injection():
    run = faulty()
    run((0.0, go(3, A)), until=4.0)
    answer = inject(run, {**STOPS, "when": {**DRIVES, "nth": 2}})
    log = run((5.0, go(5, B)), (9.0, go(9, C)))

    assert ("stops", [(9.0, "stops")]) == (answer.name, began(log))


def test_a_waiting_fault_is_listed_as_scheduled():
    (fault,) = faulty({**STOPS, "when": DRIVES}).ask("get_faults").faults

    assert (False, DRIVES["goal"]) == (fault.active, json.loads(fault.settings)["when"]["goal"])


def test_a_waiting_fault_can_be_cleared():
    run = faulty({**STOPS, "when": DRIVES})
    cleared = run.ask("clear_fault", {"name": "stops"}).names

    assert (["stops"], []) == (cleared, began(run((0.0, go(9, A)))))


def test_a_fault_can_be_cleared_between_event_and_beginning():
    run = faulty({**STOPS, "when": {**DRIVES, "after": 2.0}})
    run((0.0, go(9, A)), until=1.0)
    run.ask("clear_fault", {"name": "stops"})

    assert [] == began(run(until=5.0))


def test_a_reset_restarts_the_count():
    run = faulty({**STOPS, "when": {**DRIVES, "nth": 2}})
    run((0.0, go(3, A)), until=4.0)
    run.ask("reset_simulation")
    log = run((1.0, go(3, B)), (6.0, go(5, C)))

    assert [(6.0, "stops")] == began(log)


def test_loading_a_world_drops_waiting_faults():
    run = faulty({**STOPS, "when": DRIVES})
    run.ask("load_world", {"uri": "scenario1"})

    assert ([], False) == (run.ask("get_faults").faults, run.simulator.fault_injector.anchors.waits)


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"when": {**DRIVES, "robot": "wally"}}, "when.robot: no robot 'wally'; did you mean 'wall_e'?"),
        ({"when": {**DRIVES, "action": "navigate"}}, "when.action: no action 'navigate'; did you mean 'navigate_to_"),
        ({"when": {**DRIVES, "robot": "cart", "action": "pickup"}}, "cart does not serve pickup: it has no claw"),
        ({"when": {"event": "pickt"}}, "when.event: there is no kind of event 'pickt'; did you mean 'picked'?"),
        ({"when": {"event": "picked", "where": {"itm": "x"}}}, "when.where.itm: picked has no field 'itm'; "),
        ({"when": {"event": "door_opened", "where": {"door": "gate"}}}, "when.where.door: no door 'gate'; "),
        ({"when": {"event": "fault_ended", "where": {"fault": "slipp"}}}, "no fault type 'slipp'; did you mean 'slip"),
        ({"when": {**DRIVES, "nth": 0}}, "when.nth: must be at least 1, got 0"),
        ({"when": {**DRIVES, "nth": 1.5}}, "when.nth: expected a whole number, got 1.5"),
        ({"when": {**DRIVES, "after": -1.0}}, "when.after: must be at least 0, got -1"),
        ({"when": {**DRIVES, "aftr": 1.0}}, "when.aftr: unknown key 'aftr'; did you mean 'after'?"),
        ({"when": {"nth": 2}}, "when: expected either event: KIND or goal: STATUS"),
        ({"when": DRIVES, "at": 1.0}, "at and when are both given; leave one of them out"),
        ({"when": DRIVES, "mean_time_between": 1.0}, "mean_time_between and when are both given; leave one of them"),
        ({"when": DRIVES, "until": 9.0}, "until is given for a fault that begins when an event comes; give duration"),
    ],
)
def test_invalid_anchors_are_rejected(settings, why):
    fault = {"type": "breakdown", "robot": "wall_e", **settings}
    with pytest.raises(WorldError) as raised:
        world_of({**SMALL_WORLD, "faults": [fault]}, "small")

    assert why in str(raised.value)
    assert why in inject(faulty(), fault).result.error_message


def test_a_replay_has_the_same_faults():
    """Some faults come from the file and some are injected, also several at one instant."""
    faults = [
        {**STOPS, "when": {**DRIVES, "after": 0.5}},
        {"type": "slip", "robot": "eve", "factor": 0.5, "when": {"event": "fault_ended", "robot": "wall_e"}},
        {"type": "claw_misses", "robot": "eve", "when": {"goal": "ended", "nth": 3}, "mean_duration": 5.0},
    ]
    run = faulty(*faults, traced=True)
    run((0.0, go(9, A)), (1.0, go(9, B)), (1.0, go(5, C)), until=4.0)
    inject(run, {**STOPS, "name": "later", "when": {**DRIVES, "nth": 2}})
    run((4.0, wait(2, "4" * 32, "eve")), (5.0, go(1, "5" * 32)), (5.0, go(9, "6" * 32)), (20.0, go(5, "7" * 32)))
    run.ask("reset_simulation")
    run((2.0, go(9, "8" * 32)), until=10.0)
    outcome = replay(run.lines())

    assert (True, None) == (outcome.complete, outcome.difference)
    assert {"stops", "slip_1", "claw_misses_1", "later"} == {name for _, name in began(run.log)}


ROBOTS = st.sampled_from(["wall_e", "eve"])
GOAL_ANCHORS = st.fixed_dictionaries(
    {"goal": st.sampled_from(["accepted", "executing", "succeeded", "aborted", "ended", "rejected"])},
    optional={"robot": ROBOTS, "action": st.sampled_from(["navigate_to_pose", "wait"])},
)
EVENT_ANCHORS = st.fixed_dictionaries(
    {"event": st.sampled_from(["fault_began", "fault_ended", "stopped", "motion", "lane_closed", "status"])}
)
ANCHORS = st.builds(
    lambda pattern, nth, after: {**pattern, "nth": nth, "after": after},
    GOAL_ANCHORS | EVENT_ANCHORS,
    st.integers(1, 3),
    st.sampled_from([0.0, 0.5, 2.0]),
)
FAULTS = st.builds(
    lambda what, robot, anchor, duration: {**what, "robot": robot, "when": anchor, **duration},
    st.sampled_from(
        [
            {"type": "breakdown"},
            {"type": "slip", "factor": 0.5},
            {"type": "messages_lost"},
            {"type": "goals_aborted", "delay": 1.0},
            {"type": "goals_rejected", "count": 1},
            {"type": "result_late", "delay": 2.0},
        ]
    ),
    ROBOTS,
    ANCHORS,
    st.sampled_from([{"duration": 1.5}, {"mean_duration": 2.0}, {"duration": {"uniform": {"low": 1.0, "high": 2.0}}}]),
)
GOALS = st.lists(
    st.tuples(st.sampled_from([0.0, 0.0, 1.0, 2.5]), ROBOTS, st.sampled_from([1.0, 5.0, 9.0])), min_size=1, max_size=6
)


@examples(16)
@given(st.lists(FAULTS, min_size=1, max_size=5), GOALS)
def test_the_same_schedule_gives_the_same_trace(happening, goals):
    """Other subscribers make no difference."""

    def trace(topics):
        run = faulty(*happening, topics=topics, traced=True)
        at = 0.0
        for number, (later, robot, x) in enumerate(goals, 1):
            at += later
            run.simulator.advance(at)
            run.simulator.submit(go(x, f"{number:032x}", robot))
        run.simulator.advance(30.0)
        return run.lines()

    lines = trace(frozenset(Topic))

    assert lines == trace(frozenset({Topic.EVENTS}))
    assert replay(lines).difference is None
