"""What other distributions have other than kilted: what we send them, and what we read of what they send."""

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
    """Return what is left of a message after a trip through a distribution's bytes."""
    type_ = message_type(type(message), distro)
    return type(message).model_validate(type_.decode(type_.encode(message)))


@pytest.mark.parametrize("cls", [BackUp.Goal, DriveOnHeading.Goal, Spin.Goal])
def test_jazzy_has_no_word_for_collision_checks(cls: Any) -> None:
    """Jazzy's behaviours always check for collisions: the field is left out, and false."""
    sent = message_type(cls, "jazzy").encode(cls())

    assert len(message_type(cls, "kilted").encode(cls())) - 1 == len(sent)
    assert not trip(cls(disable_collision_checks=True), "jazzy").disable_collision_checks


def test_jazzy_has_poses_without_a_header() -> None:
    """Jazzy's poses to drive through are a list: what kilted's header says is not said."""
    goal = NavigateThroughPoses.Goal(poses=Goals(header=Header(frame_id="map"), goals=[THERE]))

    assert NavigateThroughPoses.Goal(poses=Goals(goals=[THERE])) == trip(goal, "jazzy")


def test_poses_of_jazzy() -> None:
    """What jazzy sends as a list of poses is read as the goals of kilted."""
    data = bytes.fromhex("00010000" + "00000000" + "01000000" + "00")

    assert message_type(NavigateThroughPoses.Goal, "jazzy").decode(data) == {
        "poses": {"goals": []},
        "behavior_tree": "",
    }


@pytest.mark.parametrize("cls", [NavigateThroughPoses.Result, NavigateThroughPoses.Feedback])
def test_jazzy_has_no_status_of_waypoints(cls: Any) -> None:
    """Jazzy's NavigateThroughPoses has no status of each waypoint."""
    assert cls() == trip(cls(waypoint_statuses=[WaypointStatus(waypoint_index=1)]), "jazzy")


def test_jazzy_has_missed_waypoints() -> None:
    """Jazzy's result has the missed waypoint, where it was, and the code."""
    missed = WaypointStatus(
        waypoint_status=3, waypoint_index=7, waypoint_pose=THERE, error_code=208, error_msg="no path"
    )

    assert FollowWaypoints.Result(
        missed_waypoints=[WaypointStatus(waypoint_index=7, waypoint_pose=THERE, error_code=208)]
    ) == trip(FollowWaypoints.Result(missed_waypoints=[missed]), "jazzy")


def test_missed_waypoint_has_another_name() -> None:
    """Jazzy's type of a missed waypoint has a name of its own, and names of its own in it."""
    described = message_type(WaypointStatus, "jazzy").structure

    assert (described.name, [field.name for field in described.fields]) == (
        "nav2_msgs/msg/MissedWaypoint",
        ["index", "goal", "error_code"],
    )


def test_lyrical_has_tracking_errors_of_zero() -> None:
    """Lyrical's feedback ends in two errors more, which are zero: our robots keep to their paths."""
    feedback = NavigateToPose.Feedback(distance_remaining=2.0)
    kilted = message_type(NavigateToPose.Feedback, "kilted").encode(feedback)

    assert kilted + bytes(8) == message_type(NavigateToPose.Feedback, "lyrical").encode(feedback)


def test_errors_of_lyrical_come_before_the_poses() -> None:
    """Lyrical's feedback on the drive through poses has the errors before the poses that remain."""
    fields = message_type(NavigateThroughPoses.Feedback, "lyrical").structure.fields

    assert [field.name for field in fields][4:] == [
        "distance_remaining",
        "position_tracking_error",
        "heading_tracking_error",
        "number_of_poses_remaining",
        "waypoint_statuses",
    ]


def test_only_lyrical_tells_how_a_path_is_kept_to() -> None:
    """Lyrical's feedback on a path is one message, with what the others have in it; they have those fields alone."""
    tracking = TrackingFeedback(distance_to_goal=1.0, speed=0.5, current_path_index=3)
    feedback = FollowPath.Feedback(distance_to_goal=2.0, speed=0.5, tracking_feedback=tracking)

    assert FollowPath.Feedback(tracking_feedback=tracking) == trip(feedback, "lyrical")
    for distro in ("jazzy", "kilted"):
        assert FollowPath.Feedback(distance_to_goal=2.0, speed=0.5) == trip(feedback, distro)


def test_only_lyrical_tells_how_far_a_partial_path_leads() -> None:
    """Lyrical's result of a path through poses has the index of the last pose that it reaches."""
    result = ComputePathThroughPoses.Result(last_reached_index=2, error_msg="no further")

    assert result == trip(result, "lyrical")
    for distro in ("jazzy", "kilted"):
        assert ComputePathThroughPoses.Result(error_msg="no further") == trip(result, distro)


def test_jazzy_has_goals_to_plan_through_without_a_header() -> None:
    """Jazzy's poses to plan through are a list, as those to drive through."""
    goal = ComputePathThroughPoses.Goal(goals=Goals(header=Header(frame_id="map"), goals=[THERE]))

    assert ComputePathThroughPoses.Goal(goals=Goals(goals=[THERE])) == trip(goal, "jazzy")


@pytest.mark.parametrize("cls", [ComputeRoute.Result, ComputeAndTrackRoute.Result])
def test_jazzy_has_no_text_for_a_route_that_fails(cls: Any) -> None:
    """Jazzy's route actions have the code alone."""
    assert cls(error_code=405) == trip(cls(error_code=405, error_msg="no route"), "jazzy")


@pytest.mark.parametrize(
    ("goal", "more"),
    [
        (ComputePathToPose.Goal(goal=THERE, planner_id="grid"), {"viapoints": [THERE, THERE]}),
        (FollowPath.Goal(controller_id="FollowPath"), {"path_handler_id": "another"}),
    ],
)
def test_what_only_lyrical_says(goal: Message, more: dict[str, Any]) -> None:
    """What lyrical says of via points and path handlers is read over."""
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
def test_resources_of_lyrical(message: Message) -> None:
    """Where lyrical nests a resource, our messages have its fields, and nothing is lost."""
    assert message == trip(message, "lyrical")


def test_resource_is_nested() -> None:
    """A resource is where lyrical has it, among the other fields."""
    request = SpawnEntity.Request(name="r", uri="u", resource_string="s")
    sent = message_type(SpawnEntity.Request, "lyrical").encode(request)

    assert sent.hex().startswith("00010000" + "0200000072000000" + "0200000075000000" + "0200000073000000" + "01000000")
