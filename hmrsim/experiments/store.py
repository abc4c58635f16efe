"""The results of an experiment in one SQLite file: a table of runs, and a description of the experiment."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import platform
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import IO, TYPE_CHECKING, Any, Final, Self

from hmrsim import __version__
from hmrsim.errors import OutputError, ResultsError, WriteError, reason_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.experiments.measures import Value
    from hmrsim.experiments.plan import Plan, Run


FILE: Final = "results.sqlite"
"""The name of the file in the folder of an experiment's results."""
TRACES: Final = "traces"
"""The folder of the traces that are kept."""

_NOTHING: Final[Mapping[str, bytes]] = MappingProxyType({})
_COVERAGE: Final = "coverage (treatment TEXT PRIMARY KEY, counts BLOB NOT NULL)"
_FORMAT: Final = 2
_FIXED: Final = {
    "number": "INTEGER PRIMARY KEY",
    "scenario": "INTEGER NOT NULL",
    "treatment": "TEXT NOT NULL",
    "replication": "INTEGER NOT NULL",
    "seed": "INTEGER NOT NULL",
}
_JUDGED: Final = {
    "ending": "TEXT NOT NULL",
    "success": "INTEGER NOT NULL",
    "cause": "TEXT NOT NULL",
    "at": "REAL",
    "wall": "REAL NOT NULL",
    "reported": "TEXT NOT NULL",
    "output": "TEXT NOT NULL",
    "fingerprint": "TEXT NOT NULL",
}


@dataclass(frozen=True)
class Row:
    """The result of a run.

    Attributes:
        ending: Its ending: a label of the file, ``succeeded`` or ``failed`` by the controller, or another one of
            `hmrsim.trials.trial`.
        cause: Details that the ending lacks, such as an error. May be empty.
        at: The time of its end, in simulated seconds; None if it did not begin.
        wall: The wall seconds that it took.
        measures: The measures, by name; None for a missing value.
        reported: The values that controllers have reported.
        output: The last lines that the controller printed.
        trace: The trace, if it is kept.
        fingerprint: Equal to that of another replication if both are the same run; empty if the simulator drew random
            numbers, or there is only one replication.
        coverage: The packed coverage of its trees, if it is kept.
    """

    run: Run
    ending: str
    cause: str = ""
    success: bool = False
    at: float | None = None
    wall: float = 0.0
    measures: Mapping[str, Value] = field(default_factory=dict)
    reported: Mapping[str, Any] = field(default_factory=dict)
    output: str = ""
    trace: str = ""
    fingerprint: str = ""
    coverage: bytes = b""


