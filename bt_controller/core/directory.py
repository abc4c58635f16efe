"""The robots of a simulator and their actions, and the selectors of robots.

A selector is ``all``, ``type:nurse``, ``action:pickup`` or ``component:claw``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from hmrsim.actions import registry
from hmrsim.diagnostics import instead, meant
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


ALL: Final = "all"

_WHAT: Final[Mapping[str, Callable[[Directory, str], tuple[str, ...]]]] = {
    "type": lambda directory, robot: (directory.types[robot],),
    "action": lambda directory, robot: directory.actions[robot],
    "component": lambda directory, robot: directory.components[robot],
}
"""The attributes of a robot by the word before the colon."""


def check_selector(selector: str) -> None:
    """Check the syntax of a selector.

    Raises:
        ValueError: It is invalid.
    """
    kind, _, wanted = selector.partition(":")
    if selector != ALL and not (kind in _WHAT and wanted):
        forms = ", ".join(f"{kind}:NAME" for kind in _WHAT)
        raise ValueError(f"{selector!r} selects no robots; expected {ALL}, {forms}")


def selected(directory: Directory, selectors: Iterable[str]) -> list[str]:
    """Return the names of the robots that match any of the selectors, each once.

    Raises:
        NotServed: A selector matches no robot; the text lists the valid ones.
    """
    return sorted({robot for selector in selectors for robot in _chosen(directory, selector)})


def completions(directory: Directory) -> list[str]:
    """Return all selectors that match a robot."""
    found = {f"{kind}:{name}" for kind in _WHAT for name in _names(directory, kind)}
    return [ALL, *sorted(found)]


def _chosen(directory: Directory, selector: str) -> list[str]:
    if selector == ALL:
        if not directory.actions:
            raise NotServed("there are no robots")
        return list(directory.actions)
    kind, _, wanted = selector.partition(":")
    chosen = [robot for robot in directory.actions if wanted in _WHAT[kind](directory, robot)]
    if not chosen:
        names = _names(directory, kind)
        alike = meant(wanted, names)
        hint = f"; did you mean {kind}:{alike}?" if alike else instead(wanted, names)
        raise NotServed(f"no robot has {kind} {wanted!r}{hint}")
    return chosen


def _names(directory: Directory, kind: str) -> list[str]:
    return sorted({name for robot in directory.actions for name in _WHAT[kind](directory, robot)} - {""})
