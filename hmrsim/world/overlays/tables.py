"""Named tables that overlays take values from: YAML, JSON or CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import Finding, dotted, shown
from hmrsim.errors import Problem, WorldError
from hmrsim.world.files import read_text
from hmrsim.world.formats._json_text import as_yaml
from hmrsim.world.yaml_text import Unreadable, plain, read

if TYPE_CHECKING:
    from pathlib import Path


def read_table(path: Path, file: str) -> Any:
    """Return the content of a table.

    A CSV file becomes a mapping of its rows: the first column is the key of a row, which is a mapping of the others by
    the names in the first line. Numbers are read as in YAML.

    Args:
        path: The file.
        file: Its name as the user knows it, for errors.

    Raises:
        WorldError: It can't be read.
    """
    text = read_text(path, file)
    if path.suffix.lower() == ".csv":
        return _rows(text, file)
    try:
        value, _, findings = read(as_yaml(text) if text.lstrip().startswith(("{", "[")) else text)
    except Unreadable as error:
        raise WorldError([Problem(file, "", str(error), error.line)]) from None
    if findings:
        raise WorldError([Problem(file, dotted(each.path), each.message, each.line) for each in findings])
    return value


def as_rows(table: Any) -> list[dict[str, Any]]:
    """Return a table as rows, of which the key of a row is no part; empty if it is no table.

    A list of mappings is one, and a mapping of them; a CSV file's rows are read by `read_rows` with all columns.
    """
    rows = [*table.values()] if isinstance(table, Mapping) else table
    if not isinstance(rows, (list, tuple)) or not all(isinstance(row, Mapping) for row in rows):
        return []
    return [dict(row) for row in rows]


def read_rows(path: Path, file: str) -> Any:
    """Return the rows of a CSV file with all columns, or what `read_table` returns of another.

    Raises:
        WorldError: It can't be read.
    """
    if path.suffix.lower() != ".csv":
        return read_table(path, file)
    return [{name: plain(field) for name, field in row.items()} for _, row in _csv(read_text(path, file), file)]


def read_tables(said: object, folder: Path) -> tuple[dict[str, Any], list[Path], list[Finding]]:
    """Return the tables that a file names, each ``name: file``, their files, and what is wrong with them.

    Args:
        said: What stands under ``tables``; a table may also be written out there.
        folder: That of the file, from which the files of tables are looked for.
    """
    if not isinstance(said, Mapping):
        return {}, [], [Finding((), f"expected a mapping of names to files, got {shown(said)}", said)]
    tables: dict[str, Any] = {}
    files: list[Path] = []
    findings: list[Finding] = []
    for name, source in said.items():
        if isinstance(source, (dict, list)):
            tables[name] = source
        elif not isinstance(source, str) or not name.isidentifier():
            message = f"expected a name of letters, digits and _ with a file, got {shown(name)}: {shown(source)}"
            findings.append(Finding((name,), message, source))
        else:
            path = folder / source
            files.append(path.absolute())
            try:
                tables[name] = read_table(path, str(path))
            except WorldError as error:
                findings += [Finding((name,), str(problem), source) for problem in error.problems]
    return tables, files, findings


def _rows(text: str, file: str) -> dict[str, dict[str, object]]:
    rows: dict[str, dict[str, object]] = {}
    for line, row in _csv(text, file):
        first, *names = row
        key = row[first]
        if key in rows:
            message = f"there is a row {shown(key)} already; the first column is the key"
            raise WorldError([Problem(file, "", message, line)])
        rows[key] = {name: plain(row[name]) for name in names}
    return rows


def _csv(text: str, file: str) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield the rows of a CSV file, with their lines."""
    reader = csv.reader(io.StringIO(text), strict=True)
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
