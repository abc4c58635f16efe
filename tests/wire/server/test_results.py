"""Statuses, results and codes from get_result, and how long they are remembered."""

from __future__ import annotations

import pytest

A, B, C = "a" * 32, "b" * 32, "c" * 32
NAVIGATE = "wall_e/navigate_to_pose"
WAIT = "wall_e/wait"


def test_a_result_request_is_held_until_the_goal_has_ended_for_each_client(live, wait):
    live.send(WAIT, wait(1000), A)
    held = [live.begin(f"{WAIT}/_action/get_result", {"goal_id": A}) for _ in range(3)]

    live.cancel(WAIT, A)

    assert [5, 5, 5] == [pending.one()["status"] for pending in held]


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


def test_a_preempted_goal_has_its_actions_unknown_code_and_names_the_new_one(live, go, wait):
    live.send(NAVIGATE, go(9, 2), A)

    live.send(WAIT, wait(1000), B)

    assert live.result(NAVIGATE, A) == {
        "status": 6,
        "result": {"error_code": 9000, "error_msg": f"preempted by goal {B}"},
    }
    assert [(B, 2)] == live.status(WAIT)


def test_a_failed_pickup_has_moveits_code(fast):
    answer = fast.do("wall_e/pickup", {"target_name": "unicorn"})

    assert (6, -19) == (answer["status"], answer["result"]["error_code"]["val"])
    assert "no item 'unicorn'" in answer["result"]["error_code"]["message"]


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
