"""Nodes with scripts: the names in a script become ports, so that a file's remappings apply to them.

Each name is an input port ``name``, and one that a script changes is also an output port ``name>``; the builder of the
node connects both to the same key.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from bt_controller.core.node import Node
from bt_controller.core.ports import ANY, input_port, output_port
from bt_controller.scripting.parser import ScriptError
from bt_controller.scripting.values import truth

if TYPE_CHECKING:
    from bt_controller.scripting.parser import Script


class Scripted(Node):
    """A node that runs scripts; `bind` makes a class with them.

    Attributes:
        SCRIPTS: The attributes that are scripts, not ports.
        scripts: The parsed scripts by attribute.
    """

    SCRIPTS: ClassVar[tuple[str, ...]] = ()

    scripts: ClassVar[Mapping[str, Script]] = MappingProxyType({})

    @classmethod
    def bind(cls, scripts: Mapping[str, Script]) -> type[Self]:
        """Return a class that has these scripts, by attribute, and ports for their names.

        Raises:
            ScriptError: An entry is named as one of the node's own ports.
        """
        inputs, outputs = dict(cls.INPUTS), dict(cls.OUTPUTS)
        for script in scripts.values():
            for name in script.names:
                if name in {**cls.INPUTS, **cls.OUTPUTS}:
                    raise ScriptError(
                        f"script {script.text!r:.200}: {name!r} is a port of {cls.__name__}, not an entry"
                    )
                inputs[name] = input_port(ANY, f"Entry {name} of a script", required=False)
            for name in script.changed:
                outputs[f"{name}>"] = output_port(ANY, f"Entry {name} of a script, when it is changed")
        parts: dict[str, Any] = {"__doc__": cls.__doc__, "__module__": cls.__module__}
        parts |= {"INPUTS": inputs, "OUTPUTS": outputs, "scripts": dict(scripts)}
        return type(cls.__name__, (cls,), parts)

    def run(self, attribute: str) -> Any:
        """Run a script, and return its value.

        Raises:
            ScriptError: An entry is missing, or an operator can't be used on a value.
        """
        try:
            return self.scripts[attribute].run(self)
        except ScriptError as error:
            raise ScriptError(f"{self._whose_script()}: {error}") from None

    def holds(self, attribute: str) -> bool:
        """Return whether the value of a script counts as true.

        Raises:
            ScriptError: It is neither true nor false, or the script can't be run.
        """
        value = self.run(attribute)
        try:
            return truth(value)
        except ValueError as error:
            raise ScriptError(
                f"{self._whose_script()}: script {self.scripts[attribute].text!r:.200}: {error}"
            ) from None

    def get(self, name: str) -> Any:
        """Return the value of an entry; None if there is none."""
        return self.entry(name)

    def set(self, name: str, value: Any) -> None:
        """Change or create an entry."""
        self.write(f"{name}>", value)

    def _whose_script(self) -> str:
        return f"{self.name} ({self.origin})" if self.origin else self.name
