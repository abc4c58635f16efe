"""A first message: a goal as JSON, with no library but Zenoh.

Asked in https://github.com/bekirbostanci/vda5050_visualizer/issues/4, which requests a sample order.
"""

import json

from hmrsim.testing import simulation

ORDER = {"goal": {"pose": {"pose": {"position": {"x": 6, "y": 6}}}}}


def test_a_goal_and_its_result_are_one_query_each() -> None:
    """Over a network, the query is ``session.get(key, payload=...)`` in any language."""
    with simulation("cafe") as run:
        action = "hmrsim/mocha/navigate_to_pose/_action"
        accepted = json.loads(run.client.get(f"{action}/send_goal", payload=json.dumps(ORDER).encode()))
        assert accepted["accepted"]
        run.client.sleep(60)
        wanted = {"goal_id": accepted["goal_id"]}
        ended = json.loads(run.client.get(f"{action}/get_result", payload=json.dumps(wanted).encode()))

        assert (ended["status"], run.where("mocha")) == (4, "table_1")
