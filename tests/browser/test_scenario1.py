"""Scenario 1 on the page, as it happens."""

from __future__ import annotations

from benchmarks._browser import until

YELLOW, RED = "#f5c400", "#d6273a"
HOME, ROOM, BED = [515, 80], [512, 215], [100, 180]
_NEAR = """([[x, y], within]) => {
  const [atX, atY] = hmrsim.model.robots.get('wall_e').poseAt(hmrsim.clock.now());
  return Math.hypot(atX - x, atY - y) <= within;
}"""
SUCCEEDED = 4


def _at(point):
    return {"pose": {"pose": {"position": {"x": point[0], "y": point[1]}}}}


def test_scenario_1(viewed, ask, open_page, coloured):
    """The page shows the robot in the right place, in data and in pixels."""
    endpoint, url = viewed("scenario1", "--real-time-factor", "0.5")
    simulator, page = ask(endpoint), open_page(f"{url}?theme=light")
    assert coloured(page, HOME, YELLOW) > 20
    assert coloured(page, [518.5, 199], RED) > 5

    goal = simulator.send("wall_e", "navigate_to_pose", **_at(ROOM))
    until(page, "hmrsim.model.robots.get('wall_e').poseAt(hmrsim.clock.now())[0] < 450")
    simulator.call("set_simulation_state", state={"state": 2})
    until(page, "hmrsim.clock.paused")
    x, y, _ = simulator.robot("wall_e")["pose"]
    until(page, _NEAR, [[x, y], 1.0])
    # On a busy machine the simulator is behind the page, which goes on by itself.
    assert 400 <= x < 495
    assert coloured(page, [x, y], YELLOW) > 20
    assert coloured(page, HOME, YELLOW) == 0

    simulator.call("set_simulation_state", state={"state": 1})
    assert simulator.result("wall_e", "navigate_to_pose", goal) == SUCCEEDED
    assert simulator.do("wall_e", "pickup", target_name="medicine") == SUCCEEDED
    until(page, "hmrsim.model.robots.get('wall_e').holds.includes('medicine')")
    assert simulator.do("wall_e", "navigate_to_pose", **_at(BED)) == SUCCEEDED
    assert simulator.do("wall_e", "place", attached_object_name="medicine") == SUCCEEDED
    until(page, "hmrsim.model.robots.get('wall_e').holds.length === 0")
    until(page, _NEAR, [BED, 0.01])
    assert coloured(page, BED, YELLOW) > 20
    assert coloured(page, ROOM, YELLOW) == 0
    assert coloured(page, [518.5, 199], RED) == 0
    statuses = page.evaluate("[...hmrsim.model.goals.values()].map((goal) => [goal.action, goal.status])")
    assert [[name, SUCCEEDED] for name in ("navigate_to_pose", "pickup", "navigate_to_pose", "place")] == statuses
