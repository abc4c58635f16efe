"""Statuses, results and codes from get_result, and how long they are remembered."""

from __future__ import annotations

import pytest

A, B, C = "a" * 32, "b" * 32, "c" * 32
NAVIGATE = "wall_e/navigate_to_pose"
WAIT = "wall_e/wait"
HANDLING = {
    "bounds": [0, 0, 20, 10],
    "items": {"parcel": {"at": [1, 2.1]}, "letter": {"at": [1, 1.9]}},
    "robot_types": {"nurse": {"components": {"claw": {"handling_time": 1000.0}}}},
    "robots": {"wall_e": {"type": "nurse", "at": [1, 2]}},
}


def test_a_result_request_is_held_until_the_goal_has_ended_for_each_client(live, wait):
    live.send(WAIT, wait(1000), A)
    held = [live.begin(f"{WAIT}/_action/get_result", {"goal_id": A}) for _ in range(3)]

    live.cancel(WAIT, A)

    assert [5, 5, 5] == [pending.one()["status"] for pending in held]


def test_any_client_can_request_a_result_repeatedly(fast, go):
    fast.send(NAVIGATE, go(5, 2), A)

    answers = [fast.result(NAVIGATE, A) for _ in range(3)]

    assert [{"status": 4, "result": {"error_code": 0, "error_msg": ""}}] * 3 == answers


def test_the_result_of_a_wait_has_all_fields_of_the_ros_type(fast, wait):
    assert fast.do(WAIT, wait(7)) == {
        "status": 4,
        "result": {"total_elapsed_time": {"sec": 7, "nanosec": 0}, "error_code": 0, "error_msg": ""},
    }


@pytest.mark.parametrize("goal_id", [A, "0" * 32])
def test_an_unknown_goal_has_status_zero_and_a_default_result(shared, goal_id):
    assert {"status": 0, "result": {"error_code": 0, "error_msg": ""}} == shared.result(NAVIGATE, goal_id)
    assert (0, 0) == (
        shared.result("wall_e/pickup", goal_id)["status"],
        shared.result("wall_e/pickup", goal_id)["result"]["error_code"]["val"],
    )


@pytest.mark.parametrize(
    ("target", "code", "text"),
    [((30, 2), 204, "outside"), ((-0.1, 2), 204, "outside"), ((7, 5), 206, "obstacle"), ((15, 5), 208, "route")],
)
def test_a_target_that_can_not_be_reached_is_aborted_with_the_planners_code(fast, go, target, code, text):
    answer = fast.do(NAVIGATE, go(*target))

    assert (6, code) == (answer["status"], answer["result"]["error_code"])
    assert text in answer["result"]["error_msg"]
    assert (1.0, 2.0) == fast.where("wall_e")


def test_a_robot_arrives_exactly_at_its_goal(fast, go):
    fast.do(NAVIGATE, go(9, 2.4))

    assert (9.0, 2.4) == fast.where("wall_e")


def test_a_preempted_goal_has_its_actions_unknown_code_and_names_the_new_one(live, go, wait):
    live.send(NAVIGATE, go(9, 2), A)

    live.send(WAIT, wait(1000), B)

    assert live.result(NAVIGATE, A) == {
        "status": 6,
        "result": {"error_code": 9000, "error_msg": f"preempted by goal {B}"},
    }
    assert [(B, 2)] == live.status(WAIT)


def test_a_preempted_wait_has_code_740(live, wait):
    """The code of a preempted Wait is its UNKNOWN."""
    live.send(WAIT, wait(1000), A)

    live.send(WAIT, wait(1000), B)

    answer = live.result(WAIT, A)
    assert (6, 740, f"preempted by goal {B}") == (
        answer["status"],
        answer["result"]["error_code"],
        answer["result"]["error_msg"],
    )


def test_a_canceled_goal_has_code_zero(live, go):
    """Nav2 has no code for it."""
    live.send(NAVIGATE, go(9, 2), A)

    live.cancel(NAVIGATE, A)

    assert {"status": 5, "result": {"error_code": 0, "error_msg": "canceled"}} == live.result(NAVIGATE, A)


@pytest.mark.parametrize(
    ("robot", "item", "code", "text"),
    [
        ("wall_e", "unicorn", -19, "no item 'unicorn'"),
        ("wall_e", "", -19, "no item ''"),
        ("wall_e", "parcel", -1, "out of reach: 8.006 m away, reach 0.9"),
        ("eve", "anvil", -4, "too heavy: 80 kg, the claw lifts 1 kg"),
    ],
)
def test_a_pickup_that_fails_has_moveits_code(fast, robot, item, code, text):
    answer = fast.do(f"{robot}/pickup", {"target_name": item})

    assert (6, code) == (answer["status"], answer["result"]["error_code"]["val"])
    assert text in answer["result"]["error_code"]["message"]


def test_a_pickup_and_a_place_succeed_with_code_one(fast):
    codes = [
        fast.do("eve/pickup", {"target_name": "parcel"})["result"]["error_code"]["val"],
        fast.do("eve/place", {"attached_object_name": "parcel"})["result"]["error_code"]["val"],
        fast.do("eve/pickup", {"target_name": "parcel"})["result"]["error_code"]["val"],
    ]

    assert [1, 1, 1] == codes


@pytest.mark.parametrize("name", ["parcel", ""])
def test_placing_without_an_item_is_invalid_object_name(fast, name):
    answer = fast.do("wall_e/place", {"attached_object_name": name})

    assert (6, -19) == (answer["status"], answer["result"]["error_code"]["val"])


