"""Tables of values for overlays, in YAML, JSON or CSV files."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import Finding, shown
from hmrsim.documents.document import read_document, read_text
from hmrsim.documents.yaml_text import plain
from hmrsim.errors import Problem, WorldError

if TYPE_CHECKING:
    from pathlib import Path


def read_table(path: Path) -> Any:
    """Return the content of a table file.

    A CSV file becomes a mapping of its rows by their first column. Each row is a mapping of the other columns by their
    names in the first line. Numbers are read as in YAML.

    Raises:
        WorldError: The file can't be read.
    """
    if path.suffix.lower() == ".csv":
        return _rows(path)
    document = read_document(path, WorldError)
    document.raise_for()
    return document.data


def as_rows(table: Any) -> list[dict[str, Any]]:
    """Return the mappings in a list, or in a mapping without its keys, as rows; an empty list for other values."""
    rows = [*table.values()] if isinstance(table, Mapping) else table
    if not isinstance(rows, (list, tuple)) or not all(isinstance(row, Mapping) for row in rows):
        return []
    return [dict(row) for row in rows]


def read_rows(path: Path) -> Any:
    """Return the rows of a CSV file with all columns, or the content of another table, as `read_table` does.

    Raises:
        WorldError: The file can't be read.
    """
    if path.suffix.lower() != ".csv":
        return read_table(path)
    return [{name: plain(field) for name, field in row.items()} for _, row in _csv(path)]


def read_tables(named: object, folder: Path) -> tuple[dict[str, Any], list[Path], list[Finding]]:
    """Return the tables that a document names, the files that were read, and the errors.

    Args:
        named: The value of the key ``tables``: for each name a file, or the table itself.
        folder: The folder of the document, to which the paths of tables are relative.
    """
    if not isinstance(named, Mapping):
        return {}, [], [Finding((), f"expected a mapping of names to files, got {shown(named)}", named)]
    tables: dict[str, Any] = {}
    files: list[Path] = []
    findings: list[Finding] = []
    for name, source in named.items():
        if isinstance(source, (dict, list)):
            tables[name] = source
        elif not isinstance(source, str) or not name.isidentifier():
            message = f"expected a name of letters, digits and _ with a file, got {shown(name)}: {shown(source)}"
            findings.append(Finding((name,), message, source))
        else:
            path = folder / source
            files.append(path.absolute())
            try:
                tables[name] = read_table(path)
            except WorldError as error:
                findings += [Finding((name,), str(problem), source) for problem in error.problems]
    return tables, files, findings


def _rows(path: Path) -> dict[str, dict[str, object]]:
    rows: dict[str, dict[str, object]] = {}
    for line, row in _csv(path):
        first, *names = row
        key = row[first]
        if key in rows:
            message = f"there is a row {shown(key)} already; the first column is the key"
            raise WorldError([Problem(str(path), "", message, line)])
        rows[key] = {name: plain(row[name]) for name in names}
    return rows


def _csv(path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield each row of a CSV file, with its line number."""
    file = str(path)
    reader = csv.reader(io.StringIO(read_text(path, file)), strict=True)
    try:
        header = next(reader, [])
        if not header:
            raise WorldError([Problem(file, "", "is empty; expected a line with the names of the columns", 1)])
        if len({*header}) < len(header):
            raise WorldError([Problem(file, "", "two columns have the same name; give one of the two another", 1)])
        for row in reader:
            if row and len(row) != len(header):
                message = f"the row has {len(row)} fields, the first line {len(header)}"
                raise WorldError([Problem(file, "", message, reader.line_num)])
            if row:
                yield reader.line_num, dict(zip(header, row, strict=True))
    except csv.Error as error:
        raise WorldError([Problem(file, "", f"is not CSV: {error}", reader.line_num)]) from None
