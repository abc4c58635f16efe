"""The report of a benchmark: its rows, as a table or as JSON."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.table import Table

from benchmarks._spread import Spread

_HEAD = ("what", "value", "ratio", "target", "met")
_PACKAGES = ("simpy", "eclipse-zenoh", "pydantic", "networkx")
_SEVERAL_DIGITS = 100


@dataclass(frozen=True)
class Row:
    """One figure of a benchmark.

    Attributes:
        what: The measured quantity.
        value: The measured value; a `Spread` if there were several rounds.
        unit: The unit of the value.
        ratio: The ratio to the baseline, which was measured in the same run; a `Spread` if there were several rounds,
            None for no comparison.
        at_most: The maximum of the value; None for no target.
        at_least: The minimum of the value; None for no target.
        ratio_at_most: The maximum of the ratio; None for no target.
    """

    what: str
    value: float
    unit: str
    ratio: float | None = None
    at_most: float | None = None
    at_least: float | None = None
    ratio_at_most: float | None = None

    @property
    def met(self) -> bool | None:
        """True if the row meets all its targets; None if it has none."""
        verdicts = []
        if self.at_most is not None:
            verdicts.append(self.value <= self.at_most)
        if self.at_least is not None:
            verdicts.append(self.value >= self.at_least)
        if self.ratio_at_most is not None and self.ratio is not None:
            verdicts.append(self.ratio <= self.ratio_at_most)
        return all(verdicts) if verdicts else None

    @property
    def cells(self) -> tuple[str, ...]:
        """The cells of the row in a table."""
        targets = [
            f"{sign} {_number(limit)} {unit}"
            for sign, limit, unit in (
                ("≤", self.at_most, self.unit),
                ("≥", self.at_least, self.unit),
                ("≤", self.ratio_at_most, "x"),
            )
            if limit is not None
        ]
        value = f"{_number(self.value)} {self.unit}{_extremes(self.value, _number)}"
        ratio = "" if self.ratio is None else f"{_ratio(self.ratio)}x{_extremes(self.ratio, _ratio)}"
        met = {None: "", True: "yes", False: "no"}[self.met]
        return self.what, value, ratio, ", ".join(targets), met


def _number(value: float) -> str:
    """Return three digits or more of a number."""
    return f"{value:,.0f}" if abs(value) >= _SEVERAL_DIGITS else f"{value:.3g}"


def _ratio(value: float) -> str:
    return f"{value:.2f}"


def _extremes(value: float, shown: Callable[[float], str]) -> str:
    """Return the least and the most of several rounds, for behind the median."""
    if not isinstance(value, Spread) or value.least == value.most:
        return ""
    return f" ({shown(value.least)} … {shown(value.most)})"


def machine() -> str:
    """Return what the figures depend on: the machine, and the versions of what runs on it."""
    model = next(
        (line.partition(":")[2].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")),
        platform.processor() or platform.machine(),
    )
    packages = ", ".join(f"{package} {version(package)}" for package in _PACKAGES)
    system = f"{platform.system()} {platform.machine()}"
    return f"{os.cpu_count()} cores of {model}, {system}; Python {platform.python_version()}, {packages}"


def _lines(path: str) -> list[str]:
    file = Path(path)
    return file.read_text().splitlines() if file.exists() else []


def as_table(title: str, rows: Iterable[Row]) -> Table:
    """Return rows as a table for the terminal."""
    table = Table(title=title, title_justify="left")
    for heading in _HEAD:
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for row in rows:
        table.add_row(*row.cells, style=None if row.met is not False else "red")
    return table


def as_json(row: Row) -> dict[str, Any]:
    """Return a row as JSON values; of several rounds the median, and the least and the most beside it."""
    spreads = {name: figure for name in ("value", "ratio") if isinstance(figure := getattr(row, name), Spread)}
    extremes = {f"{name}_spread": [figure.least, figure.most] for name, figure in spreads.items()}
    return {**asdict(row), **extremes, "met": row.met}


def as_markdown(rows: Iterable[Row]) -> str:
    """Return rows as a table in Markdown."""
    lines = [_HEAD, ("---", *["---:"] * (len(_HEAD) - 1)), *(row.cells for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def write(path: Path, name: str, when: str, rows: Sequence[Row]) -> None:
    """Put a benchmark's rows into a document, with the date and the machine.

    Raises:
        ValueError: The document has no comments for this benchmark.
    """
    put(path, name, f"{when}: {machine()}.\n\n{as_markdown(rows)}")


def put(path: Path, name: str, text: str) -> None:
    """Put a text into a document, between the comments ``<!-- begin NAME -->`` and ``<!-- end NAME -->``.

    Raises:
        ValueError: The document has no such comments.
    """
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    head, began, rest = path.read_text().partition(begin)
    _, ended, tail = rest.partition(end)
    if not began or not ended:
        raise ValueError(f"{path}: no {begin} … {end} to write between")
    path.write_text(f"{head}{begin}\n{text}\n{end}{tail}")
