"""The properties that are built in: when each is violated, and when it says nothing."""

from __future__ import annotations

import pytest

from tests.watching import Feed, ward, watch

GO = "navigate_to_pose"
A, B = "a" * 32, "b" * 32
PLACED = {"order": "pills_1", "item": "pills_1", "from": "lab", "to": "ward_a", "within": 60.0}


def test_a_goal_that_never_ends_is_told_at_the_end():
    """A goal that is under way when its controller has ended by itself is a violation."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2).goal(2, "wall_e", GO, B, 1, 2, 4).end(9)

    assert feed.violations == [(9.0, "goals_end", "eve", "not ended")]


@pytest.mark.parametrize("ending", ["timeout", "stopped", "crashed", None])
def test_goals_under_way_are_undecided_where_the_controller_was_cut_off(ending):
    """A controller can't wait for its goals if something else ends the run."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2).end(9, ending)

    assert (feed.violations, feed.verdict("goals_end").state) == ([], "undecided")


def test_goals_that_were_left_behind_are_undecided():
    """A controller that was killed on purpose can't end its goals; what is accepted after that is of another one."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2)
    feed.monitor.replace_controller()
    feed.goal(2, "wall_e", GO, B, 1, 2, 4).end(9)

    assert (feed.violations, feed.verdict("goals_end").state) == ([], "undecided")


def test_a_goal_of_the_next_controller_has_to_end():
    """That its predecessor was killed is no excuse."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2)
    feed.monitor.replace_controller()
    feed.goal(2, "wall_e", GO, B, 1, 2).end(9)

    assert feed.violations == [(9.0, "goals_end", "wall_e", "not ended")]


def test_a_goal_that_ends_twice_is_told():
    """A terminal status after a terminal status is a violation at that instant."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2, 4).goal(3, "eve", GO, A, 6).end(9)

    assert feed.violations == [(3.0, "goals_end", "eve", "ended twice")]


def test_a_goal_that_goes_on_after_its_end_is_told():
    """A status that is not terminal after one that is, is a violation."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2, 4).goal(3, "eve", GO, A, 2).end(9)

    assert feed.violations == [(3.0, "goals_end", "eve", "goes on after its end")]


def test_a_goal_that_the_end_of_the_simulation_aborts_has_not_ended():
    """A goal that is aborted as the simulation ends was under way."""
    feed = Feed(built_in={"goals_end": True}).goal(1, "eve", GO, A, 1, 2).goal(5, "eve", GO, A, 6, cause="ended").end(5)

    assert feed.violations == [(5.0, "goals_end", "eve", "not ended")]


def test_a_deadlock_that_lasts_is_told_when_its_time_is_over():
    """A circle that began at 2 s is reported at 62 s, once time has come that far."""
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
def test_a_deadlock_that_is_untied_is_none(kind, fields):
    """A circle ends when one of its robots no longer waits for another one of them."""
    feed = Feed(built_in={"no_deadlock": 60})
    feed.event(1, "waiting", robot="eve", at=[0.0, 0.0], **{"for": ["wall_e"]})
    feed.event(2, "deadlock", robots=["eve", "wall_e"], lanes=[]).event(32, kind, **fields).end(500)

    assert (feed.violations, feed.verdict("no_deadlock").robustness) == ([], 0.5)


def test_a_robot_with_an_empty_battery_is_stranded_until_it_is_charged():
    """A robot may be empty for so long, and is not stranded while it is charged."""
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
def test_a_reset_charges_batteries_only_if_it_is_one_of_the_state(scope, found):
    """A reset of time, or of what was spawned, leaves a robot stranded."""
    feed = Feed(built_in={"nobody_stranded": 10})
    feed.event(1, "battery_empty", robot="eve", at=[0.0, 0.0], charge=0.0, percentage=0.0)
    feed.event(2, "reset", scope=scope).end(30)

    assert [at for at, *_ in feed.violations] == found


@pytest.mark.parametrize(("scope", "found"), [(1, []), (2, []), (4, [11.0])])
def test_a_reset_of_what_was_spawned_frees_no_robots(scope, found):
    """Robots that wait for each other go on to do so, unless they are halted."""
    feed = Feed(built_in={"no_deadlock": 10}).event(1, "deadlock", robots=["eve", "wall_e"], lanes=[])
    feed.event(2, "reset", scope=scope).end(30)

    assert [at for at, *_ in feed.violations] == found


def test_nobody_is_stranded_where_no_robot_has_a_battery():
    """Without batteries the property is never exercised."""
    feed = Feed(built_in={"nobody_stranded": 100}, world=ward(robots={"cart": {"at": "lab"}})).end(300)

    assert feed.verdict("nobody_stranded").state == "never_exercised"


def test_a_late_order_and_a_lost_one_are_told():
    """A late order is reported when it is due, and an order whose item is deleted at once."""
    feed = Feed(built_in={"orders_in_time": True}).event(5, "order_placed", **PLACED)
    feed.event(65, "order_late", order="pills_1", item="pills_1", to="ward_a")
    feed.event(70, "order_lost", order="pills_1", item="pills_1").end(80)

    assert feed.violations == [
        (65.0, "orders_in_time", "pills_1", "late"),
        (70.0, "orders_in_time", "pills_1", "lost"),
    ]


def test_the_robustness_of_orders_is_the_share_of_their_time_that_is_left():
    """An order of 60 s that was delivered after 45 s had a quarter of its time left."""
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
    """The message of an error is left out, so that two crashes with one bug have one reason."""
    feed = Feed(built_in={"controller_lives": True}).end(7, ending, cause)

    assert [(7.0, "controller_lives", "", reason)] == feed.violations


