"""Docks: driving in and out, queueing for a berth, and cancels at any stage."""

from __future__ import annotations

from functools import partial

import pytest

from hmrsim.goals.script_orders import read_order
from hmrsim.protocol.commands import CancelGoal
from hmrsim.protocol.topics import Topic
from hmrsim.world.model import World
from tests import simulation
from tests.simulation import A, B, C, D, send, simulate

NONE, STAGING, PERCEPTION, CONTROLLING, CHARGE = 0, 1, 2, 3, 4


@pytest.fixture
def make_run():
    """Return the function that makes simulations with few subscribers, as some runs are long."""
    return partial(simulate, topics=frozenset({Topic.EVENTS, Topic.FEEDBACK}))


def world(robots=("eve",), traffic="free", **dock):
    return {
        "waypoints": {"west": [0, 0], "east": [20, 0], "south": [0, -10], "north": [0, 10]},
        "lanes": [["west", "east"], ["south", "west"], ["north", "west"]],
        "docks": {"bay": {"at": [10, 5], **dock}, "charger": {"at": [20, 5], "type": "charger", "power": 2.0}},
        "robots": {
            name: {"at": at, "components": {"battery": {"capacity": 1000}}}
            for name, at in zip(robots, ("west", "south", "north"), strict=False)
        },
        "traffic": {"policy": traffic},
    }


def dock(robot="eve", goal_id=A, *, dock_id="bay", **goal):
    return send("dock_robot", goal_id, robot, dock_id=dock_id, **goal)


def undock(robot="eve", goal_id=B, **goal):
    return send("undock_robot", goal_id, robot, **goal)


def go(x, y=0.0, robot="eve", goal_id=C):
    return simulation.go(x, y, goal_id, robot)


def told(log, kind):
    return [(at, fields["robot"], fields["dock"]) for at, fields in log.happened(kind)]


def error(log, goal_id):
    return log.result(goal_id).error_code, log.result(goal_id).error_msg


def tags(run, entity):
    return run.ask("get_entity_info", {"entity": entity}).info.tags


