"""What a result says of an error."""

from __future__ import annotations

from hmrsim.actions import error_of
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait


def test_error_of_nav2():
    """Nav2's results have a text beside the code."""
    assert "no way" == error_of(NavigateToPose.Result(error_code=208, error_msg="no way"))


def test_error_of_moveit():
    """MoveIt's have it inside the code."""
    assert "too far" == error_of(Pickup.Result(error_code=MoveItErrorCodes(val=-1, message="too far")))


def test_no_error():
    """A result without an error says nothing."""
    assert "" == error_of(Wait.Result())