def test_of_a_run_that_was_stopped_it_is_not_known_how_its_controller_ends():
    """As of one that Ctrl-C has ended, or whose trace is cut off."""
    feed = Feed(built_in={"controller_lives": True}).end(7, "stopped")

    assert feed.verdict("controller_lives").state == "undecided"


def test_a_controller_that_is_dropped_from_lockstep_does_not_live():
    """A participant that does not answer in time is a violation."""
    feed = Feed(built_in={"controller_lives": True}).event(3, "participant_dropped", participant="bt", why="too slow")

    assert [(3.0, "controller_lives", "bt", "dropped")] == feed.end(9, None).violations


def test_a_run_that_comes_to_its_limit_has_not_ended():
    """A timeout is a violation; an end by the controller is none, whether it succeeded or not."""
    ended = {ending: Feed(built_in={"mission_ends": True}).end(600, ending) for ending in ("timeout", "failed")}

    assert ([(600.0, "mission_ends", "", "timeout")], "holds") == (
        ended["timeout"].violations,
        ended["failed"].verdict("mission_ends").state,
    )


RECOVERS = {"recovers": {"within": 30.0}}
ONE = {"fault": "goals_aborted", "robot": "eve", "count": 1}


def fault(feed, name, began, ended=None, **settings):
    """Feed the begin and the end of a fault."""
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
def test_a_mission_that_is_given_up_needlessly(faults, ending, expected):
    """It ends at 90 s."""
    feed = Feed(built_in=RECOVERS)
    for name, began, ended, settings in faults:
        fault(feed, name, began, ended, **settings)
    feed.end(90, ending)

    assert feed.verdict("recovers").state == expected
    assert bool(feed.violations) is (expected == "violated")


def fail(
    feed: Feed, at: float, goal: str, x: float, status: int = 6, cause: str = "blocked", took: float = 0.0
) -> None:
    """Let eve go to a point, for a while or not at all, and end there in a status."""
    began = at - took
    message = {"pose": {"header": {"stamp": {"sec": int(at)}}, "pose": {"position": {"x": x}}}}
    feed.event(began, "goal", robot="eve", action=GO, goal_id=goal * 32, goal=message)
    feed.goal(began, "eve", GO, goal * 32, 1, 2).goal(at, "eve", GO, goal * 32, status, cause=cause)


def test_the_same_goal_that_fails_again_and_again_is_told():
    """Three times in a row is too often: the robot gets to the same point each time, if at other times."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for at, goal in enumerate("abcd"):
        fail(feed, at, goal, x=1.0)

    assert [(2.0, "no_vain_goals", "eve", "aborted 3 times in a row")] == feed.end(9).violations


def test_a_vain_goal_is_fatal_at_once():
    """Such a loop may never end within its instant, so it is reported before time goes on."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for goal in "abc":
        fail(feed, 5.0, goal, x=1.0)

    assert [violation.fatal for violation in feed.monitor.violations] == [True]


def test_goals_that_differ_or_succeed_in_between_are_not_vain():
    """Another point is another goal, a success ends the row, and what the controller brings about does not count."""
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
    """A fleet that looks every half a minute whether a robot works again does not ask in vain."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for i in range(6):
        feed.event(30 * i, "rejected", robot="eve", action="wait", goal_id="c" * 32, reason="not_ready", error_msg="")

    assert feed.end(300).violations == []


def test_a_controller_that_is_started_anew_begins_a_new_row():
    """It tries twice, is killed, and its successor, which knows nothing of that, tries twice."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for i in range(4):
        if i == 2:
            feed.monitor.replace_controller()
        fail(feed, i, "abcd"[i], x=1.0)

    assert feed.end(9).violations == []


def test_a_controller_that_is_dropped_ends_its_rows():
    """Whoever comes after it is another one."""
    feed = Feed(built_in={"no_vain_goals": 3, "controller_lives": False})
    for i in range(4):
        if i == 2:
            feed.event(1.5, "participant_dropped", participant="client")
        fail(feed, i, "abcd"[i], x=1.0)

    assert feed.end(9).violations == []


def test_goals_that_take_no_time_may_be_vain_with_successes_in_between():
    """A robot drives to where it is already, and fails to pick up what it holds, for ever within one instant."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for number in range(30):
        fail(feed, 5.0, f"{number}s", x=0.0, status=4)
        fail(feed, 5.0, f"{number}f", x=1.0)

    assert [(5.0, "no_vain_goals", "eve", "aborted 30 times within one instant")] == feed.end(9).violations


def test_a_goal_that_takes_long_to_fail_is_no_pause():
    """The time between a failure and the next goal counts."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for at, goal in zip((30, 60, 90), "abc", strict=True):
        fail(feed, at, goal, x=1.0, took=29)

    assert [(90.0, "no_vain_goals", "eve", "aborted 3 times in a row")] == feed.end(99).violations


def test_rejected_goals_are_counted_by_what_is_said_of_them():
    """A recording does not have the messages of goals that are rejected; their errors stand for them."""
    feed = Feed(built_in={"no_vain_goals": 3})
    for i, why in enumerate(["far", "far", "near", "far"]):
        feed.event(i, "rejected", robot="eve", action=GO, goal_id="c" * 32, reason="unreachable", error_msg=why)

    assert [(3.0, "no_vain_goals", "eve", "rejected 3 times in a row")] == feed.end(9).violations


def test_a_simulation_is_watched_while_it_runs():
    """The hospital's mission violates nothing, and ends all goals."""
    monitor = watch("hospital", "bt_controller.examples.hospital:mission")

    assert ([], "33 goals have ended once") == (monitor.violations, monitor.verdicts()[0].text)
