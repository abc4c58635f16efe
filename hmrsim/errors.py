"""The errors of hmrsim, as one tree.

::

    HmrsimError
    ├── DocumentError           a file can't be read or is invalid; carries every problem found
    │   ├── WorldError          ... of a world
    │   ├── SettingsError       ... of settings
    │   ├── ExperimentError     ... of an experiment
    │   ├── PropertyError       ... of properties
    │   └── CheckError          ... of a check
    ├── ResultsError            results of an experiment can't be read, or belong to another one
    ├── TraceError              a file is not a valid trace, or a trace can't be made
    ├── RecordingError          a file is not a valid recording, or a recording can't be made
    ├── OutputError             a file can't be an output, such as one that is being read
    ├── WriteError              a file could not be written completely, for example on a full disk
    ├── PluginError             a plug-in is missing, misnamed or broken
    ├── MissingExtra            an optional package is not installed
    ├── GoalRejected            a goal is not accepted; carries the reason
    ├── GoalAborted             an accepted goal can't be finished; carries the action's error code
    │   └── NoRoute             ... because there is no route
    ├── EndlessInstant          the events of one instant do not come to an end
    └── SimulationStopped       a command came after the simulation had ended

An invalid call (a negative delay, an illegal transition) raises a ``ValueError`` or ``RuntimeError``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


class HmrsimError(Exception):
    """The cause is a user, a file or a robot; its text can be shown to users."""


def printable(text: str) -> str:
    """Return *text* with control characters and line breaks escaped: it may come from an untrusted client."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


_MAX_MESSAGE = 1_000
"""Characters of a problem's message that are shown."""


@dataclass(frozen=True)
class Problem:
    """A problem of a world file or a settings file.

    Attributes:
        file: The file as the user named it.
        path: Dotted path of the field, such as ``robots.wall_e.at``; empty for the whole file.
        message: The value and what is expected.
        line: Line in the file, from 1; None where the format has no lines.
        value: The offending value, as far as it can be shown.
        severity: ``error``, or ``warning`` for what can be run but is unlikely to be meant.
    """

    file: str
    path: str
    message: str
    line: int | None = None
    value: object = field(default=None, hash=False)  # it may be a list or a mapping
    severity: str = "error"

    def __str__(self) -> str:
        """Return ``file:line: path: message``, as compilers write it."""
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        message = self.message if len(self.message) <= _MAX_MESSAGE else f"{self.message[:_MAX_MESSAGE]}…"
        return printable(": ".join(part for part in (place, self.path, message) if part))


class DocumentError(HmrsimError):
    """A file can't be read or is invalid.

    Attributes:
        problems: All problems, in file order; never empty.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class WorldError(DocumentError):
    """A world file can't be read or is not valid; *problems* lists all problems in file order."""


class SettingsError(DocumentError):
    """A settings file can't be read or is not valid; *problems* lists all problems in file order."""


class ExperimentError(DocumentError):
    """The file of an experiment can't be read or is not valid; *problems* lists all problems in file order."""


class PropertyError(DocumentError):
    """A file of properties can't be read or is not valid; *problems* lists all problems in file order."""


class CheckError(DocumentError):
    """The file of a check can't be read or is not valid; *problems* lists all problems in file order."""


class ResultsError(HmrsimError):
    """The results of an experiment can't be read, or belong to another one; the text says where and how to go on."""


class TraceError(HmrsimError):
    """A file is not a valid trace, or a trace can't be made; the text says where and why."""


class RecordingError(HmrsimError):
    """A file is not a valid recording, or a recording can't be made; the text says where and why."""


class OutputError(HmrsimError):
    """A file can't be an output: it can't be opened, or the same command reads it or uses it for another output."""


class WriteError(HmrsimError):
    """A file could not be written completely, for example on a full disk; the text names the file and says why."""


class PluginError(HmrsimError):
    """A plug-in is missing, misnamed or broken; the text names the file and a remedy."""


class MissingExtra(HmrsimError):
    """An optional package is not installed; the text says which part of hmrsim needs it, and how to install it."""


class GoalRejected(HmrsimError):
    """A goal is not accepted.

    Attributes:
        reason: An identifier, such as ``unknown_robot`` or ``busy``.
        code: The code of the action's result with which Nav2 aborts such a goal; None if it rejects it, too.
        early: Whether Nav2 rejects it from lyrical on.
    """

    def __init__(self, reason: str, message: str, code: int | None = None, *, early: bool = False) -> None:
        self.reason = reason
        self.code = code
        self.early = early
        super().__init__(message)


class GoalAborted(HmrsimError):
    """An accepted goal can't be finished.

    Attributes:
        code: The error code of the action's result, Nav2's or MoveIt's.
        cause: Why, as an identifier, such as those of `hmrsim.protocol.goal.Cause`.
    """

    def __init__(self, code: int, message: str, cause: str = "failed") -> None:
        self.code = code
        self.cause = cause
        # simpy makes a new error from these arguments when an event fails with it.
        super().__init__(code, message, cause)

    def __str__(self) -> str:
        """Return what can't be done, and why."""
        return str(self.args[1])


class BaseDisabled(GoalAborted):
    """The base of a robot is disabled, so that a motion is not finished."""


class NoRoute(GoalAborted):
    """There is no route between two points; *code* is one of ComputePathToPose's."""

    def __init__(self, code: int, message: str, cause: str = "no_route") -> None:
        super().__init__(code, message, cause)


class EndlessInstant(HmrsimError):
    """The events of one instant do not come to an end; the text says when, and which events they are."""


class SimulationStopped(HmrsimError):
    """A command came after the simulation had ended."""


def reason_of(error: OSError) -> str:
    """Return why a file can't be used, as the end of a sentence."""
    return (error.strerror or str(error)).lower()
