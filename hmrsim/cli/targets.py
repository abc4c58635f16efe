"""Files that commands write: checked before the work is done, and written as a whole or not at all."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from hmrsim.cli.exits import WrongUse
from hmrsim.program.outputs import unwritable

if TYPE_CHECKING:
    from pathlib import Path


def check_target(out: Path, *, force: bool) -> None:
    """Check that a file can be written, as far as that can be known in advance.

    Raises:
        WrongUse: It can't.
    """
    if out.is_file():
        if not force:
            raise WrongUse(f"{out}: exists already; overwrite it with --force")
    elif out.exists():
        raise WrongUse(f"{out}: is not a regular file; name another, or - for stdout")
    elif not out.parent.is_dir():
        raise WrongUse(f"{out}: there is no folder {str(out.parent)!r}")


def write_whole(out: Path, content: bytes) -> None:
    """Write a file as a whole or not at all.

    Raises:
        OutputError: It can't be written.
        WriteError: The disk is full.
    """
    target = out.resolve()
    draft = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        try:
            draft.write_bytes(content)
            draft.replace(target)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as error:
        raise unwritable(str(out), error) from None
