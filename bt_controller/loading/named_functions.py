"""Functions that a user names: ``MODULE:FUNCTION`` or ``FILE.py:FUNCTION``, with parameters if wanted."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.errors import TreeError
from bt_controller.imports import imported, imported_file
from hmrsim.diagnostics import instead, shown

if TYPE_CHECKING:
    from types import ModuleType

_FUNCTION: Final = "function; expected MODULE:FUNCTION or FILE.py:FUNCTION(NAME=VALUE, …)"


@dataclass(frozen=True)
class NamedFunction:
    """A function that was found by its name.

    Attributes:
        name: As the user wrote it.
        function: The function itself.
        arguments: What the user wants it to be called with.
        files: Where it comes from.
    """

    name: str
    function: Callable[..., Any]
    arguments: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    files: tuple[str, ...] = ()

    @property
    def applied(self) -> Callable[..., Any]:
        """The function with its arguments."""
        return partial(self.function, **self.arguments) if self.arguments else self.function

    def called_with(self, arguments: Mapping[str, Any]) -> NamedFunction:
        """Return the same function with further arguments, which take the place of those of the same names.

        Raises:
            TreeError: It does not take them.
        """
        if not arguments:
            return self
        _check_arguments(self.name, self.function, arguments)
        return replace(self, arguments={**self.arguments, **arguments})


def find_function(name: str, what: str = _FUNCTION) -> NamedFunction:
    """Return the function of a name; modules are searched in the current folder, too.

    Args:
        name: As in ``missions:patrol``, ``missions.py:patrol`` or ``missions.py:deliver(code=7)``.
        what: What is expected, for the error about a name that is none.

    Raises:
        TreeError: There is none, or it does not take these parameters.
    """
    home, function_name, arguments = _parts(name, what)
    is_file = home.endswith(".py")
    module = imported_file(name, home) if is_file else imported(name, home)
    function: Any = getattr(module, function_name, None)
    if function is None:
        hint = instead(function_name, _functions(module), verb="it has")
        raise TreeError(f"{name}: {'file' if is_file else 'module'} {home!r} has no {function_name!r}{hint}")
    if not callable(function):
        raise TreeError(f"{name} is {function!r}, which is no {what.partition(';')[0]}")
    _check_arguments(name, function, arguments)
    return NamedFunction(name, function, arguments, (module.__file__,) if module.__file__ else ())


def _parts(name: str, what: str) -> tuple[str, str, dict[str, Any]]:
    """Return the module or file, the function's name, and its arguments."""
    home, colon, rest = name.partition(":")
    try:
        said = ast.parse(rest.strip(), mode="eval").body if home and colon else None
    except SyntaxError:
        said = None
    if isinstance(said, ast.Name):
        return home, said.id, {}
    if not (isinstance(said, ast.Call) and isinstance(said.func, ast.Name)):
        raise TreeError(f"{shown(name)} is no {what}")
    arguments: dict[str, Any] = {}
    for keyword in said.keywords:
        try:
            value = ast.literal_eval(keyword.value)
        except ValueError:
            value = _Nothing
        if keyword.arg is None or value is _Nothing:
            raise TreeError(f"{name}: {ast.unparse(keyword)!r} is not NAME=VALUE with a number, a text or a list")
        arguments[keyword.arg] = value
    if said.args:
        raise TreeError(f"{name}: {ast.unparse(said.args[0])!r} has no name; write NAME={ast.unparse(said.args[0])}")
    return home, said.func.id, arguments


class _Nothing:
    """Stands for a value that can't be read."""


def _check_arguments(name: str, function: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    if not arguments:
        return
    try:
        parameters = inspect.signature(function).parameters
    except (TypeError, ValueError):
        return
    if any(each.kind is each.VAR_KEYWORD for each in parameters.values()):
        return
    known = [each.name for each in parameters.values() if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
    for argument in arguments:
        if argument not in known:
            raise TreeError(f"{name}: it takes no {argument!r}{instead(argument, known, verb='it takes')}")


def _functions(module: ModuleType) -> list[str]:
    """Return the public functions of a module, or of a package's modules, that could be meant."""
    return [
        name
        for name, value in vars(module).items()
        if inspect.isfunction(value)
        and f"{value.__module__}.".startswith(f"{module.__name__}.")
        and not name.startswith("_")
    ]
