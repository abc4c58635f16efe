"""The table of runs for other programs: CSV, JSON, Parquet."""

from __future__ import annotations

import csv
import importlib
import json
from typing import TYPE_CHECKING, Any, TextIO

from hmrsim.errors import MissingExtra, OutputError, reason_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.experiments.results.store import Results

FORMATS = (".csv", ".json", ".parquet")
"""What a file's name may end in."""


def write_table(results: Results, path: Path) -> None:
    """Write all runs, in order of their numbers.

    Raises:
        OutputError: The file can't be written, or is of no known format.
        MissingExtra: Parquet needs pyarrow, which is not installed.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise OutputError(f"{path}: is of no known format; expected one of {', '.join(FORMATS)}")
    try:
        if kind == ".parquet":
            _write_parquet(results, path)
            return
        with path.open("w", encoding="utf-8", newline="") as file:
            write_csv(results, file) if kind == ".csv" else write_json(results, file)
    except OSError as error:
        raise OutputError(f"{path}: can't be written: {reason_of(error)}") from None


def write_csv(results: Results, file: TextIO) -> None:
    """Write all runs as CSV; what has no value is empty."""
    writer = csv.DictWriter(file, results.columns(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(results.rows())


def write_json(results: Results, file: TextIO) -> None:
    """Write all runs as one JSON list, a run a line."""
    begin = "["
    for row in results.rows():
        file.write(f"{begin}\n{json.dumps(_plain(row))}")
        begin = ","
    file.write("]\n" if begin == "," else "[]\n")


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    return {**row, "success": bool(row["success"]), "reported": json.loads(row["reported"])}


def _write_parquet(results: Results, path: Path) -> None:
    try:
        arrow: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtra("Parquet needs pyarrow; install hmrsim[parquet]") from None
    table = arrow.Table.from_pylist([*results.rows()])
    parquet.write_table(table, path)