class TestDocking:
    def test_a_robot_lines_up_drives_in_and_is_docked(self, make_run):
        """The robot drives 10 m along the lane and 5 m beside it."""
        run = make_run(world())
        log = run((0.0, dock()))

        assert (15.0, "SUCCEEDED") == log.changes(A)[-1]
        assert [(15.0, "eve", "bay")] == told(log, "dock_docked")
        assert (10.0, 5.0) == run.simulator.robots["eve"].pose().point
        assert (True, 0) == (log.result(A).success, log.result(A).num_retries)
        assert (0, "") == error(log, A)

    def test_feedback_names_each_stage(self, make_run):
        log = make_run(world())((0.0, dock()))
        stages = dict.fromkeys((feedback.state, 0.0) for _, feedback in log.feedback(A))
        first = {feedback.state: at for at, feedback in reversed(log.feedback(A))}
        last = log.feedback(A)[-1][1]

        assert [STAGING, PERCEPTION, CONTROLLING] == [state for state, _ in stages]
        assert {STAGING: 0.0, PERCEPTION: 10.0, CONTROLLING: 10.0} == first
        assert 15 == last.docking_time.sec

    def test_at_a_charger_the_goal_waits_until_it_charges(self, make_run):
        run = make_run(world())
        log = run((0.0, dock(dock_id="charger")), until=25.0)

        assert (25.0, "SUCCEEDED") == log.changes(A)[-1]
        assert CHARGE == log.feedback(A)[-1][1].state
        assert [25.0] == [at for at, _ in log.happened("charging_began")]
        assert {"charging", "docked:charger"} <= {*tags(run, "eve")}

    def test_a_dock_can_have_a_yaw_and_a_staging_pose(self, make_run):
        run = make_run(world(yaw=-1.0, staging=[20, 0]))
        log = run((0.0, dock()))

        assert -1.0 == run.simulator.robots["eve"].pose().yaw
        assert 20.0 == min(at for at, feedback in log.feedback(A) if feedback.state == CONTROLLING)

    @pytest.mark.parametrize(
        ("goal", "end"),
        [
            ({"navigate_to_staging_pose": False}, 125**0.5),
            (
                {"use_dock_id": False, "dock_pose": {"pose": {"position": {"x": 10.0, "y": 5.0}}}, "dock_type": "dock"},
                15.0,
            ),
        ],
    )
    def test_a_robot_can_skip_the_staging_pose_or_name_the_dock_by_its_pose(self, make_run, goal, end):
        log = make_run(world())((0.0, dock(**goal)))

        assert (pytest.approx(end), "SUCCEEDED") == log.changes(A)[-1]

    def test_a_dock_can_be_at_a_waypoint(self, make_run):
        run = make_run(world(at="east"))
        log = run((0.0, dock()), (30.0, undock()))

        assert [(20.0, "SUCCEEDED"), (30.0, "SUCCEEDED")] == [log.changes(A)[-1], log.changes(B)[-1]]
        assert [(30.0, "eve", "bay")] == told(log, "dock_undocked")

    def test_a_docked_robot_succeeds_at_once(self, make_run):
        log = make_run(world())((0.0, dock()), (20.0, dock(goal_id=B)))

        assert (20.0, "SUCCEEDED") == log.changes(B)[-1]

    @pytest.mark.parametrize(
        ("goal", "code", "text"),
        [
            ({"dock_id": "bey"}, 901, "no dock 'bey'; there are: bay, charger"),
            ({"dock_type": "charger"}, 902, "'bay' is a dock, not a charger"),
            ({"use_dock_id": False}, 904, "no dock at (0, 0); the nearest is 'bay', 11.1803 away"),
        ],
    )
    def test_impossible_goals_are_aborted_at_once(self, make_run, goal, code, text):
        log = make_run(world())((1.0, dock(**goal)))

        assert (1.0, "ABORTED") == log.changes(A)[-1]
        assert (False, (code, text)) == (log.result(A).success, error(log, A))

    def test_a_dock_may_be_reserved(self, make_run):
        log = make_run(world(("eve", "wall_e"), reserved_for=["wall_e"]))((0.0, dock()), (1.0, dock("wall_e", B)))

        assert (902, "'bay' is reserved for wall_e") == error(log, A)
        assert (26.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_without_a_battery_nothing_can_charge(self, make_run):
        made = world()
        made["robots"]["eve"]["components"] = {}
        log = make_run(made)((0.0, dock(dock_id="charger")), (1.0, dock(goal_id=B)))

        assert (906, "eve has no battery that 'charger' could charge") == error(log, A)
        assert (16.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_staging_is_aborted_after_its_time_limit(self, make_run):
        """Another robot may take the berth in the meantime."""
        run = make_run(world(("eve", "wall_e")))
        log = run((0.0, dock(max_staging_time=4.0)), (1.0, dock("wall_e", B)))

        assert (4.0, "ABORTED") == log.changes(A)[-1]
        assert (903, "can't line up for 'bay': it takes longer than 4 s") == error(log, A)
        assert (4.0, 0.0) == run.simulator.robots["eve"].pose().point
        assert (29.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_a_timeout_in_the_queue_names_the_robots_at_the_dock(self, make_run):
        log = make_run(world(("eve", "wall_e")))(
            (0.0, dock()), (1.0, dock("wall_e", B, max_staging_time=4.0)), (30.0, dock("wall_e", D, max_staging_time=4))
        )

        late = "can't line up for 'bay': it takes longer than 4 s: wall_e has queued at south since"
        moving = "eve is driving at (5, 0); what would help: more time, because it is moving"
        assert f"{late} 1 s for 'bay', taken by eve; {moving}" == log.result(B).error_msg
        assert f"{late} 30 s for 'bay', taken by eve; eve is docked in 'bay' at bay" in log.result(D).error_msg

    def test_an_empty_battery_in_the_queue_names_the_robots_at_the_dock(self, make_run):
        made = world(("eve", "wall_e"))
        made["robots"]["wall_e"]["components"]["battery"] = {"capacity": 10, "drain": {"default": 1}}
        log = make_run(made)((0.0, dock()), (1.0, dock("wall_e", B)))

        assert (10.0, "ABORTED") == log.changes(B)[-1]
        assert (
            "battery empty at (0, -10); held up until then: "
            "wall_e has queued at south since 1 s for 'bay', taken by eve" in log.result(B).error_msg
        )

    def test_an_unreachable_dock_is_aborted(self, make_run):
        made = world()
        made["walls"] = [[[-5, -20], [50, -20]]]
        made["docks"]["bay"]["at"] = [0, -30]
        log = make_run(made)((0.0, dock()))

        assert 903 == log.result(A).error_code
        assert log.result(A).error_msg.startswith("can't line up for 'bay': no route from west to bay")

    def test_a_staging_pose_behind_an_obstacle_is_aborted(self, make_run):
        made = world(staging=[5, 0])
        made["walls"] = [[[6, 1], [6, 20]]]
        log = make_run(made)((0.0, dock()))

        assert (905, "can't drive into 'bay': an obstacle stands between (5, 0) and (10, 5)") == error(log, A)


class TestUndocking:
    def test_a_robot_leaves_for_the_staging_pose(self, make_run):
        run = make_run(world())
        log = run((0.0, dock()), (20.0, undock()))

        assert (25.0, "SUCCEEDED") == log.changes(B)[-1]
        assert [(20.0, "eve", "bay")] == told(log, "dock_undocked")
        assert (10.0, 0.0) == run.simulator.robots["eve"].pose().point

    @pytest.mark.parametrize(
        ("before", "goal", "code", "text"),
        [
            ([(0.0, dock())], {"dock_type": "charger"}, 902, "'bay' is a dock, not a charger"),
            ([(0.0, dock())], {"max_undocking_time": 2.0}, 907, "can't leave 'bay' within 2 s"),
            ([], {}, 902, "eve is not docked"),
        ],
    )
    def test_impossible_undocking_is_aborted(self, make_run, before, goal, code, text):
        log = make_run(world())(*before, (20.0, undock(**goal)))

        assert (False, (code, text)) == (log.result(B).success, error(log, B))

    def test_a_robot_can_continue_after_a_cancel(self, make_run):
        log = make_run(world())(
            (0.0, dock()), (20.0, undock()), (22.0, CancelGoal("eve", "undock_robot", B)), (23.0, undock(goal_id=C))
        )

        assert [(22.0, "CANCELED"), (26.0, "SUCCEEDED")] == [log.changes(B)[-1], log.changes(C)[-1]]

    def test_a_robot_that_drives_off_is_undocked(self, make_run):
        log = make_run(world())((0.0, dock()), (20.0, go(0)))

        assert [(20.0, "eve", "bay")] == told(log, "dock_undocked")


class TestDockedWithoutGoal:
    def test_a_robot_that_begins_at_a_dock_is_docked(self, make_run):
        made = world()
        made["robots"]["eve"]["at"] = "bay"
        run = make_run(made)

        assert "docked:bay" in tags(run, "eve")
        assert ["dock", "full", "docked:eve"] == tags(run, "bay")
        assert ["dock", "charger", "free"] == tags(run, "charger")

    def test_a_robot_that_is_moved_onto_a_dock_is_docked(self, make_run):
        run = make_run(world())
        for x, y in ((10.0, 5.0), (0.0, 0.0)):
            run.ask("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": x, "y": y}}}})

        assert [(0.0, "eve", "bay")] == told(run.log, "dock_docked")
        assert [(0.0, "eve", "bay")] == told(run.log, "dock_undocked")

    def test_driving_to_a_dock_is_not_docking(self, make_run):
        run = make_run(world())
        log = run((0.0, go(10, 5)))

        assert [] == told(log, "dock_docked")

    def test_a_reset_restores_the_docked_robots(self, make_run):
        made = world(("eve", "wall_e"))
        made["robots"]["wall_e"]["at"] = "bay"
        run = make_run(made)
        run((0.0, go(0, robot="wall_e", goal_id=C)), (0.0, dock()), until=30.0)
        run.ask("reset_simulation")

        assert ["dock", "full", "docked:wall_e"] == tags(run, "bay")

    def test_a_dock_is_an_entity(self, make_run):
        run = make_run(world())
        state = run.ask("get_entity_state", {"entity": "bay"}).state

        assert (10.0, 5.0) == (state.pose.position.x, state.pose.position.y)
        assert "dock for one robot" == run.ask("get_entity_info", {"entity": "bay"}).info.description