class Results:
    """The results of an experiment: a folder with one SQLite file, to which one process at a time adds rows.

    Attributes:
        about: The experiment: its name, file, hash, factors, measures, treatments and versions.

    Raises:
        ResultsError: There are none, or they can't be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._path = folder / FILE
        if not self._path.is_file():
            raise ResultsError(f"{folder}: there are no results; `hmrsim experiment run FILE -o {folder}` makes them")
        with ExitStack() as unless_it_is_read:
            try:
                self._db = unless_it_is_read.enter_context(closing(sqlite3.connect(self._path)))
                rows = self._db.execute("SELECT key, value FROM about").fetchall()
            except sqlite3.Error as error:
                raise ResultsError(f"{self._path}: can't be read: {error}") from None
            self.about: dict[str, Any] = {key: json.loads(value) for key, value in rows}
            if self.about.get("format") != _FORMAT:
                raise ResultsError(
                    f"{self._path}: is of format {self.about.get('format')}, and this version reads {_FORMAT};"
                    " run the experiment in another folder"
                )
            unless_it_is_read.pop_all()

    @classmethod
    def create(cls, folder: Path, plan: Plan) -> Results:
        """Return the results of a plan, with the existing rows if it was started before.

        Raises:
            ResultsError: The folder has results of another experiment.
            OutputError: The folder can't be written.
        """
        path = folder / FILE
        if path.is_file():
            found = cls(folder)
            if found.about["hash"] != plan.hash:
                found.close()
                raise ResultsError(
                    f"{folder}: has results of another experiment, or of this file as it was; choose another folder"
                )
            if changed := found.changed(plan):
                found.close()
                raise ResultsError(
                    f"{folder}: has results from before {changed} was changed, with which others can't be compared;"
                    " choose another folder"
                )
            return found
        begun = folder / f"{FILE}.new"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            begun.unlink(missing_ok=True)
            with closing(sqlite3.connect(begun)) as db, db:
                db.execute("CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT NOT NULL)")
                db.executemany("INSERT INTO about VALUES (?, ?)", [(k, json.dumps(v)) for k, v in _about(plan).items()])
                columns = [f"{_quoted(name)} {kind}" for name, kind in _columns(plan).items()]
                db.execute(f"CREATE TABLE runs ({', '.join(columns)})")
            begun.rename(path)
        except (OSError, sqlite3.Error) as error:
            why = reason_of(error) if isinstance(error, OSError) else error
            raise OutputError(f"{folder}: results can't be written: {why}") from None
        return cls(folder)

    def changed(self, plan: Plan) -> str:
        """Return the world or the file of a controller that has changed since the first run; "" if none has.

        The imports of these files are not included.
        """
        if self.about["world"] != plan.world(0).hash:
            return "the world"
        before, now = self.about.get("controllers", {}), _controllers(plan)
        return next((name for name, digest in before.items() if now.get(name, digest) != digest), "")

    def __enter__(self) -> Self:
        """Return the results."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close the file."""
        self.close()

    def close(self) -> None:
        """Close the file; later queries raise an error."""
        self._db.close()

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Keep other processes from adding rows.

        Raises:
            ResultsError: Another process is adding rows.
        """
        with self._lock() as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise ResultsError(f"{self.folder}: another process runs this experiment") from None
            self._db.execute("PRAGMA journal_mode=WAL")
            self._db.execute("PRAGMA synchronous=NORMAL")
            yield

    def _lock(self) -> IO[bytes]:
        """Return the lock file, without following a link, whose target would be emptied.

        Raises:
            ResultsError: It can't be opened.
        """
        path = self.folder / "lock"
        try:
            return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666), "wb")
        except OSError as error:
            raise ResultsError(f"{path}: can't be opened for writing: {reason_of(error)}") from None

    def add(self, plan: Plan, rows: Iterable[Row], coverages: Mapping[str, bytes] = _NOTHING) -> None:
        """Add the results of runs, all or none of them.

        *coverages* is the coverage of the trees including these runs, by treatment, if it is kept.

        Raises:
            WriteError: They can't be written, for example on a full disk.
        """
        names = [*_columns(plan)]
        insert = f"INSERT INTO runs VALUES ({', '.join('?' * len(names))})"  # noqa: S608 - question marks
        values = [self._values(plan, row) for row in rows]
        try:
            with self._db:
                self._db.executemany(insert, [[each[name] for name in names] for each in values])
                if coverages:
                    self._db.execute(f"CREATE TABLE IF NOT EXISTS {_COVERAGE}")
                    self._db.executemany("INSERT OR REPLACE INTO coverage VALUES (?, ?)", coverages.items())
        except sqlite3.Error as error:
            raise WriteError(
                f"{self._path}: results can't be written: {error}; those before are kept, and the same command goes on"
            ) from None

    def _values(self, plan: Plan, row: Row) -> dict[str, Any]:
        run, cause = row.run, row.cause
        if row.trace and (why := self._keep(row)):
            cause = "; ".join(filter(None, [cause, f"its trace can't be kept: {why}"]))
        return {
            "number": run.number,
            "scenario": run.scenario,
            "treatment": run.treatment,
            "replication": run.replication,
            "seed": run.seed,
            **plan.scenarios[run.scenario],
            **{name: row.measures.get(name) for name in plan.file.measures},
            "ending": row.ending,
            "success": int(row.success),
            "cause": cause,
            "at": row.at,
            "wall": row.wall,
            "reported": json.dumps(dict(row.reported), sort_keys=True),
            "output": row.output,
            "fingerprint": row.fingerprint,
        }

    def _keep(self, row: Row) -> str:
        """Write the trace of a run; return the reason if that fails, else ""."""
        folder = self.folder / TRACES
        path = folder / f"{row.run.number}.jsonl"
        try:
            folder.mkdir(exist_ok=True)
            path.write_text(row.trace, encoding="utf-8")
        except OSError as error:
            with suppress(OSError):
                path.unlink()
            return reason_of(error)
        return ""

    def coverages(self) -> dict[str, bytes]:
        """Return the packed coverage of the trees, by treatment."""
        if not self._db.execute("SELECT 1 FROM sqlite_master WHERE name = 'coverage'").fetchone():
            return {}
        return dict(self._db.execute("SELECT treatment, counts FROM coverage ORDER BY treatment"))

    def numbers(self) -> set[int]:
        """Return the numbers of the runs that have a result."""
        return {number for (number,) in self._db.execute("SELECT number FROM runs")}

    def columns(self) -> list[str]:
        """Return the names of the columns."""
        return [row[1] for row in self._db.execute("PRAGMA table_info(runs)")]

    def rows(
        self, columns: Sequence[str] | None = None, where: Mapping[str, Any] | None = None
    ) -> Iterator[dict[str, Any]]:
        """Yield rows in order of their numbers, one at a time, with all columns by default.

        *where* has the values that columns must have.
        """
        names = [*(self.columns() if columns is None else columns)]
        wanted = where or {}
        condition = " AND ".join(f"{_quoted(name)} IS ?" for name in wanted)
        query = f"SELECT {', '.join(map(_quoted, names))} FROM runs{f' WHERE {condition}' if condition else ''}"  # noqa: S608 - quoted names
        for row in self._db.execute(query + " ORDER BY number", [*wanted.values()]):
            yield dict(zip(names, row, strict=True))

    def count(self, by: str) -> dict[Any, int]:
        """Return the number of rows for each value of a column."""
        query = f"SELECT {_quoted(by)}, COUNT(*) FROM runs GROUP BY 1 ORDER BY 2 DESC, 1"  # noqa: S608 - a quoted name
        return dict(self._db.execute(query))


def _columns(plan: Plan) -> dict[str, str]:
    factors = dict.fromkeys(plan.scenarios[0] if plan.scenarios else (), "")
    return {**_FIXED, **factors, **_JUDGED, **dict.fromkeys(plan.file.measures, "REAL")}


def _about(plan: Plan) -> dict[str, Any]:
    file = plan.file
    return {
        "format": _FORMAT,
        "name": file.name,
        "hash": plan.hash,
        "path": str(plan.path),
        "text": plan.path.read_text(encoding="utf-8"),
        "variant": list(plan.variant),
        "world": plan.world(0).hash,
        "factors": list(plan.scenarios[0]) if plan.scenarios else [],
        "scenarios": len(plan.scenarios),
        "treatments": list(file.treatments),
        "controllers": _controllers(plan),
        "measures": {name: measure.model_dump() for name, measure in file.measures.items()},
        "replications": file.replications.model_dump(),
        "hmrsim": __version__,
        "python": platform.python_version(),
        "host": platform.node(),
    }


def _controllers(plan: Plan) -> dict[str, str]:
    """Return the SHA-256 of each file that the treatments name, by its name."""
    found: dict[str, str] = {}
    for treatment in plan.treatments.values():
        name = (treatment.tree or treatment.python or "").partition(":")[0]
        path = plan.path.parent / name
        if name and path.is_file():
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'
