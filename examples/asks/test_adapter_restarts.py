"""A fleet adapter restarts in the middle of a task and resumes the task.

Asked in https://github.com/open-rmf/rmf_ros2/issues/224, where a restarted adapter loses its tasks.
"""

from hmrsim.actions import registry
from hmrsim.testing import simulation
from hmrsim_zenoh import Commander

NAVIGATE = registry()["navigate_to_pose"]
GOAL = {"pose": {"pose": {"position": {"x": 14.0, "y": 7.0}}}}
GOAL_ID = "c0ffee" + "0" * 26
"""The id that the adapter saves before it sends the goal."""


def test_a_restarted_adapter_gets_the_result_of_its_earlier_goal() -> None:
    """The robot drives on during the restart, and the goal is not sent twice."""
    with simulation("cafe") as run:
        first = run.open_client("adapter")
        first.action_client("mocha", NAVIGATE).send_goal(GOAL, goal_id=GOAL_ID).wait_accepted()
        first.sleep(5)
        first.close()  # it crashes

        second = run.open_client("adapter")
        handle = second.action_client("mocha", NAVIGATE).send_goal(GOAL, goal_id=GOAL_ID, adopt=True)
        handle.result()

        assert handle.adopted
        assert [goal.status.name for goal in run.goals("mocha")] == ["SUCCEEDED"]
        assert run.where("mocha") == "table_3"
        second.close()
        Commander(run.client, "mocha").navigate_to("terrace")
