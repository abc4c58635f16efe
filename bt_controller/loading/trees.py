"""Loading of the tree that a user names: a file of BehaviorTree.CPP, or ``module:function``."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeVar

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard

from bt_controller.errors import TreeError
from bt_controller.loading.named_functions import find_function
from hmrsim.program.users_code import described

B = TypeVar("B", bound="Callable[..., Behaviour]")

_CONFIRMED = "bt_confirmed"
_RESUMABLE = "bt_resumable"

_NOTHING: Final[Mapping[str, str]] = MappingProxyType({})
_ROBOT, _ROBOTS = "robot", "robots"
_TREE: Final = (
    "tree; expected FILE.xml, MODULE:FUNCTION (bt_controller.examples:go_to_pose) or FILE.py:FUNCTION(NAME=VALUE, …)"
)


@dataclass(frozen=True)
class Plan:
    """A tree that can be built, once for each robot.

    Attributes:
        name: The name that the user gave.
        function: Returns the root; takes the robot's name, the names of all robots, or nothing.
        confirmed: Whether the tree is ticked once more after it has succeeded.
        takes_robots: Whether it is one tree for all robots, and the function takes the list of their names.
        values: The initial texts on each blackboard.
        resumable: Whether a restarted controller resumes the tree.
        unset: A line for each required port that nothing writes, as far as that is known.
        doubts: A line for each warning.
        files: The files that it was read from.
    """

    name: str
    function: Callable[..., object]
    takes_robot: bool
    confirmed: bool
    takes_robots: bool = False
    values: Mapping[str, str] = field(default_factory=dict)
    resumable: bool = False
    unset: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    files: tuple[str, ...] = ()

    def build(self, *robots: str) -> Behaviour:
        """Return the root of a new tree for a robot or for all; the function can read the values, but not change them.

        Raises:
            TreeError: The function raises an error, or returns something else.
        """
        self._set_values()
        try:
            if self.takes_robots:
                root = self.function(list(robots))
            else:
                root = self.function(*robots) if self.takes_robot else self.function()
        except Exception as error:  # whatever the user's code raises
            raise TreeError(f"{self.name}: {described(error)}") from error
        if not isinstance(root, Behaviour):
            raise TreeError(f"{self.name} returned {root!r}; expected the root of a tree, a py_trees Behaviour")
        self._set_values()
        return root

    def _set_values(self) -> None:
        for key, text in self.values.items():
            Blackboard.set(key, text)


def confirmed(function: B) -> B:
    """Mark a tree that is ticked once more after it has succeeded.

    Use it for a tree that first checks whether its goal is reached, not for one that starts over when it is ticked.
    """
    setattr(function, _CONFIRMED, True)
    return function


def resumable(function: B) -> B:
    """Mark a tree that a restarted controller resumes under the tree's name, as with ``--resume``.

    Don't use it for a tree that runs repeatedly in one simulation, as completed steps are not repeated.
    """
    setattr(function, _RESUMABLE, True)
    return function


def load(
    name: str, *, tree: str | None = None, nodes: Sequence[str] = (), values: Mapping[str, str] = _NOTHING
) -> Plan:
    """Return a tree; modules are also searched in the current folder.

    Args:
        name: The path of an XML file, MODULE:FUNCTION or FILE.py:FUNCTION, optionally with arguments:
            ``missions.py:deliver(code=7)``.
        tree: The ID of the file's tree to run; by default the file's main tree.
        nodes: Modules with further nodes for files.
        values: The initial texts on each robot's blackboard.

    Raises:
        TreeError: The file, module or function does not exist or is invalid.
    """
    if _is_xml(name):
        # A tree in Python does not need all nodes, which take 100 ms to load.
        from bt_controller.loading.file_tree import load_file, vocabulary  # noqa: PLC0415

        known = vocabulary(nodes)
        found, unset, doubts = load_file(name, known, tree=tree, values=values)
        files = (*found.files, *(path for module in nodes if (path := sys.modules[module].__file__)))
        return Plan(
            name,
            found.build,
            takes_robot=False,
            confirmed=False,
            values=values,
            unset=unset,
            doubts=doubts,
            files=files,
        )
    found_function = find_function(name, _TREE)
    if tree is not None or nodes:
        raise TreeError(f"{name} is not an XML file; --tree and --nodes apply to XML files only")
    return plan_of(
        found_function.function,
        name,
        values=values,
        arguments=found_function.arguments,
        files=found_function.files,
    )


def plan_of(
    function: Callable[..., object],
    name: str,
    *,
    values: Mapping[str, str] = _NOTHING,
    arguments: Mapping[str, Any] = _NOTHING,
    files: tuple[str, ...] = (),
) -> Plan:
    """Return the tree that a function builds.

    Args:
        function: Returns the root; takes the robot's name as *robot*, the names of all as *robots*, or nothing.
        name: The tree's name.
        values: The initial texts on each robot's blackboard.
        arguments: The function's arguments other than the robots.
        files: The files that the tree was read from.

    Raises:
        TreeError: The function takes other arguments.
    """
    applied = partial(function, **arguments) if arguments else function
    first = _first_parameter(name, applied)
    return Plan(
        name,
        applied,
        takes_robot=first == _ROBOT,
        confirmed=bool(getattr(function, _CONFIRMED, False)),
        takes_robots=first == _ROBOTS,
        values=values,
        resumable=bool(getattr(function, _RESUMABLE, False)),
        files=files,
    )


def _is_xml(name: str) -> bool:
    """Return whether a name is that of an XML file, by its suffix or its first characters."""
    if name.lower().endswith(".xml"):
        return True
    path = Path(name)
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(64).lstrip().startswith(b"<")
    except (OSError, ValueError):
        return False


def _first_parameter(name: str, function: Callable[..., object]) -> str:
    """Return which names a function takes: ``robot`` for one, ``robots`` for all, or an empty string for none."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        return ""
    several = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    needed = [each for each in parameters if each.default is each.empty and each.kind not in several]
    positional = [each for each in parameters if each.kind not in (*several, inspect.Parameter.KEYWORD_ONLY)]
    if len(needed) > 1 or (needed and needed[0] not in positional):
        wanted = ", ".join(each.name for each in needed)
        raise TreeError(f"{name} requires {wanted}; a tree's function takes the robot's name, or nothing")
    if positional and positional[0].name in (_ROBOT, _ROBOTS):
        return positional[0].name
    return _ROBOT if needed else ""
