"""Nav2's actions that move the robot, the nodes that cancel them, and actions without an effect in this simulator.

Lengths and speeds are in the world's unit of length; times are simulated seconds.

There are no costmaps, no particles and no collision monitor. There is one planner, one controller and so on, and no
topic to select others: selectors write their defaults.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.action_node import ACTION_INPUTS, ActionNode
from bt_controller.core.node import Leaf
from bt_controller.core.ports import (
    BOOL,
    CONTROLLER,
    DOUBLE,
    FINITE,
    PLANNER,
    POSE,
    POSES,
    STRING,
    input_port,
    output_port,
)
from bt_controller.core.robots import Directory
from bt_controller.nodes import Family
from hmrsim.actions import registry
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point

if TYPE_CHECKING:
    from bt_controller.core.ports import Port
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.action_client import ActionClient


_TREE = input_port(STRING, "Sent with the goal and ignored: simulated robots have no trees", default="")


class NavigateToPose(ActionNode):
    """Drives to ``goal`` along the lanes."""

    ACTION = "navigate_to_pose"
    FIELDS: ClassVar = {"goal": "pose"}
    INPUTS: ClassVar = {**ACTION_INPUTS, "goal": input_port(POSE, "Destination"), "behavior_tree": _TREE}


class NavigateThroughPoses(ActionNode):
    """Drives through ``goals`` to the last of them."""

    ACTION = "navigate_through_poses"
    FIELDS: ClassVar = {"goals": "poses"}
    INPUTS: ClassVar = {**ACTION_INPUTS, "goals": input_port(POSES, "Destinations in order"), "behavior_tree": _TREE}


_MANEUVER_INPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        **ACTION_INPUTS,
        "time_allowance": input_port(FINITE, "Time limit in seconds; 0 for none", default=10.0),
        "disable_collision_checks": input_port(BOOL, "Sent with the goal", default=False),
        "is_recovery": input_port(BOOL, "Ignored: recoveries are not counted", default=True),
    }
)


class Spin(ActionNode):
    """Turns in place by an angle."""

    ACTION = "spin"
    FIELDS: ClassVar = {"spin_dist": "target_yaw"}
    INPUTS: ClassVar = {**_MANEUVER_INPUTS, "spin_dist": input_port(FINITE, "Angle in radians", default=1.57)}


class Wait(ActionNode):
    """Stands still for the absolute value of the duration, as in Nav2."""

    ACTION = "wait"
    INPUTS: ClassVar = {**ACTION_INPUTS, "wait_duration": input_port(FINITE, "Duration in seconds", default=1.0)}

    def goal(self) -> Message:
        """Return the goal of the input ports."""
        return self.goal_with(time=Duration.from_seconds(abs(self.read("wait_duration"))))


class BackUp(ActionNode):
    """Drives straight back for a distance."""

    ACTION = "back_up"
    FIELDS: ClassVar = {"backup_speed": "speed"}
    INPUTS: ClassVar = {
        **_MANEUVER_INPUTS,
        "backup_dist": input_port(FINITE, "Distance", default=0.15),
        "backup_speed": input_port(FINITE, "Speed", default=0.025),
    }

    def goal(self) -> Message:
        """Return the goal of the input ports."""
        return self.goal_with(target=Point(x=self.read("backup_dist")))


class DriveOnHeading(ActionNode):
    """Drives straight ahead for a distance."""

    ACTION = "drive_on_heading"
    INPUTS: ClassVar = {
        **_MANEUVER_INPUTS,
        "dist_to_travel": input_port(FINITE, "Distance", default=0.15),
        "speed": input_port(FINITE, "Speed", default=0.025),
    }

    def goal(self) -> Message:
        """Return the goal of the input ports."""
        return self.goal_with(target=Point(x=self.read("dist_to_travel")))


class _Cancel(Leaf):
    """Cancels all goals of an action; succeeds when the robot answers, which in lockstep it does not wait for."""

    ACTION: ClassVar[str]
    """The name of the action."""

    INPUTS: ClassVar = ACTION_INPUTS

    def setup(self, **kwargs: Any) -> None:
        """Look up the action, by the name that the file gives it.

        Raises:
            NotServed: There is no such robot, or it has no such action.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        directory = kwargs.get("directory") or Directory.from_info(kwargs["client"].info())
        robot, action = directory.resolve(kwargs["robot"], self.read("server_name") or self.ACTION)
        self._client: ActionClient[Any, Any, Any] = kwargs["client"].action_client(robot, registry()[action])

    def update(self) -> Status:
        """Cancel all goals, including those that were sent in this tick."""
        try:
            self._client.cancel_all()
        except HmrsimError as error:
            self.feedback_message = str(error)
            return Status.FAILURE
        return Status.SUCCESS


