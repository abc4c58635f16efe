"""A block of commands, and the expected output of each."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

_PROMPT: Final = re.compile(r"^(?:[\w.-]+)?\$ +(?P<command>.*)$")
_REMARK: Final = re.compile(r"\s{2,}#.*$")


@dataclass(frozen=True)
class Command:
    """A command of a page, and its expected lines; without lines any output matches."""

    text: str
    output: str = ""


def commands_of(text: str) -> list[Command]:
    """Return the commands of a `console` block, after `$` and continued after `>`, with their output."""
    commands: list[list[str]] = []
    outputs: list[list[str]] = []
    for line in text.splitlines():
        if prompt := _PROMPT.match(line):
            commands.append([prompt["command"]])
            outputs.append([])
        elif not commands:
            raise ValueError(f"expected a line that begins with '$ ', not {line!r}")
        elif line.startswith("> ") and not outputs[-1]:
            commands[-1].append(line.removeprefix("> "))
        else:
            outputs[-1].append(line)
    return [
        Command("\n".join(_REMARK.sub("", line) for line in lines), "\n".join(output).rstrip())
        for lines, output in zip(commands, outputs, strict=True)
    ]


def lines_of(text: str) -> list[Command]:
    """Return the commands of a `sh` block, one a line or continued after a backslash."""
    joined = re.sub(r"\\\n\s*", "", text)
    lines = [_REMARK.sub("", line).strip() for line in joined.splitlines()]
    return [Command(line) for line in lines if line and not line.startswith("#")]


def fits(expected: str, actual: str) -> bool:
    """Return whether a text matches the page's, where `...` matches anything, also across lines."""
    pattern = r"[\s\S]*?".join(re.escape(part) for part in _tidy(expected).split("..."))
    return re.fullmatch(pattern, _tidy(actual)) is not None


def begins_with(expected: str, actual: str) -> bool:
    """Return whether the first lines of a text are those of the page."""
    lines = actual.splitlines()
    return any(fits(expected, "\n".join(lines[:count])) for count in range(len(lines) + 1))


def _tidy(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines())
