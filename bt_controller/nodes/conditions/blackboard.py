"""Conditions on the blackboard: BehaviorTree.CPP's scripts and updates of entries, Nav2's error codes."""

from __future__ import annotations

from collections.abc import Collection
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import ANY, INT, INTS, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.poses import Watching
from bt_controller.scripting.scripted import Scripted
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, ComputeRoute, FollowPath, SmoothPath


class ScriptCondition(Scripted, Condition):
    """Runs a script; succeeds if its value is true, and fails otherwise."""

    SCRIPTS: ClassVar = ("code",)

    def update(self) -> Status:
        """Run the script."""
        return Status.SUCCESS if self.holds("code") else Status.FAILURE


class WasEntryUpdated(Watching, Condition):
    """Succeeds if an entry was written since the last tick, even with the same value; else fails."""

    INPUTS: ClassVar = {"entry": input_port(ANY, "Key of the entry, with or without braces")}

    def update(self) -> Status:
        """Check the entry."""
        return Status.SUCCESS if self.updated() else Status.FAILURE


_ERROR_CODE = input_port(INT, "The error code; none before one is written", required=False)


class AreErrorCodesPresent(Condition):
    """Succeeds if ``error_code`` is one of ``error_codes_to_check``, which are separated by ``;``."""

    INPUTS: ClassVar = {"error_code": _ERROR_CODE, "error_codes_to_check": input_port(INTS, "The codes to look for")}

    def update(self) -> Status:
        """Check the code."""
        return Status.SUCCESS if self.read("error_code") in self.codes() else Status.FAILURE

    def codes(self) -> Collection[int]:
        """Return the codes to look for."""
        codes: list[int] = self.read("error_codes_to_check")
        return codes


class _WouldARecoveryHelp(AreErrorCodesPresent):
    """Succeeds if a recovery may remove the cause of the error; ``error_codes_to_check`` replaces the codes of that."""

    INPUTS: ClassVar = {
        "error_code": _ERROR_CODE,
        "error_codes_to_check": input_port(INTS, "Other codes to look for", required=False),
    }
    CODES: ClassVar[tuple[int, ...]]

    def codes(self) -> Collection[int]:
        """Return the codes to look for."""
        given: list[int] | None = self.read("error_codes_to_check")
        return self.CODES if given is None else given


class WouldAPlannerRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if the planner found no path, timed out, or failed for an unknown reason."""

    CODES = (
        ComputePathToPose.Result.UNKNOWN,
        ComputePathToPose.Result.TIMEOUT,
        ComputePathToPose.Result.NO_VALID_PATH,
    )


class WouldAControllerRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if the controller ran out of patience, made no progress, was blocked, or failed without a reason."""

    CODES = (
        FollowPath.Result.UNKNOWN,
        FollowPath.Result.PATIENCE_EXCEEDED,
        FollowPath.Result.FAILED_TO_MAKE_PROGRESS,
        FollowPath.Result.NO_VALID_CONTROL,
    )


class WouldASmootherRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if the smoother timed out, failed, or found a collision."""

    CODES = (
        SmoothPath.Result.UNKNOWN,
        SmoothPath.Result.TIMEOUT,
        SmoothPath.Result.SMOOTHED_PATH_IN_COLLISION,
        SmoothPath.Result.FAILED_TO_SMOOTH_PATH,
    )


class WouldARouteRecoveryHelp(_WouldARecoveryHelp):
    """Succeeds if there was no route, or its search timed out or failed for an unknown reason."""

    CODES = (ComputeRoute.Result.UNKNOWN, ComputeRoute.Result.TIMEOUT, ComputeRoute.Result.NO_VALID_ROUTE)


FAMILY = Family.of_module(__name__)