_CANCELED: Final = {
    "CancelBackUp": ("back_up", "BackUp"),
    "CancelComputeAndTrackRoute": ("compute_and_track_route", "ComputeAndTrackRoute"),
    "CancelControl": ("follow_path", "FollowPath"),
    "CancelDriveOnHeading": ("drive_on_heading", "DriveOnHeading"),
    "CancelSpin": ("spin", "Spin"),
    "CancelWait": ("wait", "Wait"),
}
"""The action that a node cancels, and the node that sends its goals."""


def _cancel(tag: str) -> type[_Cancel]:
    """Return the node that cancels the goals of an action."""
    action, sender = _CANCELED[tag]
    doc = f"Cancels all goals of `{sender}` nodes."
    return type(tag, (_Cancel,), {"__doc__": doc, "__module__": __name__, "ACTION": action})


_NOT_NEEDED = "Ignored"

_KINDS = {"planner": PLANNER, "controller": CONTROLLER}

_SERVICE: Mapping[str, Port] = {
    "service_name": input_port(STRING, _NOT_NEEDED, required=False),
    "server_timeout": input_port(DOUBLE, _NOT_NEEDED, required=False),
}


_CLEARING: Mapping[str, Port] = {**_SERVICE, "plugins": input_port(STRING, _NOT_NEEDED, required=False)}


class _NoOp(Leaf):
    """A node that has no effect in this simulator, and succeeds."""

    INPUTS: ClassVar = _SERVICE

    def update(self) -> Status:
        """Succeed, with a message that the node has no effect."""
        self.feedback_message = "no effect in this simulator"
        return Status.SUCCESS


class ClearEntireCostmap(_NoOp):
    """There is no costmap to clear."""

    INPUTS: ClassVar = _CLEARING


class ClearCostmapExceptRegion(_NoOp):
    """There is no costmap to clear."""

    INPUTS: ClassVar = {**_CLEARING, "reset_distance": input_port(DOUBLE, _NOT_NEEDED, default=1.0)}


class ClearCostmapAroundRobot(ClearCostmapExceptRegion):
    """There is no costmap to clear."""


class ClearCostmapAroundPose(_NoOp):
    """There is no costmap to clear."""

    INPUTS: ClassVar = {
        **ClearCostmapExceptRegion.INPUTS,
        "pose": input_port(POSE, _NOT_NEEDED, required=False),
    }


class ReinitializeGlobalLocalization(_NoOp):
    """Simulated robots are always localized."""


class ToggleCollisionMonitor(_NoOp):
    """There is no collision monitor."""

    INPUTS: ClassVar = {**_SERVICE, "enable": input_port(BOOL, _NOT_NEEDED, default=True)}


class _Selector(Leaf):
    """Writes its default to the output port; fails without a default, as Nav2's selectors do before any selection."""

    WHAT: ClassVar[str]

    def update(self) -> Status:
        """Write the default."""
        choice = self.read(f"default_{self.WHAT}")
        if not choice:
            self.feedback_message = f"there is no default_{self.WHAT} and no selection topic"
            return Status.FAILURE
        self.write(f"selected_{self.WHAT}", choice)
        return Status.SUCCESS


_SELECTORS: Final = ("controller", "goal_checker", "path_handler", "planner", "progress_checker", "smoother")


def _selector(chosen: str) -> type[_Selector]:
    """Return the selector of a planner, a controller, and so on."""
    tag = f"{chosen.title().replace('_', '')}Selector"
    return type(
        tag,
        (_Selector,),
        {
            "__doc__": f"Selects the {chosen.replace('_', ' ')}.",
            "__module__": __name__,
            "WHAT": chosen,
            "INPUTS": {
                "topic_name": input_port(STRING, "Ignored: there is no selection topic", required=False),
                f"default_{chosen}": input_port(_KINDS.get(chosen, STRING), "The default", default=""),
            },
            "OUTPUTS": {f"selected_{chosen}": output_port(STRING, "The selection")},
        },
    )


FAMILY = Family.of_module(__name__, *map(_cancel, _CANCELED), *map(_selector, _SELECTORS))