def test_placing_another_item_names_the_one_held(fast):
    fast.do("wall_e/pickup", {"target_name": "letter"})

    answer = fast.do("wall_e/place", {"attached_object_name": "parcel"})

    assert (-19, "the claw holds 'letter', not 'parcel'") == (
        answer["result"]["error_code"]["val"],
        answer["result"]["error_code"]["message"],
    )


def test_a_full_claw_is_invalid_robot_state(fast):
    fast.do("wall_e/pickup", {"target_name": "letter"})

    answer = fast.do("wall_e/pickup", {"target_name": "letter"})

    assert (6, -17) == (answer["status"], answer["result"]["error_code"]["val"])


def test_an_item_that_another_robot_carries_is_motion_plan_invalidated(fast):
    fast.do("eve/pickup", {"target_name": "parcel"})

    answer = fast.do("wall_e/pickup", {"target_name": "parcel"})

    assert (6, -3) == (answer["status"], answer["result"]["error_code"]["val"])
    assert "eve" in answer["result"]["error_code"]["message"]


@pytest.mark.parametrize(("action", "goal"), [("pickup", {"target_name": "letter"}), ("place", {})])
def test_a_claw_does_not_work_while_a_goal_holds_the_base(live, wait, action, goal):
    """The goal that holds the base continues."""
    live.send(WAIT, wait(1000), A)

    answer = live.do(f"wall_e/{action}", goal)

    assert (6, -17) == (answer["status"], answer["result"]["error_code"]["val"])
    assert A in answer["result"]["error_code"]["message"]
    assert [(A, 2)] == live.status(WAIT)


def test_a_second_pickup_is_aborted(serve):
    tester = serve(HANDLING, real_time_factor=1.0)
    tester.send("wall_e/pickup", {"target_name": "parcel"}, A)

    answer = tester.do("wall_e/pickup", {"target_name": "letter"})

    assert (6, -17) == (answer["status"], answer["result"]["error_code"]["val"])
    assert [2, 6] == [status for _, status in tester.status("wall_e/pickup")]


def test_a_canceled_pickup_has_code_preempted(serve):
    tester = serve(HANDLING, real_time_factor=1.0)
    tester.send("wall_e/pickup", {"target_name": "parcel"}, A)

    tester.cancel("wall_e/pickup", A)

    answer = tester.result("wall_e/pickup", A)
    assert (5, -7, "canceled") == (
        answer["status"],
        answer["result"]["error_code"]["val"],
        answer["result"]["error_code"]["message"],
    )


def test_a_preempted_pickup_has_code_preempted(serve, wait):
    tester = serve(HANDLING, real_time_factor=1.0)
    tester.send("wall_e/pickup", {"target_name": "parcel"}, A)

    tester.send(WAIT, wait(1000), B)

    answer = tester.result("wall_e/pickup", A)
    assert (6, -7, f"preempted by goal {B}") == (
        answer["status"],
        answer["result"]["error_code"]["val"],
        answer["result"]["error_code"]["message"],
    )


class TestKept:
    """Results are remembered for a while, and ids for longer."""

    def test_a_result_is_forgotten_after_its_time(self, serve, wait):
        """Its id is still refused, with how the goal ended."""
        tester = serve(real_time_factor=0, result_timeout=0.05)
        tester.send(WAIT, wait(1), A)

        answers = iter(lambda: tester.result(WAIT, A)["status"], 0)

        assert {4} >= set(answers)
        assert [] == tester.status(WAIT)
        again = tester.send(WAIT, wait(1), A)
        assert (False, "duplicate_goal_id", 4) == (again["accepted"], again["reason"], again["status"])

    def test_a_goal_that_runs_is_not_forgotten(self, serve, wait):
        """The time counts from its end, not from its acceptance."""
        tester = serve(real_time_factor=10.0, result_timeout=0.05)

        tester.send(WAIT, wait(1_000_000), A)
        # A wall second, in which it would have been forgotten twenty times.
        tester.do("eve/wait", wait(10))

        assert [(A, 2)] == tester.status(WAIT)
        tester.cancel(WAIT, A)

    def test_a_timeout_of_zero_still_answers_waiting_clients(self, serve, wait):
        tester = serve(real_time_factor=10.0, result_timeout=0.0)
        tester.send(WAIT, wait(1), A)

        answers = [tester.result(WAIT, A)["status"] for _ in range(2)]

        assert [4, 0] == answers

    def test_a_negative_timeout_keeps_results_for_ever(self, serve, wait):
        tester = serve(real_time_factor=0, result_timeout=-1.0)
        tester.do(WAIT, wait(1))
        tester.send(WAIT, wait(1), A)

        assert 4 == tester.result(WAIT, A)["status"]
        assert 2 == len(tester.status(WAIT))

    def test_the_oldest_is_forgotten_when_there_are_too_many(self, serve, wait):
        """Its id is still refused."""
        tester = serve(real_time_factor=0, keep_results=2)
        for goal_id in (A, B, C):
            tester.send(WAIT, wait(1), goal_id)
            tester.result(WAIT, goal_id)

        assert [0, 4, 4] == [tester.result(WAIT, goal_id)["status"] for goal_id in (A, B, C)]
        assert [(B, 4), (C, 4)] == tester.status(WAIT)
        assert "duplicate_goal_id" == tester.send(WAIT, wait(1), A)["reason"]
        assert 2 == tester.cancel(WAIT, A)["return_code"]
