"""Importing the user's modules, and reporting their errors."""

from __future__ import annotations

import importlib
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

from bt_controller.errors import TreeError

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


def described(error: Exception) -> str:
    """Return an error of the user's code as one line: the error and its place."""
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg} ({error.filename}:{error.lineno})"
    text = f"{type(error).__name__}: {error}".splitlines()[0]
    trace = traceback.extract_tb(error.__traceback__)
    frames = [frame for frame in trace if not frame.filename.startswith("<frozen")]
    return f"{text} ({frames[-1].filename}:{frames[-1].lineno})" if frames else text
