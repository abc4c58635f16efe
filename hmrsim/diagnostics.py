"""Findings of readers and checks, before their file and line are known."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from hmrsim.errors import Problem

Path = tuple[str | int, ...]
"""Keys and indices that lead to a field, from the top of a world."""

_LISTED = 8
"""Names that a message lists when none is similar."""

_SHOWN = 60
"""Characters of a value that a message shows."""

_COMPARED = 300
"""Maximum number of names that are compared to find a similar one, as comparing is slow."""

_MIN_BEGINNING = 3
"""Characters of a name that may be the beginning of the one that is meant."""

_MAX_STEP = 200
"""Characters of a name that a path shows; a longer one is not compared with others."""

MAX_FINDINGS = 1_000
"""Maximum number of findings that are reported."""


@dataclass(frozen=True)
class Finding:
    """A problem of a world.

    Attributes:
        path: The field; empty for the whole world.
        message: The value and what is expected.
        value: The offending value.
        severity: ``error`` or ``warning``.
        line: Where the reader that found it saw it; None when the path leads there.
    """

    path: Path
    message: str
    value: object = None
    severity: str = "error"
    line: int | None = None


def problems_of(findings: Iterable[Finding], file: str, line_of: Callable[[Path], int | None]) -> list[Problem]:
    """Return findings as problems of a file, in the order of its lines.

    Args:
        findings: What a reader or a check has found.
        file: The file as the user named it.
        line_of: Returns the line that a path leads to.
    """
    problems = [problem_of(finding, file, line_of) for finding in findings]
    return sorted(problems, key=lambda problem: problem.line or 0)


def limited(problems: list[Problem], file: str) -> list[Problem]:
    """Return the first problems, up to `MAX_FINDINGS`, and one that gives the number of the others."""
    more = len(problems) - MAX_FINDINGS
    if more <= 0:
        return problems
    last = Problem(file, "", f"and {more} more", severity=problems[MAX_FINDINGS].severity)
    return [*problems[:MAX_FINDINGS], last]


def problem_of(finding: Finding, file: str, line_of: Callable[[Path], int | None]) -> Problem:
    """Return a finding as a problem of a file; see `problems_of`."""
    line = finding.line or line_of(finding.path)
    return Problem(file, dotted(finding.path), finding.message, line, finding.value, finding.severity)


def warning(path: Path, message: str, value: object = None) -> Finding:
    """Return a finding that does not keep a world from being run."""
    return Finding(path, message, value, "warning")


def dotted(path: Path) -> str:
    """Return a path as it is shown, such as ``lanes.1.to``."""
    return ".".join(_cut(str(step), _MAX_STEP) for step in path)


def shown(value: object) -> str:
    """Return a value as it is shown: on one line, cut when it is long, in the words of YAML."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, str):
        return repr(shortened(value))
    return shortened(repr(value[:_SHOWN] if isinstance(value, list) else value))


def shortened(text: str) -> str:
    """Return a text, truncated if it is long."""
    return _cut(text, _SHOWN)


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[:most]}…"


def meant(wanted: str, known: Iterable[str]) -> str | None:
    """Return the most similar name, or the only one that begins so; None if there is none."""
    if len(wanted) > _MAX_STEP:
        return None
    names = list(known)
    near = [name for name in names if abs(len(name) - len(wanted)) <= 3 and name[:1] == wanted[:1]]  # noqa: PLR2004
    alike = difflib.get_close_matches(wanted, near[:_COMPARED] or names[:_COMPARED], n=1)
    if alike:
        return alike[0]
    longer = [name for name in names if name.startswith(wanted)] if len(wanted) >= _MIN_BEGINNING else []
    return longer[0] if len(longer) == 1 else None


def instead(wanted: str, known: Iterable[str], *, verb: str = "there are") -> str:
    """Return a suggestion, or the known names, as the end of a message."""
    names = list(known)
    if alike := meant(wanted, names):
        return f"; did you mean {alike!r}?"
    return f"; {verb} {listed(names)}"


def known_name(what: str, name: str, known: Iterable[str]) -> str:
    """Return a name of something that there is.

    Raises:
        ValueError: There is no *what* of this name; the text has the one that may be meant, or those that there are.
    """
    names = list(known)
    if name not in names:
        raise ValueError(f"no {what} {name!r}{instead(name, names)}")
    return name


def listed(names: Sequence[str]) -> str:
    """Return names for a message: the first ones of many, or "none"."""
    if len(names) > _LISTED:
        return f"{', '.join(names[:_LISTED])} and {len(names) - _LISTED} more"
    return ", ".join(names) or "none"
