"""Names of places instead of poses in goals."""

from __future__ import annotations

import math

import pytest

from hmrsim.actions import registry
from hmrsim.cli.goal_text import read_goal
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.simulation_interfaces import SpawnEntity
from hmrsim_zenoh.client.places import with_names, with_poses

COUNTER = PoseStamped(pose=Pose(position=Point(x=2.0, y=3.0)))


def pose(name):
    """Return the pose of the counter."""
    if name != "counter":
        raise ValueError(f"no place {name!r}")
    return COUNTER


@pytest.mark.parametrize(
    ("action", "goal", "field"),
    [
        ("navigate_to_pose", {"pose": "counter"}, lambda goal: goal.pose),
        ("follow_waypoints", {"poses": [{}, "counter"], "number_of_loops": 2}, lambda goal: goal.poses[1]),
        ("navigate_through_poses", {"poses": {"goals": ["counter"]}}, lambda goal: goal.poses.goals[0]),
        ("follow_path", {"path": {"poses": ["counter"]}}, lambda goal: goal.path.poses[0]),
    ],
)
def test_a_place_wherever_a_pose_is(action, goal, field):
    """A name stands for its pose, in lists and in nested messages, too."""
    kind = registry()[action].goal

    assert COUNTER == field(read_goal(with_poses(goal, kind, pose), kind))


@pytest.mark.parametrize("sequence", [list, tuple])
@pytest.mark.parametrize(("numbers", "w"), [((2, 3), 1.0), ((2.0, 3, math.pi), 0.0)])
def test_a_list_or_tuple_of_x_y_and_yaw_is_a_pose(numbers, w, sequence):
    kind = registry()["navigate_to_pose"].goal

    goal = read_goal(with_poses({"pose": sequence(numbers)}, kind, pose), kind)

    assert COUNTER.pose.position == goal.pose.pose.position
    assert w == pytest.approx(goal.pose.pose.orientation.w)


def test_poses_in_a_tuple():
    found = with_poses({"poses": ((2, 3), "counter")}, registry()["follow_waypoints"].goal, pose)

    assert [COUNTER.pose.position.x] * 2 == [each["pose"]["position"]["x"] for each in found["poses"]]


def test_a_pose_without_a_stamp():
    """A field that is a bare pose gets a bare pose."""
    found = with_poses({"initial_pose": "counter"}, SpawnEntity.Request, pose)

    assert COUNTER == SpawnEntity.Request.model_validate(found).initial_pose


def test_every_unknown_place_is_told():
    """Each error has one line, which names its field."""
    with pytest.raises(ValueError, match="goal") as caught:
        with_poses({"poses": ["kitchen", "counter", "hall"]}, registry()["follow_waypoints"].goal, pose)

    assert "goal: poses.0: no place 'kitchen'\ngoal: poses.2: no place 'hall'" == str(caught.value)


@pytest.mark.parametrize(
    "data",
    [
        *(None, 3, "counter", [1], {"x": "counter"}, {"pose": 3}, {"poses": "counter"}),
        *({"poses": [part]} for part in ([1], (1,), [1, "2"], [1, 2, 3, 4], [True, 1], [math.inf, 1], [10**400, 1])),
    ],
)
def test_what_is_no_goal_stays(data):
    """Other errors are reported by the check of the goal."""
    assert data == with_poses(data, registry()["follow_waypoints"].goal, pose)


def test_names_in_place_of_poses():
    """The poses of an example are replaced by names as long as there are any."""
    kind = registry()["follow_waypoints"].goal

    assert {"poses": ["hall", {"pose": {}}]} == with_names({"poses": [{}, {"pose": {}}]}, kind, iter(["hall"]))


class TestGoalsInPlainValues:
    """Poses of goals of an action client that are given by name."""

    def test_a_place_is_looked_up(self, simulation):
        run = simulation("cafe")
        client = run.client.action_client("mocha", registry()["navigate_to_pose"])

        client.send_goal({"pose": "table_1"}).result()

        assert run.where("mocha") == "table_1"

    def test_a_place_that_does_not_exist(self, simulation):
        client = simulation("cafe").client.action_client("mocha", registry()["navigate_to_pose"])

        with pytest.raises(ValueError, match=r"goal: pose: no place 'tabel_1'; did you mean 'table_1'\?"):
            client.send_goal({"pose": "tabel_1"})
