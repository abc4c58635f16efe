"""Built-in properties: their violations, and the cases in which they are silent."""

from __future__ import annotations

import pytest

from tests.watching import Feed, ward, watch

GO = "navigate_to_pose"
A, B = "a" * 32, "b" * 32
PLACED = {"order": "pills_1", "item": "pills_1", "from": "lab", "to": "ward_a", "within": 60.0}


def test_a_goal_left_open_by_its_controller_is_a_violation():
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2).goal(2, "wall_e", GO, B, 1, 2, 4).end(9)

    assert feed.violations == [(9.0, "goals_end", "eve", "not ended")]


@pytest.mark.parametrize("ending", ["timeout", "stopped", "crashed", None])
def test_open_goals_are_undecided_if_the_run_was_cut_off(ending):
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2).end(9, ending)

    assert (feed.violations, feed.verdict("goals_end").state) == ([], "undecided")


def test_goals_of_a_killed_controller_are_undecided():
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2)
    feed.monitor.replace_controller()
    feed.goal(2, "wall_e", GO, B, 1, 2, 4).end(9)

    assert (feed.violations, feed.verdict("goals_end").state) == ([], "undecided")


def test_a_goal_of_the_next_controller_has_to_end():
    """The kill of its predecessor is no excuse."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2)
    feed.monitor.replace_controller()
    feed.goal(2, "wall_e", GO, B, 1, 2).end(9)

    assert feed.violations == [(9.0, "goals_end", "wall_e", "not ended")]


def test_a_second_terminal_status_is_a_violation():
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2, 4).goal(3, "eve", GO, A, 6).end(9)

    assert feed.violations == [(3.0, "goals_end", "eve", "ended twice")]


def test_a_status_after_the_terminal_one_is_a_violation():
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2, 4).goal(3, "eve", GO, A, 2).end(9)

    assert feed.violations == [(3.0, "goals_end", "eve", "goes on after its end")]


def test_a_goal_that_the_end_of_the_simulation_aborts_has_not_ended():
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2).goal(5, "eve", GO, A, 6, cause="ended").end(5)

    assert feed.violations == [(5.0, "goals_end", "eve", "not ended")]


def test_a_lasting_deadlock_is_a_violation_after_its_limit():
    """A circle from 2 s on is reported at 62 s."""
    feed = Feed(built_in={"no_deadlock": 60})
    feed.event(2, "deadlock", robots=["eve", "wall_e"], lanes=[]).event(90, "went_on", robot="eve", waited=88.0).end(99)

    assert feed.violations == [(62.0, "no_deadlock", "eve and wall_e", "deadlock")]


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("went_on", {"robot": "eve", "waited": 8.0}),
        ("rerouted", {"robot": "wall_e", "at": [0.0, 0.0]}),
        ("stopped", {"robot": "wall_e", "at": [0.0, 0.0]}),
        ("deleted", {"entity": "eve"}),
        ("waiting", {"robot": "eve", "at": [0.0, 0.0], "for": ["cart"]}),
        ("reset", {"scope": 255}),
    ],
)
def test_a_deadlock_that_dissolves_is_no_violation(kind, fields):
    feed = Feed(built_in={"no_deadlock": 60})
    feed.event(1, "waiting", robot="eve", at=[0.0, 0.0], **{"for": ["wall_e"]})
    feed.event(2, "deadlock", robots=["eve", "wall_e"], lanes=[]).event(32, kind, **fields).end(500)

    assert (feed.violations, feed.verdict("no_deadlock").robustness) == ([], 0.5)


def test_a_robot_with_an_empty_battery_is_stranded_until_it_is_charged():
    feed, power = Feed(built_in={"nobody_stranded": 100}), {"charge": 0.0, "percentage": 0.0}
    feed.event(10, "battery_empty", robot="eve", at=[0.0, 0.0], **power)
    feed.event(20, "battery_empty", robot="wall_e", at=[0.0, 0.0], **power)
    feed.event(60, "charging_began", robot="eve", **power)
    feed.event(70, "charging_ended", robot="eve", **power)
    feed.end(300)

    assert feed.violations == [
        (120.0, "nobody_stranded", "wall_e", "stranded"),
        (170.0, "nobody_stranded", "eve", "stranded"),
    ]


@pytest.mark.parametrize(("scope", "found"), [(1, [11.0]), (4, [11.0]), (2, []), (255, [])])
def test_only_a_reset_of_the_state_ends_stranding(scope, found):
    feed = Feed(built_in={"nobody_stranded": 10})
    feed.event(1, "battery_empty", robot="eve", at=[0.0, 0.0], charge=0.0, percentage=0.0)
    feed.event(2, "reset", scope=scope).end(30)

    assert [at for at, *_ in feed.violations] == found


@pytest.mark.parametrize(("scope", "found"), [(1, []), (2, []), (4, [11.0])])
def test_a_reset_of_spawned_entities_ends_no_deadlock(scope, found):
    feed = Feed(built_in={"no_deadlock": 10}).event(1, "deadlock", robots=["eve", "wall_e"], lanes=[])
    feed.event(2, "reset", scope=scope).end(30)

    assert [at for at, *_ in feed.violations] == found


def test_stranding_is_not_exercised_without_batteries():
    feed = Feed(built_in={"nobody_stranded": 100}, world=ward(robots={"cart": {"at": "lab"}})).end(300)

    assert feed.verdict("nobody_stranded").state == "never_exercised"


def test_late_and_lost_orders_are_violations():
    """A late order is reported when it is due, and a lost one when its item is deleted."""
    feed = Feed(built_in={"orders_in_time": True}).event(5, "order_placed", **PLACED)
    feed.event(65, "order_late", order="pills_1", item="pills_1", to="ward_a")
    feed.event(70, "order_lost", order="pills_1", item="pills_1").end(80)

    assert feed.violations == [(65.0, "orders_in_time", "pills_1", "late"), (70.0, "orders_in_time", "pills_1", "lost")]


def test_the_robustness_of_orders_is_the_share_of_their_time_that_is_left():
    """An order of 60 s that was delivered after 45 s had a quarter left."""
    feed = Feed(built_in={"orders_in_time": True}).event(5, "order_placed", **PLACED)
    feed.event(50, "order_delivered", order="pills_1", item="pills_1", lead_time=45.0).end(80)

    assert feed.verdict("orders_in_time")[1:3] == ("holds", 0.25)


@pytest.mark.parametrize(
    ("ending", "cause", "reason"),
    [
        ("crashed", "KeyError: 'eve' (/home/me/mission.py:12)", "crashed: KeyError at mission.py:12"),
        ("crashed", "GoalRejectedError: not_ready: eve has broken down", "crashed: GoalRejectedError: not_ready"),
        ("crashed", "the controller ended with exit code 3", "crashed: the"),
        ("crashed", "", "crashed"),
        ("hung", "it takes longer than 30 wall seconds", "hung"),
        ("out_of_memory", "", "out_of_memory"),
        ("died", "signal 9", "died"),
    ],
)
def test_the_reason_of_a_crash_is_the_error_and_its_place(ending, cause, reason):
    """Without the message, two crashes of one bug have one reason."""
    feed = Feed(built_in={"controller_lives": True}).end(7, ending, cause)

    assert [(7.0, "controller_lives", "", reason)] == feed.violations


def test_the_end_of_a_controller_is_undecided_in_a_stopped_run():
    feed = Feed(built_in={"controller_lives": True}).end(7, "stopped")

    assert feed.verdict("controller_lives").state == "undecided"


def test_a_controller_dropped_from_lockstep_is_a_violation():
    feed = Feed(built_in={"controller_lives": True}).event(3, "participant_dropped", participant="bt", why="too slow")

    assert [(3.0, "controller_lives", "bt", "dropped")] == feed.end(9, None).violations


def test_a_timeout_of_the_run_is_a_violation():
    ended = {ending: Feed(built_in={"mission_ends": True}).end(600, ending) for ending in ("timeout", "failed")}

    assert ([(600.0, "mission_ends", "", "timeout")], "holds") == (
        ended["timeout"].violations,
        ended["failed"].verdict("mission_ends").state,
    )


RECOVERS = {"recovers": {"within": 30.0}}
ONE = {"fault": "goals_aborted", "robot": "eve", "count": 1}


def fault(feed, name, began, ended=None, **settings):
    """Feed the start and the end of a fault."""
    said = {"fault": "breakdown", "robot": "eve", "name": name, **settings}
    feed.event(began, "fault_began", **said)
    return feed if ended is None else feed.event(ended, "fault_ended", **said)


@pytest.mark.parametrize(
    ("faults", "ending", "expected"),
    [
        ([], "failed", "never_exercised"),
        ([("a", 1, 1, ONE)], "failed", "violated"),
        ([("a", 1, 1, ONE)], "succeeded", "holds"),
        ([("a", 1, 1, ONE)], "crashed", "undecided"),
        ([("a", 1, 70, {**ONE, "count": 3})], "failed", "holds"),
        ([("a", 80, None, {"duration": 30.0})], "failed", "violated"),
        ([("a", 80, None, {"duration": 31.0})], "failed", "holds"),
        ([("a", 80, None, {})], "failed", "holds"),
        ([("a", 1, 1, ONE), ("b", 80, 80, ONE)], "failed", "holds"),
        ([("a", 1, 1, ONE), ("b", 60, 60, ONE)], "failed", "violated"),
        ([("a", 1, None, {}), ("b", 60, 60, ONE)], "failed", "holds"),
    ],
)
def test_giving_up_needlessly_is_a_violation(faults, ending, expected):
    feed = Feed(built_in=RECOVERS)
    for name, began, ended, settings in faults:
        fault(feed, name, began, ended, **settings)
    feed.end(90, ending)

    assert feed.verdict("recovers").state == expected
    assert bool(feed.violations) is (expected == "violated")


def fail(
    feed: Feed, at: float, goal: str, x: float, status: int = 6, cause: str = "blocked", took: float = 0.0
) -> None:
    """Send eve to a point, where its goal ends in a status after a while."""
    began = at - took
    message = {"pose": {"header": {"stamp": {"sec": int(at)}}, "pose": {"position": {"x": x}}}}
    feed.event(began, "goal", robot="eve", action=GO, goal_id=goal * 32, goal=message)
    feed.goal(began, "eve", GO, goal * 32, 1, 2).goal(at, "eve", GO, goal * 32, status, cause=cause)


def test_three_equal_failed_goals_in_a_row_are_a_violation():
    feed = Feed(built_in={"no_vain_goals": 3})
    for at, goal in enumerate("abcd"):
        fail(feed, at, goal, x=1.0)

    assert [(2.0, "no_vain_goals", "eve", "aborted 3 times in a row")] == feed.end(9).violations


def test_the_text_of_futile_goals_says_what_starts_a_new_row():
    feed = Feed(built_in={"no_vain_goals": 3})
    for at, goal in enumerate("abc"):
        fail(feed, at, goal, x=1.0)

    assert feed.verdict("no_vain_goals").text.endswith("; a pause of 20 s starts a new row")


def test_a_futile_goal_is_fatal_at_once():
    """Such a loop may never leave its instant."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for goal in "abc":
        fail(feed, 5.0, goal, x=1.0)

    assert [violation.fatal for violation in feed.monitor.violations] == [True]


