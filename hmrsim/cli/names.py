"""ROS names, such as ``/mocha/odom``, and their topics, actions and services in a running simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.actions import registry
from hmrsim.cli.exits import UnknownName, WrongUse
from hmrsim.diagnostics import instead
from hmrsim.protocol.goal import WORLD

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction

Info = dict[str, Any]
"""The message of ``_world/info``."""


@dataclass(frozen=True)
class ActionName:
    """An action of a robot, and the name by which it was requested.

    Attributes:
        name: Such as ``/mocha/pickup``, or an alias such as ``/mocha/grab``.
    """

    name: str
    robot: str
    action: str

    @property
    def ros_type(self) -> str:
        """The ROS name of the action; empty for an action that is not installed here."""
        known = registry().get(self.action)
        return known.ros_type if known else ""

    def definition(self) -> AnyAction:
        """Return the action.

        Raises:
            UnknownName: The simulator has it, but it is not installed here.
        """
        known = registry().get(self.action)
        if known is None:
            raise UnknownName(f"action {self.action!r} is not installed here; there are: {', '.join(registry())}")
        return known


def robots(info: Info) -> dict[str, list[str]]:
    """Return the names of each robot's actions."""
    return {robot["name"]: list(robot.get("actions", ())) for robot in info.get("robots", ())}


def aliases(info: Info) -> Mapping[str, str]:
    """Return the further names of actions: alias to ``robot/action``."""
    found: Mapping[str, str] = info.get("aliases", {})
    return found


def _owners(info: Info) -> dict[str, list[str]]:
    """Return the names of the actions of each robot, and of the world if it has any."""
    of_world = list(info.get("actions", ()))
    return robots(info) | ({WORLD: of_world} if of_world else {})


def actions(info: Info) -> Iterator[ActionName]:
    """Yield all names of all actions: the robots', the world's, and aliases."""
    for robot, names in _owners(info).items():
        for name in names:
            yield ActionName(f"/{robot}/{name}", robot, name)
    for alias, target in aliases(info).items():
        robot, _, action = target.partition("/")
        yield ActionName(f"/{alias}", robot, action)


def find_action(info: Info, name: str) -> ActionName:
    """Return the action that a name or an alias stands for.

    Raises:
        WrongUse: *name* is not two words with a slash between.
        UnknownName: There is no such robot or action.
    """
    first, second = split(name)
    robot, _, action = aliases(info).get(f"{first}/{second}", f"{first}/{second}").partition("/")
    there = _owners(info)
    if robot not in there:
        raise UnknownName(f"no robot {robot!r}{instead(robot, robots(info), verb='there are:')}")
    if action not in there[robot]:
        known = registry().get(action)
        if known is not None and known.component is not None:
            raise UnknownName(f"{robot} has no action {action!r}, which needs the component {known.component!r}")
        raise UnknownName(f"{robot} has no action {action!r}{instead(action, there[robot], verb='it has:')}")
    return ActionName(f"/{first}/{second}", robot, action)


def split(name: str) -> tuple[str, str]:
    """Return the two words of a name; the slash before the first may be left out.

    Raises:
        WrongUse: *name* has another form.
    """
    first, slash, second = name.removeprefix("/").partition("/")
    if not (first and slash and second) or "/" in second:
        raise WrongUse(f"{name!r} is not an action's name; expected /ROBOT/ACTION, such as /mocha/navigate_to_pose")
    return first, second
