"""Discovery of plug-ins: one folder per kind, one file per plug-in.

A plug-in module defines one constant (``ACTION``, ``COMPONENT``, …) of the kind's type, named as its file.
Other packages add theirs through an entry point of the group ``hmrsim.<kind>``, which names such a module.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from hmrsim.errors import PluginError

if TYPE_CHECKING:
    from types import ModuleType


class Named(Protocol):
    """A value with a name, as discovery needs it."""

    @property
    def name(self) -> str:
        """Its name for users."""


P = TypeVar("P", bound=Named)


def discover(package: ModuleType, constant: str, kind: type[P]) -> dict[str, P]:
    """Return the plug-ins of a kind by name, in order of name.

    Every public module of *package* must define *constant*; then come the installed entry points of the group
    named as the package, such as ``hmrsim.actions``.

    Raises:
        PluginError: A module can't be imported, lacks the constant, or is misnamed; or two have one name.
    """
    found: dict[str, P] = {}
    for info in sorted(pkgutil.iter_modules(package.__path__), key=lambda info: info.name):
        if not info.name.startswith("_"):
            _add(found, _load(f"{package.__name__}.{info.name}", constant, kind), f"{package.__name__}.{info.name}")
    for entry in sorted(_installed().select(group=package.__name__), key=lambda entry: (entry.name, entry.value)):
        _add(found, _load(entry.value, constant, kind), entry.value)
    return dict(sorted(found.items()))


@cache
def _installed() -> Any:  # EntryPoints, but for Python 3.11
    """Return all entry points; cached, as this reads the metadata of every installed package."""
    return entry_points()


def _load(module_name: str, constant: str, kind: type[P]) -> P:
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise PluginError(f"{module_name}: can't be imported: {error}") from error
    plugin = getattr(module, constant, None)
    if not isinstance(plugin, kind):
        raise PluginError(f"{module.__file__}: {constant} must be one {kind.__name__}, found {plugin!r}")
    if plugin.name != module_name.rpartition(".")[2]:
        raise PluginError(f"{module.__file__}: {constant} is named {plugin.name!r}; name it as its file")
    return plugin


def _add(found: dict[str, P], plugin: P, where: str) -> None:
    if plugin.name in found:
        raise PluginError(f"{where}: there is a plug-in named {plugin.name!r} already")
    found[plugin.name] = plugin
