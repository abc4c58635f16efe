"""A line on a terminal that says how far a command is."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from hmrsim.cli.output import warn


class TerminalLine:
    """A line that the next one replaces, on the terminal of the standard error output.

    Attributes:
        shown: Whether there is such a line: not without a terminal, nor if it is *quiet*.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self.shown = sys.stderr.isatty() and not quiet

    def show(self, text: str = "") -> None:
        """Show a text in place of the last one; nothing without a terminal."""
        if self.shown:
            sys.stderr.write(f"\r\x1b[K{text}")
            sys.stderr.flush()

    def tell(self, text: str) -> None:
        """Show a text in place of the last one; without a terminal on a line that stays."""
        if self.shown:
            self.show(text)
        else:
            warn(text)

    @contextmanager
    def showing(self, text: str) -> Iterator[None]:
        """Show a text and those that replace it, and take the last one away."""
        self.show(text)
        try:
            yield
        finally:
            self.show()
