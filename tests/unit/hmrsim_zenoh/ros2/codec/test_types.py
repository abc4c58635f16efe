"""Types of messages, services and actions: names, hashes, sharing and lazy creation."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import hmrsim
from hmrsim.actions import registry
from hmrsim.interfaces.action_msgs import CancelGoal
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim_zenoh.ros2.codec.types import DISTROS, ActionType, action_type, message_type, service_type

MAKE_ALL = """
from hmrsim_zenoh.ros2.codec.decoder import decoder
from hmrsim_zenoh.ros2.codec.encoder import encoder
from hmrsim_zenoh.ros2.codec.types import action_type
from hmrsim.actions import registry
action = action_type(registry()["pickup"])
print(action.send_goal.hash, encoder.cache_info().currsize, decoder.cache_info().currsize)
"""


def navigate_to_pose(distro: str = "kilted") -> ActionType:
    """Return the type of the most used action."""
    return action_type(registry()["navigate_to_pose"], distro)


def navigate_through_poses(distro: str) -> ActionType:
    """Return the type of an action that differs in each distribution."""
    return action_type(registry()["navigate_through_poses"], distro)


def test_action() -> None:
    """An action is three services and two topics."""
    type_ = navigate_to_pose()
    parts = (type_.send_goal, type_.cancel_goal, type_.get_result, type_.feedback, type_.status)

    assert [part.dds_name for part in parts] == [
        "nav2_msgs::action::dds_::NavigateToPose_SendGoal_",
        "action_msgs::srv::dds_::CancelGoal_",
        "nav2_msgs::action::dds_::NavigateToPose_GetResult_",
        "nav2_msgs::action::dds_::NavigateToPose_FeedbackMessage_",
        "action_msgs::msg::dds_::GoalStatusArray_",
    ]


def test_same_in_distributions_that_agree() -> None:
    """Distributions that have the same types have the same objects."""
    assert navigate_to_pose("jazzy") is navigate_to_pose("kilted")


def test_parts_are_the_same_where_they_agree() -> None:
    """If one part of an action differs, the others are the same objects."""
    kilted, lyrical = navigate_to_pose("kilted"), navigate_to_pose("lyrical")

    assert [
        kilted.send_goal is lyrical.send_goal,
        kilted.get_result is lyrical.get_result,
        kilted.feedback is lyrical.feedback,
    ] == [True, True, False]


def test_cancellation_is_the_same_for_all() -> None:
    """All actions are canceled in the same way."""
    cancel = service_type(CancelGoal)

    assert navigate_to_pose().cancel_goal is cancel


@pytest.mark.parametrize(("part", "expected"), [("send_goal", 2), ("get_result", 2), ("feedback", 3)])
def test_distinct_types(part: str, expected: int) -> None:
    """There are as many types of a part as hashes."""
    parts = {getattr(navigate_through_poses(distro), part) for distro in DISTROS}

    assert expected == len(parts) == len({each.hash for each in parts})


def test_unknown_distribution() -> None:
    """The error lists the supported distributions."""
    with pytest.raises(ValueError, match="no distribution 'humble'; there are jazzy, kilted, lyrical, rolling"):
        message_type(Time, "humble")


def test_codec_is_made_once() -> None:
    """Each access returns the same function."""
    assert message_type(Time).encode is message_type(Time).encode


def test_codecs_are_made_when_asked_for() -> None:
    """Names and hashes compile no codec, so that a simulator with many actions starts fast."""
    root = Path(hmrsim.__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", MAKE_ALL], cwd=root, capture_output=True, text=True, check=True)

    assert done.stdout == "RIHS01_631fbd69b6e4dbd7399bc23e436548747e8ba3aa1ba37c9251bec4b9fd7181a8 0 0\n"
