"""Messages as text: YAML, or JSON for programs."""

from __future__ import annotations

import json
import sys
import textwrap
from typing import TYPE_CHECKING, Any, Final

import yaml

from hmrsim.errors import printable

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

_DIGITS: Final = 9
"""Significant digits of numbers in text output, without the errors of binary arithmetic."""


def values(message: Message) -> dict[str, Any]:
    """Return a message as plain values."""
    return message.model_dump(mode="json")


def yaml_text(data: object) -> str:
    """Return plain values as YAML, one field per line, with a line break at the end."""
    text: str = yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, default_flow_style=False, allow_unicode=True, width=120
    )
    return text


def yaml_flow(data: object) -> str:
    """Return plain values as YAML on one line, as goals are written on the command line."""
    text: str = yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, default_flow_style=True, allow_unicode=True, width=10**6
    )
    return text.strip()


def indented(text: str) -> str:
    """Return a text four columns to the right, as ROS 2 shows feedback and results."""
    return textwrap.indent(text, "    ")


def show_json(data: object) -> None:
    """Print one JSON value on a line of its own, at once."""
    show(json.dumps(data, allow_nan=False))


def show(text: str) -> None:
    """Print a result and flush: a program may wait for it."""
    print(text, flush=True)


def warn(text: str) -> None:
    """Print text that is not a result, without control characters of files and clients that it tells of."""
    print("\n".join(map(printable, text.split("\n"))), file=sys.stderr, flush=True)


class _Dumper(yaml.SafeDumper):
    """Rounds numbers, and writes equal values out again rather than as anchors."""

    def ignore_aliases(self, _data: Any) -> bool:
        return True

    def represent_float(self, data: float) -> yaml.ScalarNode:
        return super().represent_float(float(f"{data:.{_DIGITS}g}"))


_Dumper.add_representer(float, _Dumper.represent_float)
