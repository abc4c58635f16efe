"""Reading the file of an experiment, with all that is wrong in it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ValidationError

from hmrsim.diagnostics import Finding, instead, problems_of, shown
from hmrsim.errors import ExperimentError, Problem, WorldError
from hmrsim.experiments.file.designs import DesignFlaw, Levels, scenarios_of
from hmrsim.experiments.file.model import (
    Design,
    Ending,
    ExperimentFile,
    Keep,
    Limits,
    Measure,
    Range,
    Replications,
    Treatment,
    Until,
)
from hmrsim.experiments.file.plan import Plan
from hmrsim.world.files import read_text
from hmrsim.world.formats import Document
from hmrsim.world.merging import Source
from hmrsim.world.overlays.tables import read_rows, read_tables
from hmrsim.world.yaml_text import Unreadable, line_of, read
from hmrsim.world_checks.explain import explain

_PARTS: Final[Mapping[tuple[str, ...], type[BaseModel]]] = {
    (): ExperimentFile,
    ("factors", "*"): Range,
    ("design",): Design,
    ("treatments", "*"): Treatment,
    ("replications",): Replications,
    ("replications", "until"): Until,
    ("limits",): Limits,
    ("ends", "*"): Ending,
    ("ends", "*", "*"): Ending,
    ("measures", "*"): Measure,
    ("keep",): Keep,
}

RESERVED: Final = (
    *("number", "scenario", "treatment", "replication", "seed", "ending", "success", "cause", "at", "wall", "output"),
    "reported",
)
"""The columns of results, which no factor and no measure may be called."""

_LEVELS: Final = "levels"


def read_plan(path: str | Path, variants: Collection[str] = ()) -> Plan:
    """Return the plan of an experiment's file.

    Args:
        path: The file, YAML or JSON.
        variants: The names of the variants to lay over the world, in this order.

    Raises:
        ExperimentError: Something is wrong; it has all errors of the file itself.
    """
    file = str(path)
    try:
        text = read_text(Path(path), file)
        data, lines, twice = read(text)
    except WorldError as error:
        raise ExperimentError(error.problems) from None
    except Unreadable as error:
        raise ExperimentError([Problem(file, "", str(error), error.line)]) from None
    if not isinstance(data, dict):
        raise ExperimentError(
            [Problem(file, "", f"expected a mapping with name, world and treatments, got {shown(data)}")]
        )
    line = partial(line_of, lines)
    findings = list(twice)
    try:
        model = ExperimentFile.model_validate(data)
    except ValidationError as error:
        findings += explain(error, data, parts=_PARTS)
        raise ExperimentError(problems_of(findings, file, line)) from None
    folder = Path(path).absolute().parent
    tables = _tables(model, folder, findings)
    scenarios = _scenarios(model, folder, findings)
    findings += _names(model, tables)
    findings += [
        Finding(("variants",), f"there is no variant {name!r}{instead(name, model.variants)}", name)
        for name in variants
        if name not in model.variants
    ]
    if findings:
        raise ExperimentError(problems_of(findings, file, line))
    overlays = [_overlay(file, data, ("overlay",), line)] if model.overlay else []
    overlays += [_overlay(file, data, ("variants", name), line) for name in variants]
    return Plan(Path(path).absolute(), model, scenarios, overlays, tables, _world(model.world, folder), tuple(variants))


def _world(source: str, folder: Path) -> str:
    """Return the path of a world's file, or the name of a shipped world."""
    beside = folder / source
    return str(beside) if beside.is_file() or Path(source).suffix else source


def _overlay(file: str, data: Any, path: tuple[str, ...], line: Callable[..., int | None]) -> Source:
    for step in path:
        data = data[step]
    return Source(file, Document(data, lambda inner: line((*path, *inner))))


def _tables(model: ExperimentFile, folder: Path, findings: list[Finding]) -> dict[str, Any]:
    said = dict(model.tables)
    if model.levels is not None:
        said[_LEVELS] = model.levels
    tables, _, wrong = read_tables(said, folder)
    findings += [
        Finding(each.path if each.path == (_LEVELS,) else ("tables", *each.path), each.message, each.value)
        for each in wrong
    ]
    return tables


def _scenarios(model: ExperimentFile, folder: Path, findings: list[Finding]) -> Sequence[Levels]:
    trials = None
    try:
        if isinstance(model.design, Design) and isinstance(model.design.list, str):
            path = folder / model.design.list
            trials = read_rows(path, str(path))
        return scenarios_of(model, trials)
    except DesignFlaw as flaw:
        findings.append(Finding((flaw.key,), str(flaw)))
    except WorldError as error:
        findings += [Finding(("design", "list"), str(problem)) for problem in error.problems]
    return ()


def _names(model: ExperimentFile, tables: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield an error for each name that means two things, and for measures that are not there."""
    seen: dict[str, str] = dict.fromkeys(RESERVED, "a column of the results")
    seen |= dict.fromkeys(tables, "a table")
    for key, names in (("factors", model.factors), ("measures", model.measures)):
        for name in names:
            if name in seen:
                message = f"{name!r} is {seen[name]} already; give another name"
                yield Finding((key, name), message, name)
            seen[name] = f"one of the {key}"
    until = model.replications.until
    if until is not None and until.decided and len(model.treatments) == 1:
        message = "there is one treatment, and nothing to decide; give relative_error"
        yield Finding(("replications", "until", "decided"), message)
    if until is not None and until.measure not in model.measures:
        message = f"there is no measure {until.measure!r}{instead(until.measure, model.measures)}"
        yield Finding(("replications", "until", "measure"), message, until.measure)