def test_different_goals_and_successes_end_a_row_of_futile_goals():
    feed = Feed(built_in={"no_vain_goals": 3})
    for i, goal in enumerate("abcdef"):
        fail(feed, i, goal, x=float(i % 3))
    for i, goal in enumerate("0123"):
        fail(feed, 10 + i, goal, x=9.0, cause="preempted")
    fail(feed, 20, "4", x=0.0, status=4)
    for i, goal in enumerate("56"):
        fail(feed, 21 + i, goal, x=0.0)

    assert feed.end(30).violations == []


def test_a_pause_ends_a_row():
    """A fleet that checks every half minute whether a robot works again is not futile."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for i in range(6):
        feed.event(30 * i, "rejected", robot="eve", action="wait", goal_id="c" * 32, reason="not_ready", error_msg="")

    assert feed.end(300).violations == []


def test_a_restarted_controller_starts_a_new_row():
    feed = Feed(built_in={"no_vain_goals": 3})
    for i in range(4):
        if i == 2:
            feed.monitor.replace_controller()
        fail(feed, i, "abcd"[i], x=1.0)

    assert feed.end(9).violations == []


def test_a_dropped_controller_ends_its_rows():
    feed = Feed(built_in={"no_vain_goals": 3, "controller_lives": False})
    for i in range(4):
        if i == 2:
            feed.event(1.5, "participant_dropped", participant="client")
        fail(feed, i, "abcd"[i], x=1.0)

    assert feed.end(9).violations == []


def test_goals_without_duration_are_futile_despite_successes():
    """The robot drives to where it is, and fails to pick up what it holds, within one instant."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for number in range(30):
        fail(feed, 5.0, f"{number}s", x=0.0, status=4)
        fail(feed, 5.0, f"{number}f", x=1.0)

    assert [(5.0, "no_vain_goals", "eve", "aborted 30 times within one instant")] == feed.end(9).violations


def test_a_goal_that_takes_long_to_fail_is_no_pause():
    """The pause is the time between a failure and the next goal."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for at, goal in zip((30, 60, 90), "abc", strict=True):
        fail(feed, at, goal, x=1.0, took=29)

    assert [(90.0, "no_vain_goals", "eve", "aborted 3 times in a row")] == feed.end(99).violations


def test_rejected_goals_of_a_recording_are_counted_by_error():
    """A recording has no messages of rejected goals."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for i, why in enumerate(["far", "far", "near", "far"]):
        feed.event(i, "rejected", robot="eve", action=GO, goal_id="c" * 32, reason="unreachable", error_msg=why)

    assert [(3.0, "no_vain_goals", "eve", "rejected 3 times in a row")] == feed.end(9).violations


def test_the_hospitals_mission_violates_nothing_while_it_runs():
    monitor = watch("hospital", "bt_controller.examples.hospital:mission")

    assert ([], "33 goals have ended once") == (monitor.violations, monitor.verdicts()[0].text)
