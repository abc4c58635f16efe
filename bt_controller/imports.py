"""Importing the user's modules, whatever is wrong with them."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from bt_controller.errors import TreeError
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from types import ModuleType


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
    """Return the module of a file; modules beside it can be imported by it.

    Raises:
        TreeError: The file can't be imported; *name* is the user's name of what is in it.
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
        raise TreeError(f"{name}: {path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[module_name]
        raise TreeError(f"{name}: {described(error)}") from error
    return module
