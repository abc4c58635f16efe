"""The instructions of Containerfile, some of which can be executed without a container."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

from tests.paths import ROOT

if TYPE_CHECKING:
    from pathlib import Path

_TEXT = (ROOT / "Containerfile").read_text().replace("\\\n", "")
STEPS = [tuple(line.split(" ", 1)) for line in _TEXT.splitlines() if line and not line.startswith("#")]


def argument_of(instruction: str) -> str:
    """Return the argument of the only instruction of this name."""
    (text,) = (rest for name, rest in STEPS if name == instruction)
    return text


def words_of(instruction: str) -> list[str]:
    """Return the words of an instruction in its form for exec, without its options."""
    text = argument_of(instruction)
    words: list[str] = json.loads(text[text.index("[") :])
    return words


def copied() -> tuple[list[str], str]:
    """Return the patterns of the copied files, and their destination."""
    *sources, folder = argument_of("COPY").split()
    return sources, folder


def install(context: Path, environment: Path, folder: Path) -> list[str]:
    """Carry out COPY and RUN: with *environment* for the system's Python, and below *folder* what they write.

    Returns:
        The arguments of ``useradd``, which is not run.
    """
    sources, target = copied()
    there = folder / target.strip("/")
    there.mkdir(parents=True)
    for pattern in sources:
        for file in context.glob(pattern):
            shutil.copy(file, there)
    programs = folder / "programs"
    programs.mkdir()
    # One pip for each environment takes its time, and so does fetching anew what others have fetched.
    _program(programs / "pip", f'exec {sys.executable} -m pip --python {environment}/bin/python "$@"')
    _program(programs / "useradd", f'echo "$@" >{folder}/user')
    command = argument_of("RUN").replace(target.rstrip("/"), str(there))
    subprocess.run(
        ["sh", "-c", command.replace(" --no-cache-dir", "")],
        env={**os.environ, "PATH": f"{programs}:{os.environ['PATH']}:{os.defpath}"},
        check=True,
        capture_output=True,
    )
    return (folder / "user").read_text().split()


def _program(path: Path, line: str) -> None:
    path.write_text(f"#!/bin/sh\n{line}\n")
    path.chmod(0o755)
