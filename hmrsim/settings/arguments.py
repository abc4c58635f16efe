"""Command-line options of settings, and settings from parsed arguments."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.diagnostics import shortened
from hmrsim.settings.option import settings_of

if TYPE_CHECKING:
    from hmrsim.settings.option import Option, Setting

M = TypeVar("M")


def add_settings(
    parser: argparse.ArgumentParser,
    model: type,
    *,
    only: Collection[str] | None = None,
    defaults: Mapping[str, Any] | None = None,
) -> None:
    """Add an option for each setting of a model; `read_settings` reads them.

    *only* are the names of the settings that the command has, None for all; *defaults* override the model's, and are
    always in the result.
    """
    groups: dict[str, Any] = {"": parser} | {str(group.title): group for group in parser._action_groups}  # noqa: SLF001
    for name, setting in settings_of(model).items():
        if only is not None and name not in only:
            continue
        title = setting.option.group
        if title not in groups:
            groups[title] = parser.add_argument_group(title)
        if defaults and name in defaults:
            own = replace(setting, default=defaults[name])
            groups[title].add_argument(setting.flag, **_argument(own) | {"default": own.default})
        else:
            groups[title].add_argument(setting.flag, **_argument(setting))


def read_settings(args: argparse.Namespace, model: type[M], below: Mapping[str, Any] | None = None) -> M:
    """Return the settings that the command line and the environment set, with defaults for others.

    *below* are settings, of this and other models, that override the defaults.
    """
    given = {**(below or {}), **vars(args)}
    known = {name: given[name] for name in settings_of(model) if name in given}  # type: ignore[arg-type]  # a type is hashable
    return model(**{name: tuple(value) if isinstance(value, list) else value for name, value in known.items()})


def _argument(setting: Setting) -> dict[str, Any]:
    """Return the parameters of `add_argument` for a setting; without a default, so that only given options are set."""
    option, kind = setting.option, setting.kind
    common: dict[str, Any] = {"default": argparse.SUPPRESS, "help": _help_of(setting)}
    if kind.type is bool:
        return {**common, "action": "store_true"}
    if option.metavar is not None:
        common["metavar"] = option.metavar
    if option.bare is not None:
        common |= {"nargs": "?", "const": option.bare}
    if kind.repeatable and option.read is None:
        common["action"] = "append"
    if kind.choices:
        return {**common, "choices": kind.choices, "type": kind.type}
    return {**common, "type": reader(kind.type, option)}


def _help_of(setting: Setting) -> str:
    option = setting.option
    default = default_text(setting) if option.default_text is None else option.default_text
    return f"{option.help}{f' (default: {default})' if default else ''}".replace("%", "%%")


def default_text(setting: Setting) -> str:
    """Return the default of a setting as text; empty if there is none."""
    default = setting.default
    if default is None or default is False or default in ((), math.inf):
        return ""
    return f"{default:g}" if isinstance(default, float) else str(default)


def reader(kind: type, option: Option) -> Callable[[str], Any]:
    """Return the function that reads the text of a value within the bounds of an option."""
    read = option.read or _READERS.get(kind, kind)

    def checked(text: str) -> Any:
        try:
            value = read(text)
            return option.checked(value, text if isinstance(value, (int, float)) else "")
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return checked


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{shortened(text)!r} is not a finite number")
    return value


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a whole number") from None


_READERS: dict[type, Callable[[str], Any]] = {float: _number, int: _whole}
