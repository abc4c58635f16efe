"""Files of coverage: JSON, which can be merged, and LCOV's tracefile."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Final

from bt_controller.coverage.lcov import lcov, outline_beside
from bt_controller.coverage.tree_coverage import CoverageError, TreeCoverage
from hmrsim.errors import OutputError, reason_of
from hmrsim.program.files import TextOutput, check_regular, unwritable

if TYPE_CHECKING:
    from pathlib import Path

JSON: Final = ".json"
INFO: Final = ".info"


def read_coverage(path: Path) -> TreeCoverage:
    """Return the coverage of a file.

    Raises:
        CoverageError: It can't be read, or is no coverage in JSON.
    """
    try:
        check_regular(path)
        text = path.read_bytes()
    except OSError as error:
        raise CoverageError(f"{path}: can't be read: {reason_of(error)}") from None
    try:
        return TreeCoverage.from_json(text)
    except CoverageError as error:
        raise CoverageError(f"{path}: {error}") from None


def check_format(option: str, path: Path) -> None:
    """Check that the ending of a file to write says a format.

    Raises:
        OutputError: It does not.
    """
    if path.suffix not in (JSON, INFO):
        raise OutputError(f"{option} {path} does not say a format; expected a name that ends with {JSON} or {INFO}")


def check_mergeable(option: str, path: Path) -> None:
    """Check that a coverage can be written to a file, before it takes the time to get it.

    Raises:
        CoverageError: The file is there, and is no coverage in JSON.
        OutputError: Its ending says no format, or there is no such folder.
    """
    check_format(option, path)
    if not path.parent.is_dir():
        raise OutputError(f"{option} {path}: there is no folder {path.parent}")
    if path.suffix == JSON and path.exists():
        read_coverage(path)


def merge_into(option: str, path: Path, coverage: TreeCoverage) -> None:
    """Write a coverage to a file; in JSON, with what is in it already.

    Raises:
        CoverageError: The file is no coverage.
        OutputError: It can't be written.
        WriteError: The disk is full.
    """
    if path.suffix == JSON and path.exists():
        merged = read_coverage(path)
        merged.merge(coverage)
        coverage = merged
    write_coverage(option, path, coverage)


def write_coverage(option: str, path: Path, coverage: TreeCoverage) -> None:
    """Write a coverage to a file, as its ending says; a JSON file is replaced only when the new one is complete.

    Raises:
        OutputError: It can't be written.
        WriteError: The disk is full.
    """
    if path.suffix == INFO:
        text, outline = lcov(coverage, outline_beside(path))
        with TextOutput(option, path) as file:
            file.write(text)
        if outline:
            with TextOutput(option, outline_beside(path)) as file:
                file.write(outline)
        return
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    with TextOutput(option, unfinished) as file:
        file.write(json.dumps(coverage.to_json(), indent=1) + "\n")
    try:
        unfinished.replace(path)
    except OSError as error:
        raise unwritable(f"{option} {path}", error) from None
