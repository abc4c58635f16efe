"""The robots of a simulator and their actions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from hmrsim.actions import registry
from hmrsim.diagnostics import instead
from hmrsim.errors import HmrsimError


class NotServed(HmrsimError):
    """The simulator has no such robot, or the robot no such action; the text lists those that exist."""


@dataclass(frozen=True)
class Directory:
    """The robots in the simulator's ``_world/info``.

    Attributes:
        actions: By robot, the names of its actions.
        aliases: Further names of actions, ``a/b`` to ``robot/action``.
        types: By robot, its type.
        components: By robot, the names of its components, such as ``claw``.
    """

    actions: Mapping[str, tuple[str, ...]]
    aliases: Mapping[str, str]
    types: Mapping[str, str]
    components: Mapping[str, tuple[str, ...]]

    @classmethod
    def from_info(cls, info: Mapping[str, Any]) -> Directory:
        """Return the robots of the simulator's description."""
        robots = {robot["name"]: robot for robot in info.get("robots", ())}
        return cls(
            actions={name: tuple(robot.get("actions", ())) for name, robot in robots.items()},
            aliases=dict(info.get("aliases", {})),
            types={name: robot.get("type", "") for name, robot in robots.items()},
            components={name: tuple(robot.get("components", ())) for name, robot in robots.items()},
        )

    def check_robot(self, robot: str) -> None:
        """Check that a robot exists.

        Raises:
            NotServed: There is no such robot.
        """
        if robot not in self.actions:
            raise NotServed(f"no robot {robot!r}{_instead(robot, self.actions)}")

    def resolve(self, robot: str, action: str) -> tuple[str, str]:
        """Return robot and action for a leaf's action name.

        *action* is a name, or a full name ``robot/action`` or an alias of that; then *robot* doesn't count.

        Raises:
            NotServed: There is no such robot, or it has no such action.
        """
        if "/" in action:
            name = action.strip("/")
            robot, _, action = self.aliases.get(name, name).partition("/")
        self.check_robot(robot)
        if action not in self.actions[robot]:
            known = registry().get(action)
            needs = f", which needs the component {known.component!r}" if known and known.component else ""
            raise NotServed(f"robot {robot!r} has no action {action!r}{needs}{_instead(action, self.actions[robot])}")
        return robot, action


def _instead(wanted: str, names: Iterable[str]) -> str:
    return instead(wanted, sorted(names))
