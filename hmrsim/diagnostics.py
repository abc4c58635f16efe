"""Findings of readers and checks, before their file and line are known."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from hmrsim.errors import Problem

Path = tuple[str | int, ...]
"""Keys and indices that lead to a field, from the top of a world."""

_LISTED = 8
"""Maximum number of names in a list."""

_SHOWN = 60
"""Maximum characters of a value in a message."""

_COMPARED = 300
"""Maximum number of names that are compared to find a similar one, as comparing is slow."""

_MIN_BEGINNING = 3
"""Minimum characters of a name that is completed to a longer one."""

_MAX_STEP = 200
"""Maximum characters of a name in a path; a longer name is not compared with others."""

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
        line: The line, if the reader knows it; otherwise it follows from the path.
    """

    path: Path
    message: str
    value: object = None
    severity: str = "error"
    line: int | None = None

    def within(self, *path: str | int) -> Finding:
        """Return the finding about a part as one about the whole, in which *path* leads to the part."""
        return replace(self, path=(*path, *self.path))


def problems_of(findings: Iterable[Finding], file: str, line_of: Callable[[Path], int | None]) -> list[Problem]:
    """Return findings as problems of a file, in the order of its lines.

    Args:
        findings: The findings of a reader or a check.
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


def in_order(problems: Iterable[Problem], file: str) -> list[Problem]:
    """Return problems of several files by file and line, errors first and those of *file* first; see `limited`."""
    files = {file: 0}
    listed = [*problems]
    for problem in listed:
        files.setdefault(problem.file, len(files))
    listed.sort(key=lambda problem: (problem.severity != "error", files[problem.file], problem.line or 0))
    return limited(listed, file)


def problem_of(finding: Finding, file: str, line_of: Callable[[Path], int | None]) -> Problem:
    """Return a finding as a problem of a file; see `problems_of`."""
    line = finding.line or line_of(finding.path)
    return Problem(file, dotted(finding.path), finding.message, line, finding.value, finding.severity)


def warning(path: Path, message: str, value: object = None) -> Finding:
    """Return a finding that does not prevent a world from running."""
    return Finding(path, message, value, "warning")


def dotted(path: Path) -> str:
    """Return a path as text, such as ``lanes.1.to``."""
    return ".".join(_cut(str(step), _MAX_STEP) for step in path)


def shown(value: object) -> str:
    """Return a value as text for a message: on one line, truncated if it is long, in YAML's terms."""
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


def _cut(text: str, limit: int) -> str:
    return text if len(text) <= limit else f"{text[:limit]}…"


def meant(name: str, known: Iterable[str], *, similarity: float = 0.6) -> str | None:
    """Return the most similar known name, or else the only one that begins with *name*; None if there is none.

    *similarity* is the least ratio of difflib, from 0 to 1, that makes two names similar.
    """
    if len(name) > _MAX_STEP:
        return None
    # Takes 7 ms to load, and is only needed for errors.
    import difflib  # noqa: PLC0415

    names = list(known)
    near = [other for other in names if abs(len(other) - len(name)) <= 3 and other[:1] == name[:1]]  # noqa: PLR2004
    similar = difflib.get_close_matches(name, near[:_COMPARED] or names[:_COMPARED], n=1, cutoff=similarity)
    if similar:
        return similar[0]
    longer = [other for other in names if other.startswith(name)] if len(name) >= _MIN_BEGINNING else []
    return longer[0] if len(longer) == 1 else None


def instead(name: str, known: Iterable[str], *, verb: str = "there are") -> str:
    """Return the end of a message about an unknown name: the name probably meant, or the known names."""
    names = list(known)
    if similar := meant(name, names):
        return f"; did you mean {similar!r}?"
    return f"; {verb} {listed(names)}"


def known_name(what: str, name: str, known: Iterable[str]) -> str:
    """Check that a name is known, and return it.

    Raises:
        ValueError: There is no *what* of this name; the message suggests another name, or lists the known ones.
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
