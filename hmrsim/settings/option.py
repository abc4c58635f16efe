"""Settings as annotations of fields: their option, unit and bounds.

A setting is a field of a frozen dataclass or pydantic model whose annotation has an `Option`. This module does not load
pydantic: tools that open a session have settings, too, and their ``--help`` must start quickly.
"""

from __future__ import annotations

import math
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

from hmrsim.diagnostics import shortened

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

MAX_PAYLOAD: Final = 1024 * 1024
"""Default maximum size of a payload, in bytes."""


MAX_SECONDS: Final = 1e9
"""Maximum finite number of seconds to wait, as operating systems support only a few times as many."""

MAX_COUNT: Final = 1_000_000_000
"""Maximum count that an option accepts."""

_MAX_DIGITS: Final = 100

FOR_EVER: Final = -1
"""The value of a timeout that never ends."""


def count(text: str) -> int:
    """Return a whole number greater than 0."""
    if not text.isdecimal() or len(text) > _MAX_DIGITS or not 0 < int(text) <= MAX_COUNT:
        raise ValueError(f"{shortened(text)!r} is not a whole number greater than 0, up to {MAX_COUNT}")
    return int(text)


@dataclass(frozen=True)
class Option:
    """The option of one setting.

    Attributes:
        help: Its description, without its default; begins in lower case.
        metavar: The placeholder of its value in ``--help``.
        unit: The unit of its value; empty for none.
        group: Its heading in ``--help``; empty for the command's own options.
        default_text: The default as shown in ``--help``; None for the default itself.
        more_than: The exclusive minimum of a number.
        at_least: The minimum of a number.
        at_most: The maximum of a number.
        hint: Ends an error about a number that is out of bounds.
        for_ever: The value for a timeout of -1; None if -1 is an ordinary number.
        endless: Whether it may be infinite.
        bare: The value of the option without an argument; None if it needs one.
        read: Converts the text of a command line to a value; None for the default of its type.
        check: Returns the value to use for a value of the right type.

    *read* and *check* raise ValueError for an invalid value, with a remedy.
    """

    help: str
    metavar: str | None = None
    unit: str = ""
    group: str = ""
    default_text: str | None = None
    more_than: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    hint: str = ""
    for_ever: float | None = None
    endless: bool = False
    bare: object = None
    read: Callable[[str], Any] | None = None
    check: Callable[[Any], Any] | None = None

    def checked(self, value: Any, text: str = "") -> Any:
        """Return the value to use for a value of the right type.

        *text* is the value as written, for errors; by default it is formatted.

        Raises:
            ValueError: The value is invalid.
        """
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            if value == FOR_EVER and self.for_ever is not None:
                return self.for_ever
            self._check_bounds(value, shortened(text) or f"{value:g}")
        return value if self.check is None else self.check(value)

    def _check_bounds(self, value: float, shown: str) -> None:
        endless = self.endless or self.for_ever == math.inf
        if not (math.isfinite(value) or (endless and value > 0)):
            raise ValueError(f"{shown!r} is not a finite number")
        why = ""
        if self.more_than is not None and value <= self.more_than:
            why = f"is not greater than {self.more_than:g}"
        elif self.at_least is not None and value < self.at_least:
            why = f"is less than {self.at_least:g}"
        elif self.at_most is not None and value > self.at_most and math.isfinite(value):
            why = f"is greater than {self.at_most:g}"
        if why:
            raise ValueError(f"{shown} {why}{f'; {self.hint}' if self.hint else ''}")

    @property
    def bounds(self) -> str:
        """The valid values as text; empty if all values are valid."""
        parts = [
            f"{sign} {bound:g}"
            for sign, bound in ((">", self.more_than), ("≥", self.at_least), ("≤", self.at_most))
            if bound is not None
        ]
        return " and ".join(parts) + (f", or {FOR_EVER} for ever" if self.for_ever is not None else "")

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema with which models check the bounds, and read tuples and paths from a file's values."""
        # Tools without models don't load pydantic; see the module's docstring.
        from pydantic_core import core_schema  # noqa: PLC0415

        kind = kind_of(source)

        def loosened(value: Any) -> Any:
            if isinstance(value, list):
                return tuple(value)
            return Path(value) if kind.type is Path and isinstance(value, str) else value

        checked = core_schema.no_info_after_validator_function(self.checked, handler(source))
        return core_schema.no_info_before_validator_function(loosened, checked)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the JSON schema with description and bounds."""
        found = handler(schema)
        limits = {"exclusiveMinimum": self.more_than, "minimum": self.at_least, "maximum": self.at_most}
        bounds = {key: bound for key, bound in limits.items() if bound is not None}
        if self.for_ever is not None:
            found.pop("type", None)
            found["anyOf"] = [{"const": FOR_EVER}, {"type": "number", **bounds}]
        else:
            found |= bounds
        unit = f" Unit: {self.unit}." if self.unit else ""
        found["description"] = f"{self.help[:1].upper()}{self.help[1:]}.{unit}"
        return found


@dataclass(frozen=True)
class Kind:
    """The type of a setting for a command line.

    Attributes:
        type: The type of one value.
        choices: All valid values; empty if they can't be listed.
        repeatable: Whether it can have several values.
    """

    type: type
    choices: tuple[Any, ...] = ()
    repeatable: bool = False


@dataclass(frozen=True)
class Setting:
    """One setting of a model.

    Attributes:
        name: The name of the field, and the key in a file.
    """

    name: str
    kind: Kind
    default: Any
    option: Option

    @property
    def flag(self) -> str:
        """The option, such as ``--step-size``."""
        return f"--{self.name.replace('_', '-')}"


@cache
def hints(model: type) -> Mapping[str, Any]:
    """Return the types of a model's fields, with their annotations."""
    return types.MappingProxyType(get_type_hints(model, include_extras=True))


@cache
def settings_of(model: type) -> Mapping[str, Setting]:
    """Return the settings of a model by name, in order, without fields that have no `Option`."""
    settings, defaults = {}, model()
    for name, hint in hints(model).items():
        option = next((part for part in getattr(hint, "__metadata__", ()) if isinstance(part, Option)), None)
        if option is not None:
            settings[name] = Setting(name, kind_of(hint), getattr(defaults, name), option)
    return types.MappingProxyType(settings)


def kind_of(hint: Any) -> Kind:
    """Return the type of a setting for a command line; of alternatives, the first."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return kind_of(parts[0])
    if origin in (Union, types.UnionType):
        return kind_of(parts[0])
    if origin is Literal:
        return Kind(type(parts[0]), parts)
    if origin is tuple:
        each = kind_of(parts[0])
        return Kind(each.type, each.choices, repeatable=True)
    return Kind(hint)
