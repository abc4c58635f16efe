"""Functions that a user names, ``MODULE:FUNCTION`` or ``FILE.py:FUNCTION`` with parameters, and their modules."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.errors import TreeError
from hmrsim.diagnostics import instead, shown
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from types import ModuleType

_FUNCTION: Final = "function; expected MODULE:FUNCTION or FILE.py:FUNCTION(NAME=VALUE, …)"


@dataclass(frozen=True)
class NamedFunction:
    """A function that was found by its name.

    Attributes:
        name: The name as the user wrote it.
        arguments: The user's arguments.
        files: The files that the function was read from.
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
        """Return the same function with further arguments, which replace those of the same names.

        Raises:
            TreeError: The function has no such arguments.
        """
        if not arguments:
            return self
        _check_arguments(self.name, self.function, arguments)
        return replace(self, arguments={**self.arguments, **arguments})


def find_function(name: str, what: str = _FUNCTION) -> NamedFunction:
    """Return the function of a name; modules are searched in the current folder, too.

    Args:
        name: As in ``missions:patrol``, ``missions.py:patrol`` or ``missions.py:deliver(code=7)``.
        what: The expected form, for the error about an invalid name.

    Raises:
        TreeError: There is no such function, or it has no such arguments.
    """
    home, function_name, arguments = _parts(name, what)
    is_file = home.endswith(".py")
    module = imported_file(name, home) if is_file else imported(name, home)
    function: Any = getattr(module, function_name, None)
    if function is None:
        hint = instead(function_name, _functions(module), verb="it has")
        raise TreeError(f"{name}: {'file' if is_file else 'module'} {home!r} has no {function_name!r}{hint}")
    if not callable(function):
        raise TreeError(f"{name} is {function!r}, which is not a {what.partition(';')[0]}")
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
        raise TreeError(f"{shown(name)} is not a {what}")
    arguments: dict[str, Any] = {}
    for keyword in said.keywords:
        try:
            value = ast.literal_eval(keyword.value)
        except ValueError:
            value = _Nothing
        if keyword.arg is None or value is _Nothing:
            quoted = (
                f"; quote the text: {keyword.arg}='{keyword.value.id}'" if isinstance(keyword.value, ast.Name) else ""
            )
            raise TreeError(
                f"{name}: {ast.unparse(keyword)!r} is not NAME=VALUE with a number, a text or a list{quoted}"
            )
        arguments[keyword.arg] = value
    if said.args:
        raise TreeError(f"{name}: {ast.unparse(said.args[0])!r} has no name; write NAME={ast.unparse(said.args[0])}")
    return home, said.func.id, arguments


class _Nothing:
    """Represents an argument that is not a literal."""


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
    """Return the public functions of a module, or of a package's modules, as suggestions."""
    return [
        name
        for name, value in vars(module).items()
        if inspect.isfunction(value)
        and f"{value.__module__}.".startswith(f"{module.__name__}.")
        and not name.startswith("_")
    ]


def imported(name: str, module_name: str) -> ModuleType:
    """Return a module of the current folder, or an installed one.

    Raises:
        TreeError: The module can't be imported; *name* is the user's name of the tree or nodes.
    """
    if not all(module_name.split(".")):
        raise TreeError(f"{name}: {module_name!r} is not a module name")
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


def imported_file(name: str, path: str) -> ModuleType:
    """Return the module of a file, which can import the modules beside it.

    Raises:
        TreeError: The file can't be imported; *name* is the user's name of the tree or function.
    """
    file = Path(path).absolute()
    if not file.is_file():
        raise TreeError(f"{name}: no such file: {path}")
    loaded = sys.modules.get(file.stem)
    if loaded is not None and loaded.__file__ and Path(loaded.__file__).absolute() == file:
        return loaded
    # Another module of this name stays what it is.
    module_name = file.stem if loaded is None else str(file)
    if module_name in sys.modules:
        return sys.modules[module_name]
    if (folder := str(file.parent)) not in sys.path:
        sys.path.insert(0, folder)
    spec = importlib.util.spec_from_file_location(module_name, file)
    if spec is None or spec.loader is None:
        raise TreeError(f"{name}: {path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[module_name]
        raise TreeError(f"{name}: {described(error)}") from error
    return module
