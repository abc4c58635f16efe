"""Finding the tree that a user names: ``module:function``."""

from __future__ import annotations

import importlib
import inspect
import sys
import traceback
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from py_trees.behaviour import Behaviour

from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType

B = TypeVar("B", bound="Callable[..., Behaviour]")

_CONFIRMED = "bt_confirmed"


class TreeError(HmrsimError):
    """There is no such tree, or it can't be built; the text names it and says what would do."""


@dataclass(frozen=True)
class Plan:
    """How a tree is built, once for each robot.

    Attributes:
        name: As the user wrote it.
        function: Returns the root; takes the robot's name, or nothing.
        takes_robot: Which of the two.
        confirmed: Whether the tree is ticked once more after it has succeeded.
    """

    name: str
    function: Callable[..., object]
    takes_robot: bool
    confirmed: bool

    def build(self, robot: str) -> Behaviour:
        """Return the root of a new tree for this robot.

        Raises:
            TreeError: The function raises an error, or returns something else.
        """
        try:
            root = self.function(robot) if self.takes_robot else self.function()
        except Exception as error:  # whatever the user's code raises
            raise TreeError(f"{self.name}: {described(error)}") from error
        if not isinstance(root, Behaviour):
            raise TreeError(f"{self.name} returned {root!r}; the root of a tree is expected, a py_trees Behaviour")
        return root


def confirmed(function: B) -> B:
    """Mark a tree that shall be ticked once more after it has succeeded.

    That is for a tree which first looks whether its goal is reached: then it says so. Not for one that begins
    again when it is ticked again.
    """
    setattr(function, _CONFIRMED, True)
    return function


def load(name: str) -> Plan:
    """Return the tree that *name* means; modules are looked for in the current folder, too.

    Raises:
        TreeError: There is no such module or function, or it wants other arguments.
    """
    module_name, colon, function_name = name.partition(":")
    if not (module_name and colon and function_name):
        raise TreeError(f"{name!r} is no tree; expected MODULE:FUNCTION, such as bt_controller.examples:go_to_pose")
    module = _import(name, module_name)
    function: Any = getattr(module, function_name, None)
    if function is None:
        instead = _instead(module, function_name)
        raise TreeError(f"{name}: module {module_name!r} has no {function_name!r}{instead}")
    if not callable(function):
        raise TreeError(f"{name} is {function!r}; a function that returns the root of a tree is expected")
    return Plan(name, function, _takes_robot(name, function), bool(getattr(function, _CONFIRMED, False)))


def _import(name: str, module_name: str) -> ModuleType:
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        missing = error.name or ""
        if module_name == missing or module_name.startswith(f"{missing}."):
            raise TreeError(f"{name}: no module {missing!r} here ({here}) or installed") from None
        raise TreeError(f"{name}: {described(error)}") from error
    except Exception as error:
        raise TreeError(f"{name}: {described(error)}") from error


def _instead(module: ModuleType, wanted: str) -> str:
    """Return what the module has that could be meant."""
    found = [
        name
        for name, value in vars(module).items()
        if inspect.isfunction(value) and value.__module__ == module.__name__ and not name.startswith("_")
    ]
    meant = get_close_matches(wanted, found, n=1)
    if meant:
        return f"; did you mean {meant[0]!r}?"
    return f"; it has {', '.join(found)}" if found else ""


def _takes_robot(name: str, function: Callable[..., object]) -> bool:
    """Return whether a function wants the robot's name: *robot* comes first, or something is needed."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        return False
    several = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    needed = [each for each in parameters if each.default is each.empty and each.kind not in several]
    positional = [each for each in parameters if each.kind not in (*several, inspect.Parameter.KEYWORD_ONLY)]
    if len(needed) > 1 or (needed and needed[0] not in positional):
        wanted = ", ".join(each.name for each in needed)
        raise TreeError(f"{name} wants {wanted}; a tree's function takes the robot's name, or nothing")
    return bool(needed) or bool(positional and positional[0].name == "robot")


def described(error: Exception) -> str:
    """Return an error of somebody else's code as one line: what, and where."""
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg} ({error.filename}:{error.lineno})"
    text = f"{type(error).__name__}: {error}".splitlines()[0]
    trace = traceback.extract_tb(error.__traceback__)
    frames = [frame for frame in trace if not frame.filename.startswith("<frozen")]
    return f"{text} ({frames[-1].filename}:{frames[-1].lineno})" if frames else text
