"""Nav2's actions that have no effect in this simulator: they succeed at once.

There are no costmaps, no particles and no collision monitor. There is one planner, one controller and so on, and no
topic to select others: selectors write their defaults.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.ports import BOOL, CONTROLLER, DOUBLE, PLANNER, POSE, STRING, input_port, output_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from bt_controller.core.ports import Port

_NOT_NEEDED = "Ignored"

_KINDS = {"planner": PLANNER, "controller": CONTROLLER}

_SERVICE: Mapping[str, Port] = {
    "service_name": input_port(STRING, _NOT_NEEDED, required=False),
    "server_timeout": input_port(DOUBLE, _NOT_NEEDED, required=False),
}


_CLEARING: Mapping[str, Port] = {**_SERVICE, "plugins": input_port(STRING, _NOT_NEEDED, required=False)}


class _NoOp(Leaf):
    """Succeeds."""

    INPUTS: ClassVar = _SERVICE

    def update(self) -> Status:
        """Succeed."""
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


def _selector(tag: str, chosen: str) -> type[_Selector]:
    """Return the selector of a planner, a controller, and so on."""
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


FAMILY = Family.of(
    "no_ops",
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    ReinitializeGlobalLocalization,
    ToggleCollisionMonitor,
    _selector("ControllerSelector", "controller"),
    _selector("GoalCheckerSelector", "goal_checker"),
    _selector("PathHandlerSelector", "path_handler"),
    _selector("PlannerSelector", "planner"),
    _selector("ProgressCheckerSelector", "progress_checker"),
    _selector("SmootherSelector", "smoother"),
)
