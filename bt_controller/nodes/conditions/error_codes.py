"""Nav2's conditions about error codes: whether it makes sense to try again."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import INT, INTS, input_port
from bt_controller.nodes import Family
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, FollowPath

if TYPE_CHECKING:
    from collections.abc import Collection

_ERROR_CODE = input_port(INT, "The code; none as long as nobody has written one", required=False)


class AreErrorCodesPresent(Condition):
    """Succeeds if ``error_code`` is one of ``error_codes_to_check``, which are written with ``;`` between them."""

    INPUTS: ClassVar = {"error_code": _ERROR_CODE, "error_codes_to_check": input_port(INTS, "The codes to look for")}

    def update(self) -> Status:
        """Look at the code."""
        return Status.SUCCESS if self.read("error_code") in self.codes() else Status.FAILURE

    def codes(self) -> Collection[int]:
        """Return the codes to look for."""
        codes: list[int] = self.read("error_codes_to_check")
        return codes


class _WouldARecoveryHelp(AreErrorCodesPresent):
    """Succeeds if a recovery could make the code's cause go away."""

    INPUTS: ClassVar = {"error_code": _ERROR_CODE}
    CODES: ClassVar[tuple[int, ...]]

    def codes(self) -> Collection[int]:
        """Return the codes to look for."""
        return self.CODES


class WouldAPlannerRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if the planner found no path, took too long, or doesn't know why it failed."""

    CODES = (
        ComputePathToPose.Result.UNKNOWN,
        ComputePathToPose.Result.TIMEOUT,
        ComputePathToPose.Result.NO_VALID_PATH,
    )


class WouldAControllerRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if the controller lost its patience, made no progress, was blocked, or doesn't know why it failed."""

    CODES = (
        FollowPath.Result.UNKNOWN,
        FollowPath.Result.PATIENCE_EXCEEDED,
        FollowPath.Result.FAILED_TO_MAKE_PROGRESS,
        FollowPath.Result.NO_VALID_CONTROL,
    )


class WouldASmootherRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if the smoother took too long, failed, or smoothed into something; no robot here smooths paths."""

    CODES = (500, 502, 503, 504)


_NODES = (AreErrorCodesPresent, WouldAControllerRecoveryHelp, WouldAPlannerRecoveryHelp, WouldASmootherRecoveryHelp)

FAMILY = Family("error_codes", {node.__name__: node for node in _NODES})
