"""Differences of other distributions from kilted, in messages that we send and receive."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.nav2_msgs import (
    BackUp,
    ComputeAndTrackRoute,
    ComputePathThroughPoses,
    ComputePathToPose,
    ComputeRoute,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    TrackingFeedback,
    WaypointStatus,
)
from hmrsim.interfaces.nav_msgs import Goals
from hmrsim.interfaces.simulation_interfaces import LoadWorld, SetEntityState, Spawnable, SpawnEntity
from hmrsim.interfaces.std_msgs import Header
from hmrsim_zenoh.ros2.codec.encoder import encoder
from hmrsim_zenoh.ros2.codec.structures import Structure
from hmrsim_zenoh.ros2.codec.types import message_type

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

THERE = PoseStamped(header=Header(frame_id="there"))


def trip(message: Message, distro: str) -> Message:
    """Encode and decode a message in a distribution's layout."""
    type_ = message_type(type(message), distro)
    return type(message).model_validate(type_.decode(type_.encode(message)))


@pytest.mark.parametrize("cls", [BackUp.Goal, DriveOnHeading.Goal, Spin.Goal])
def test_jazzy_behaviors_have_no_field_for_disabling_collision_checks(cls: Any) -> None:
    sent = message_type(cls, "jazzy").encode(cls())

    assert len(message_type(cls, "kilted").encode(cls())) - 1 == len(sent)
    assert not trip(cls(disable_collision_checks=True), "jazzy").disable_collision_checks


def test_jazzys_poses_have_no_header() -> None:
    goal = NavigateThroughPoses.Goal(poses=Goals(header=Header(frame_id="map"), goals=[THERE]))

    assert NavigateThroughPoses.Goal(poses=Goals(goals=[THERE])) == trip(goal, "jazzy")


def test_a_list_of_poses_from_jazzy_is_read_as_goals_of_kilted() -> None:
    data = bytes.fromhex("00010000" + "00000000" + "01000000" + "00")

    assert message_type(NavigateThroughPoses.Goal, "jazzy").decode(data) == {
        "poses": {"goals": []},
        "behavior_tree": "",
    }


@pytest.mark.parametrize("cls", [NavigateThroughPoses.Result, NavigateThroughPoses.Feedback])
def test_jazzy_has_no_status_of_waypoints(cls: Any) -> None:
    assert cls() == trip(cls(waypoint_statuses=[WaypointStatus(waypoint_index=1)]), "jazzy")


def test_jazzy_has_missed_waypoints() -> None:
    missed = WaypointStatus(
        waypoint_status=3, waypoint_index=7, waypoint_pose=THERE, error_code=208, error_msg="no path"
    )

    assert FollowWaypoints.Result(
        missed_waypoints=[WaypointStatus(waypoint_index=7, waypoint_pose=THERE, error_code=208)]
    ) == trip(FollowWaypoints.Result(missed_waypoints=[missed]), "jazzy")


def test_jazzys_missed_waypoint_has_other_type_and_field_names() -> None:
    described = message_type(WaypointStatus, "jazzy").structure

    assert (described.name, [field.name for field in described.fields]) == (
        "nav2_msgs/msg/MissedWaypoint",
        ["index", "goal", "error_code"],
    )


def test_lyrical_has_tracking_errors_of_zero() -> None:
    """Simulated robots keep to their paths exactly."""
    feedback = NavigateToPose.Feedback(distance_remaining=2.0)
    kilted = message_type(NavigateToPose.Feedback, "kilted").encode(feedback)

    assert kilted + bytes(8) == message_type(NavigateToPose.Feedback, "lyrical").encode(feedback)


def test_lyricals_tracking_errors_come_before_the_remaining_poses() -> None:
    fields = message_type(NavigateThroughPoses.Feedback, "lyrical").structure.fields

    assert [field.name for field in fields][4:] == [
        "distance_remaining",
        "position_tracking_error",
        "heading_tracking_error",
        "number_of_poses_remaining",
        "waypoint_statuses",
    ]


def test_only_lyrical_nests_the_feedback_on_a_path() -> None:
    tracking = TrackingFeedback(distance_to_goal=1.0, speed=0.5, current_path_index=3)
    feedback = FollowPath.Feedback(distance_to_goal=2.0, speed=0.5, tracking_feedback=tracking)

    assert FollowPath.Feedback(tracking_feedback=tracking) == trip(feedback, "lyrical")
    for distro in ("jazzy", "kilted"):
        assert FollowPath.Feedback(distance_to_goal=2.0, speed=0.5) == trip(feedback, distro)


def test_only_lyrical_has_the_index_of_the_last_reached_pose() -> None:
    result = ComputePathThroughPoses.Result(last_reached_index=2, error_msg="no further")

    assert result == trip(result, "lyrical")
    for distro in ("jazzy", "kilted"):
        assert ComputePathThroughPoses.Result(error_msg="no further") == trip(result, distro)


def test_jazzys_goals_to_plan_through_have_no_header() -> None:
    goal = ComputePathThroughPoses.Goal(goals=Goals(header=Header(frame_id="map"), goals=[THERE]))

    assert ComputePathThroughPoses.Goal(goals=Goals(goals=[THERE])) == trip(goal, "jazzy")


@pytest.mark.parametrize("cls", [ComputeRoute.Result, ComputeAndTrackRoute.Result])
def test_jazzys_routes_fail_with_a_code_alone(cls: Any) -> None:
    assert cls(error_code=405) == trip(cls(error_code=405, error_msg="no route"), "jazzy")


@pytest.mark.parametrize(
    ("goal", "more"),
    [
        (ComputePathToPose.Goal(goal=THERE, planner_id="grid"), {"viapoints": [THERE, THERE]}),
        (FollowPath.Goal(controller_id="FollowPath"), {"path_handler_id": "another"}),
    ],
)
def test_fields_that_only_lyrical_has_are_ignored(goal: Message, more: dict[str, Any]) -> None:
    type_ = message_type(type(goal), "lyrical")
    fields = (replace(field, path=(field.name,)) for field in type_.structure.fields)
    sent = encoder(Structure(type_.name, tuple(fields)))({**goal.__dict__, **more})

    assert goal.model_dump() == type_.decode(sent)


@pytest.mark.parametrize(
    "message",
    [
        SpawnEntity.Request(name="r2", uri="robot", resource_string="{}", entity_namespace="r2", initial_pose=THERE),
        LoadWorld.Request(uri="office", resource_string="{}", ignore_missing_or_unsupported_assets=True),
        Spawnable(uri="robot", description="drives"),
        SetEntityState.Request(entity="r2"),
    ],
    ids=lambda message: message.ros_type,
)
def test_nested_resources_of_lyrical_are_read_without_loss(message: Message) -> None:
    assert message == trip(message, "lyrical")


def test_a_resource_is_nested_at_lyricals_position() -> None:
    request = SpawnEntity.Request(name="r", uri="u", resource_string="s")
    sent = message_type(SpawnEntity.Request, "lyrical").encode(request)

    assert sent.hex().startswith("00010000" + "0200000072000000" + "0200000075000000" + "0200000073000000" + "01000000")
