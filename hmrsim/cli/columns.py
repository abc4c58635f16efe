"""Rows of words as lines of text, in columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hmrsim.errors import printable


def columns(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield a line for each row; all have the same number of words."""
    shown = [[printable(word) for word in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
    for row in shown:
        yield "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip()
