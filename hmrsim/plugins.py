"""Discovery of plug-ins: one folder per kind, one file per plug-in or family of plug-ins.

A plug-in module defines a constant (``ACTION``, ``COMPONENT``, …) of the kind's type, named as its file. A module of
several plug-ins defines a tuple of them, in the plural (``SERVICES``). Other packages add theirs through an entry point
of the group ``hmrsim.<kind>``, which names such a module.
"""

from __future__ import annotations

import importlib
import logging
import pkgutil
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

from hmrsim.diagnostics import instead
from hmrsim.errors import PluginError, printable

if TYPE_CHECKING:
    from types import ModuleType


class Named(Protocol):
    """A value with a name, as discovery needs it."""

    @property
    def name(self) -> str:
        """The name of the plug-in in files, options and messages."""


P = TypeVar("P", bound=Named)

_log = logging.getLogger(__name__)

GROUPS: Final = (
    "bt_controller.nodes.actions",
    "bt_controller.nodes.conditions",
    "bt_controller.nodes.controls",
    "bt_controller.nodes.decorators",
    "hmrsim.actions",
    "hmrsim.components",
    "hmrsim.events",
    "hmrsim.facilities",
    "hmrsim.faults",
    "hmrsim.services",
    "hmrsim.traffic.policies",
    "hmrsim.world.formats",
)
"""The groups of entry points, each named as the package whose modules are of its kind."""

_OURS: Final = {group.partition(".")[0] for group in GROUPS}

_left_out: Final[list[PluginError]] = []


def discover(package: ModuleType, constant: str, kind: type[P]) -> dict[str, P]:
    """Return the plug-ins of a kind by name, in order of name.

    Every public module of *package* must define *constant*, or a tuple under its plural. Then come the installed entry
    points of the group named as the package, such as ``hmrsim.actions``. A broken entry point is left out with a
    warning; `check` raises its error.

    Raises:
        PluginError: A module of the package can't be imported, lacks the constant, or is misnamed.
    """
    found: dict[str, P] = {}
    for info in sorted(pkgutil.iter_modules(package.__path__), key=lambda info: info.name):
        if not info.name.startswith("_"):
            _add(found, _load(f"{package.__name__}.{info.name}", constant, kind), f"{package.__name__}.{info.name}")
    for entry in sorted(_installed().select(group=package.__name__), key=lambda entry: (entry.name, entry.value)):
        try:
            _add(found, _load(entry.value, constant, kind), entry.value)
        except PluginError as error:
            _log.warning("%s; it is left out", error)
            _left_out.append(error)
    return dict(sorted(found.items()))


def check() -> None:
    """Check that no plug-in was left out.

    Raises:
        PluginError: One can't be imported, lacks its constant, or is misnamed; or another one has its name.
    """
    if _left_out:
        raise _left_out[0]


@cache
def _installed() -> Any:  # EntryPoints, but for Python 3.11
    """Return all entry points; cached, as this reads the metadata of every installed package.

    Logs a warning for a group that begins like ours but does not exist, since no other program would use it.
    """
    found = entry_points()
    for group in sorted(found.groups):
        if group.partition(".")[0] in _OURS and group not in GROUPS:
            names = ", ".join(sorted(entry.value for entry in found.select(group=group)))
            _log.warning("there is no group of entry points %r%s; %s is left out", group, instead(group, GROUPS), names)
    return found


def _load(module_name: str, constant: str, kind: type[P]) -> tuple[P, ...]:
    try:
        module = importlib.import_module(module_name)
    except (Exception, SystemExit) as error:
        why = "it ends the program" if isinstance(error, SystemExit) else str(error) or type(error).__name__
        raise PluginError(f"{module_name}: can't be imported: {printable(why)}") from error
    plugin = getattr(module, constant, None)
    if not isinstance(plugin, kind):
        family = getattr(module, f"{constant.removesuffix('S')}S", None)
        if isinstance(family, tuple) and family and all(isinstance(member, kind) for member in family):
            return family
        raise PluginError(f"{module.__file__}: {constant} must be one {kind.__name__}, found {plugin!a}")
    if plugin.name != module_name.rpartition(".")[2]:
        raise PluginError(f"{module.__file__}: {constant} is named {plugin.name!r}; name it as its file")
    return (plugin,)


def _add(found: dict[str, P], plugins: tuple[P, ...], where: str) -> None:
    for plugin in plugins:
        if plugin.name in found:
            raise PluginError(f"{where}: there is a plug-in named {plugin.name!r} already")
        found[plugin.name] = plugin
