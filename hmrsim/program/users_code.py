"""Errors of users' code on one line: what is wrong, and where in that code."""

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
"""A file, and a line in it."""

_OURS: Final = Path(__file__).parents[1]
_NOT_THEIRS: Final = (
    "<frozen",
    *(
        f"{folder}{os.sep}"
        for folder in (
            *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")),
            *(_OURS.with_name(name) for name in ("hmrsim", "hmrsim_zenoh", "bt_controller")),
        )
    ),
)
"""The folders of Python, of installed packages, and of this one: the place of an error is sought elsewhere."""


def first_of(error: BaseException) -> BaseException:
    """Return the first error of a group, which is what tasks of asyncio raise."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


def described(error: BaseException) -> str:
    """Return an error as one line: the error and its place, in the user's code if it came from there."""
    error = first_of(error)
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg} ({error.filename}:{error.lineno})"
    text = f"{type(error).__name__}: {_text(error)}".splitlines()[0]
    frames = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    place = _place(_theirs(frames) if isinstance(error, HmrsimError) else _theirs(frames) or frames)
    return f"{text} ({place})" if place else text


def place_in(frames: Sequence[_Frame]) -> str:
    """Return the place of the innermost of some frames that is of the user's code, else of the innermost one.

    Args:
        frames: The file and line of each; the innermost is the last one.
    """
    return _place(_theirs(frames) or frames)


def _theirs(frames: Sequence[_Frame]) -> Sequence[_Frame]:
    return [frame for frame in frames if not frame[0].startswith(_NOT_THEIRS)]


def _place(frames: Sequence[_Frame]) -> str:
    return f"{frames[-1][0]}:{frames[-1][1]}" if frames else ""


def mistakes_in(error: ValidationError) -> list[str]:
    """Return what is wrong with the fields of a message, such as ``x: input should be a valid number, got 'left'``."""
    return [
        f"{dotted(each['loc'])}: {each['msg'][:1].lower()}{each['msg'][1:]}"
        + ("" if each["type"] == "missing" else f", got {shown(each['input'])}")
        for each in error.errors(include_url=False)
    ]


def _text(error: BaseException) -> str:
    return f"{error.title}: {'; '.join(mistakes_in(error))}" if isinstance(error, ValidationError) else str(error)
