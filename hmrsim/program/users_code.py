"""Errors in users' code as one line: the error, and its place in that code."""

from __future__ import annotations

import os
import sysconfig
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Final

from pydantic import ValidationError

from hmrsim.diagnostics import dotted, shown
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from collections.abc import Sequence

_Frame = tuple[str, int | None]
"""A file and a line."""

_PROJECT: Final = Path(__file__).parents[1]
_NOT_USERS: Final = (
    "<frozen",
    *(
        f"{folder}{os.sep}"
        for folder in (
            *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")),
            *(_PROJECT.with_name(name) for name in ("hmrsim", "hmrsim_zenoh", "bt_controller")),
        )
    ),
)
"""Folders that do not contain users' code: Python's, installed packages, and this project."""


def first_of(error: BaseException) -> BaseException:
    """Return the first error of an exception group, as raised by asyncio's tasks; other errors as they are."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


def described(error: BaseException) -> str:
    """Return an error and its place as one line; the place is in the user's code if the error came from there."""
    error = first_of(error)
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg} ({error.filename}:{error.lineno})"
    text = f"{type(error).__name__}: {_text(error)}".splitlines()[0]
    frames = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    place = _place(_users_frames(frames) if isinstance(error, HmrsimError) else _users_frames(frames) or frames)
    return f"{text} ({place})" if place else text


def place_in(frames: Sequence[_Frame]) -> str:
    """Return the place of the innermost frame in the user's code, or else of the innermost frame.

    Args:
        frames: The frames; the innermost is the last.
    """
    return _place(_users_frames(frames) or frames)


def _users_frames(frames: Sequence[_Frame]) -> Sequence[_Frame]:
    return [frame for frame in frames if not frame[0].startswith(_NOT_USERS)]


def _place(frames: Sequence[_Frame]) -> str:
    return f"{frames[-1][0]}:{frames[-1][1]}" if frames else ""


def field_errors(error: ValidationError) -> list[str]:
    """Return the errors of a message's fields, such as ``x: input should be a valid number, got 'left'``."""
    return [
        f"{dotted(each['loc'])}: {each['msg'][:1].lower()}{each['msg'][1:]}"
        + ("" if each["type"] == "missing" else f", got {shown(each['input'])}")
        for each in error.errors(include_url=False)
    ]


def _text(error: BaseException) -> str:
    return f"{error.title}: {'; '.join(field_errors(error))}" if isinstance(error, ValidationError) else str(error)