class TestQueue:
    def test_the_next_robot_sets_out_when_a_berth_is_free(self, make_run):
        run = make_run(world(("eve", "wall_e", "m_o")))
        log = run(
            (0.0, dock()),
            (1.0, dock("m_o", B)),
            (2.0, dock("wall_e", C)),
            (30.0, go(0)),
            (70.0, go(0, robot="m_o", goal_id=D)),
        )

        assert [(1.0, "m_o", "bay"), (2.0, "wall_e", "bay")] == told(log, "dock_queued")
        assert [1, 2] == [fields["position"] for _, fields in log.happened("dock_queued")]
        assert [(15.0, "eve", "bay"), (55.0, "m_o", "bay"), (95.0, "wall_e", "bay")] == told(log, "dock_docked")
        assert NONE == log.feedback(B)[0][1].state

    def test_a_dock_for_two_takes_two(self, make_run):
        run = make_run(world(("eve", "wall_e", "m_o"), capacity=2))
        run((0.0, dock()), (0.0, dock("wall_e", B)), (0.0, dock("m_o", C)), until=40.0)

        assert ["dock", "full", "docked:eve", "docked:wall_e", "queued:m_o"] == tags(run, "bay")

    @pytest.mark.parametrize("end", ["cancel", "preempt", "delete", "time"])
    def test_a_robot_that_leaves_the_queue_is_skipped(self, make_run, end):
        ends = {
            "cancel": lambda run: run.simulator.submit(CancelGoal("wall_e", "dock_robot", B)),
            "preempt": lambda run: run.simulator.submit(go(0, robot="wall_e", goal_id=D)),
            "delete": lambda run: run.ask("delete_entity", {"entity": "wall_e"}),
            "time": lambda _run: None,
        }
        run = make_run(world(("eve", "wall_e", "m_o")))
        run((0.0, dock()), (1.0, dock("wall_e", B, max_staging_time=8.5)), (2.0, dock("m_o", C)), until=9.0)
        ends[end](run)
        log = run((30.0, undock("eve", "e" * 32)))

        assert (9.5 if end == "time" else 9.0) == log.changes(B)[-1][0]
        assert (55.0, "SUCCEEDED") == log.changes(C)[-1]

    @pytest.mark.parametrize("at", [0.0, 5.0, 10.0, 12.0])
    def test_a_cancel_at_any_stage_leaves_robot_and_dock_usable(self, make_run, at):
        run = make_run(world(("eve", "wall_e")))
        log = run(
            (0.0, dock()),
            (at, CancelGoal("eve", "dock_robot", A)),
            (at, dock("wall_e", B)),
            (at + 40, undock("wall_e", C)),
            (at + 60, dock(goal_id=D)),
        )

        assert ["CANCELED", "SUCCEEDED", "SUCCEEDED", "SUCCEEDED"] == [
            log.changes(each)[-1][1] for each in (A, B, C, D)
        ]
        assert (at, at + 25.0) == (log.changes(A)[-1][0], log.changes(B)[-1][0])

    @pytest.mark.parametrize("traffic", ["reserve", "priority"])
    def test_docking_works_under_reserve(self, make_run, traffic):
        """Two berths share one point off the lanes; the third robot waits for one of the two to leave."""
        run = make_run(world(("eve", "wall_e", "m_o"), traffic, capacity=2))
        log = run((0.0, dock()), (0.0, dock("wall_e", B)), (0.0, dock("m_o", C)), (60.0, go(20, goal_id=D)))

        assert ["SUCCEEDED"] * 4 == [log.changes(each)[-1][1] for each in (A, B, C, D)]

    def test_an_undocked_robot_occupies_the_lane_under_reserve(self, make_run):
        run = make_run(world(("eve", "wall_e"), "reserve"))
        log = run((0.0, dock()), (20.0, undock()), (26.0, go(20, robot="wall_e")), (60.0, go(20, goal_id=D)))

        assert [(36.0, ["eve"])] == [(at, told["for"]) for at, told in log.happened("waiting") if "for" in told]


class TestOrders:
    def test_scripts_dock_and_undock_by_name(self, make_run):
        made = world()
        made["robots"]["eve"]["script"] = ["Dock bay", "Wait 5", "Undock"]
        run = make_run(made)
        run.simulator.run_scripts()

        assert ["done"] == [script.state.value for script in run.simulator.scripts.all.values()]
        assert 25.0 == run.simulator.now

    @pytest.mark.parametrize(
        ("text", "wrong"),
        [
            ("Dock bey", "no dock 'bey'; did you mean 'bay'?"),
            ("Dock", "'Dock' says too little; expected Dock DOCK"),
            ("Undock bay", "nothing comes after Undock, got 'bay'"),
        ],
    )
    def test_invalid_orders_are_rejected(self, text, wrong):
        with pytest.raises(ValueError, match=wrong.replace("?", r"\?")):
            read_order(text, World.model_validate(world()))
