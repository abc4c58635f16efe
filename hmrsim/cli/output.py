"""The output of commands: text, YAML, JSON, a progress line on a terminal, and files."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import WrongUse
from hmrsim.errors import printable
from hmrsim.program.files import unwritable

if TYPE_CHECKING:
    from pathlib import Path

    import yaml
    from rich.text import Text


_DIGITS: Final = 9
"""Significant digits of numbers in YAML, which hide the rounding errors of binary arithmetic."""
_WIDTH: Final = 200
"""Characters of a line of a table if the output is not a terminal."""
_TERMINAL_PERIOD: Final = 0.2
"""Wall seconds between two reports on a terminal."""


def show(text: str) -> None:
    """Print a result and flush, since another program may be waiting for it."""
    print(text, flush=True)


def show_json(data: object) -> None:
    """Print one JSON value on one line, and flush."""
    show(json.dumps(data, allow_nan=False))


def show_result(data: object, text: str | Iterable[str], *, as_json: bool) -> None:
    """Print a result as one JSON value, or else as text or lines of text."""
    if as_json:
        show_json(data)
        return
    for line in (text,) if isinstance(text, str) else text:
        show(line)


def warn(text: str) -> None:
    """Print a message to stderr, with escaped control characters: it may contain text from files and clients."""
    print("\n".join(map(printable, text.split("\n"))), file=sys.stderr, flush=True)


def columns(rows: Sequence[Sequence[str]], *, right: Container[int] = ()) -> Iterator[str]:
    """Yield one line per row with aligned columns, of which those with an index in *right* are right-aligned."""
    cells = [[printable(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        padded = (
            cell.rjust(width) if i in right else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join(padded).rstrip()


def show_table(headings: Sequence[str], rows: Iterable[Sequence[str | Text]], *, left: Container[str]) -> None:
    """Print a table that fits the terminal; columns whose heading is not in *left* are right-aligned."""
    # Loads rich, which takes 60 ms.
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for heading in headings:
        table.add_column(Text(heading), justify="left" if heading in left else "right")
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(printable(cell)) for cell in row))
    Console(width=None if Console().is_terminal else _WIDTH).print(table)


def counted(number: int, nouns: str) -> str:
    """Return a number with its noun, which is given in the plural."""
    return f"{number} {nouns.removesuffix('s') if number == 1 else nouns}"


def yaml_text(data: object) -> str:
    """Return plain values as YAML with one field per line, ending in a line break."""
    return _yaml(data, default_flow_style=False, width=120)


def yaml_flow(data: object) -> str:
    """Return plain values as YAML on one line, as goals are written on the command line."""
    return _yaml(data, default_flow_style=True, width=10**6).strip()


def _yaml(data: object, **options: Any) -> str:
    import yaml

    text: str = yaml.dump(data, Dumper=_dumper(), sort_keys=False, allow_unicode=True, **options)
    return text


@cache
def _dumper() -> type[yaml.SafeDumper]:
    import yaml

    class Dumper(yaml.SafeDumper):
        def ignore_aliases(self, _data: Any) -> bool:
            return True

        def represent_float(self, data: float) -> yaml.ScalarNode:
            return super().represent_float(float(f"{data:.{_DIGITS}g}"))

    Dumper.add_representer(float, Dumper.represent_float)
    return Dumper


class ProgressLine:
    """A line on the terminal's stderr that shows how far a command is; each text replaces the one before.

    Without a terminal, each report is a separate line.

    Args:
        period: The minimum wall seconds between two reports without a terminal.
        quiet: Whether to show nothing.
    """

    def __init__(self, period: float, *, quiet: bool = False) -> None:
        self._on_terminal = sys.stderr.isatty()
        self._quiet = quiet
        self._period = _TERMINAL_PERIOD if self._on_terminal else period
        self._reported = 0.0 if self._on_terminal else time.monotonic()

    def show(self, text: str = "") -> None:
        """Replace the text at once; do nothing without a terminal."""
        if self._on_terminal and not self._quiet:
            sys.stderr.write(f"\r\x1b[K{text}")
            sys.stderr.flush()

    def report(self, text: Callable[[], str]) -> None:
        """Show a text, unless the last report was shown just before."""
        now = time.monotonic()
        if self._quiet or now - self._reported < self._period:
            return
        self._reported = now
        if self._on_terminal:
            self.show(text())
        else:
            warn(text())

    @contextmanager
    def showing(self, text: str) -> Iterator[None]:
        """Show a text, and clear the line at the end of the context."""
        self.show(text)
        try:
            yield
        finally:
            self.show()


def check_target(out: Path, *, force: bool) -> None:
    """Check that a file can be written, as far as this can be known before the work is done.

    Raises:
        WrongUse: The file exists, is not a regular file, or its folder does not exist.
    """
    if out.is_file():
        if not force:
            raise WrongUse(f"{out}: exists already; overwrite it with --force")
    elif out.exists():
        raise WrongUse(f"{out}: is not a regular file; name another, or - for stdout")
    elif not out.parent.is_dir():
        raise WrongUse(f"{out}: there is no folder {str(out.parent)!r}")


def write_whole(out: Path, content: bytes) -> None:
    """Write a file completely or not at all.

    Raises:
        OutputError: The file can't be written.
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
