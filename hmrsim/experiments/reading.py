"""The reader of an experiment's file, which reports all errors at once."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from pydantic import BaseModel, ValidationError

from hmrsim.diagnostics import Finding, instead
from hmrsim.documents.document import Document, read_document
from hmrsim.documents.validation import explain
from hmrsim.errors import ExperimentError, Problem, WorldError
from hmrsim.experiments.model import (
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
    Variant,
)
from hmrsim.experiments.plan import DesignFlaw, Levels, Plan, scenarios_of
from hmrsim.trials.model import source_of
from hmrsim.world.formats import Document as WorldDocument
from hmrsim.world.merging import Source
from hmrsim.world.overlays.tables import read_rows, read_tables

_PARTS: Final[Mapping[tuple[str, ...], type[BaseModel]]] = {
    (): ExperimentFile,
    ("factors", "*"): Range,
    ("design",): Design,
    ("treatments", "*"): Treatment,
    ("variants", "*"): Variant,
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
    *("reported", "fingerprint"),
)
"""The columns of results, whose names factors and measures can't have."""

_LEVELS: Final = "levels"
_PARAMETERS: Final = "set"
"""The key of a variant that does not belong to its overlay."""
_OF_NAMES: Final = ("tables", "factors", "treatments", "variants", "ends", "measures")
"""The keys with independent entries, so that an invalid one does not affect the others."""


def read_plan(path: str | Path, variants: Collection[str] = ()) -> Plan:
    """Return the plan of an experiment's file, with variants laid over the world in the given order.

    Raises:
        ExperimentError: The file is invalid; it has all errors of the file itself.
    """
    reading = read_valid_parts(path, variants)
    if reading.problems or reading.plan is None:
        raise ExperimentError(reading.problems)
    return reading.plan


class Reading(NamedTuple):
    """The valid parts of an experiment's file, and its errors.

    Attributes:
        document: The file.
        plan: The experiment without the invalid parts; None if nothing else can be checked.
        problems: The errors, in the order of the lines.
        lost: The keys of the file that have invalid parts.
    """

    document: Document
    plan: Plan | None
    problems: list[Problem]
    lost: Collection[str] = ()


def read_valid_parts(path: str | Path, variants: Collection[str] = ()) -> Reading:
    """Return the valid parts of an experiment's file, as `read_plan`, so that they can be checked despite errors.

    Raises:
        ExperimentError: The file can't be read, or is not a mapping.
    """
    document = read_document(path, ExperimentError, "a mapping with name, world and treatments")
    findings = [*document.findings]
    model, lost = _model(document.data, findings)
    if model is None:
        return Reading(document, None, document.problems(findings))
    folder = Path(path).absolute().parent
    tables = _tables(model, folder, findings)
    scenarios = () if "design" in lost or "factors" in lost else _scenarios(model, folder, findings)
    if not scenarios:
        lost.add("factors")
    findings += _names(model, tables, lost)
    chosen = [name for name in variants if name in model.variants]
    findings += [
        Finding(("variants",), f"there is no variant {name!r}{instead(name, model.variants)}", name)
        for name in variants
        if name not in chosen and "variants" not in lost
    ]
    overlays = [_overlay(document, ("overlay",))] if model.overlay else []
    overlays += [_overlay(document, ("variants", name)) for name in chosen]
    own = {
        name: _overlay(document, ("treatments", name, "overlay"))
        for name, treatment in model.treatments.items()
        if treatment.overlay
    }
    world = source_of(model.world, folder)
    model = _with_parameters(model, chosen)
    plan = Plan(Path(path).absolute(), model, scenarios, overlays, tables, world, tuple(chosen), own)
    return Reading(document, plan, document.problems(findings), lost)


def _model(data: dict[str, Any], findings: list[Finding]) -> tuple[ExperimentFile | None, set[str]]:
    """Return the model of a file without its invalid parts, and the keys that have some; add errors to *findings*."""
    try:
        return ExperimentFile.model_validate(data), set()
    except ValidationError as error:
        errors = explain(error, data, _PARTS)
    findings += errors
    left = dict(data)
    lost: set[str] = set()
    for key, *below in (finding.path for finding in errors if finding.path):
        lost.add(str(key))
        if key in _OF_NAMES and below and isinstance(left.get(key), dict):
            left[key] = {name: value for name, value in left[key].items() if name != below[0]}
        else:
            left.pop(str(key), None)
    instead_of_lost = {"name": "unnamed", "world": "", "treatments": {"unnamed": {"python": ""}}}
    missing = {key: value for key, value in instead_of_lost.items() if not left.get(key)}
    try:
        model = ExperimentFile.model_validate({**left, **missing})
    except ValidationError:
        return None, lost
    return (model.model_copy(update={"treatments": {}}) if "treatments" in missing else model), lost


def _with_parameters(model: ExperimentFile, variants: Collection[str]) -> ExperimentFile:
    """Return a file whose treatments have the parameters of the chosen variants."""
    further = {name: value for variant in variants for name, value in model.variants[variant].set.items()}
    if not further:
        return model
    treatments = {
        name: treatment.model_copy(update={"set": {**treatment.set, **further}})
        for name, treatment in model.treatments.items()
    }
    return model.model_copy(update={"treatments": treatments})


def _overlay(document: Document, path: tuple[str, ...]) -> Source:
    data = document.data
    for step in path:
        data = data[step]
    if path[0] == "variants":
        data = {key: value for key, value in data.items() if key != _PARAMETERS}
    return Source(document.file, WorldDocument(data, lambda inner: document.line((*path, *inner))))


def _tables(model: ExperimentFile, folder: Path, findings: list[Finding]) -> dict[str, Any]:
    named = dict(model.tables)
    if model.levels is not None:
        named[_LEVELS] = model.levels
    tables, _, wrong = read_tables(named, folder)
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
            trials = read_rows(path)
        return scenarios_of(model, trials)
    except DesignFlaw as flaw:
        findings.append(Finding((flaw.key,), str(flaw)))
    except WorldError as error:
        findings += [Finding(("design", "list"), str(problem)) for problem in error.problems]
    return ()


def _names(model: ExperimentFile, tables: Mapping[str, Any], lost: Collection[str]) -> Iterator[Finding]:
    """Yield an error for each ambiguous or unknown name, except below keys that are *lost*."""
    seen: dict[str, str] = dict.fromkeys(RESERVED, "a column of the results")
    seen |= dict.fromkeys(tables, "a table")
    for key, names in (("factors", model.factors), ("measures", model.measures)):
        for name in names:
            if name in seen:
                message = f"{name!r} is {seen[name]} already; give another name"
                yield Finding((key, name), message, name)
            seen[name] = f"one of the {key}"
    until = model.replications.until
    if until is not None and until.decided and len(model.treatments) == 1 and "treatments" not in lost:
        message = "there is one treatment, and nothing to decide; give relative_error"
        yield Finding(("replications", "until", "decided"), message)
    if until is not None and until.measure not in model.measures and "measures" not in lost:
        message = f"there is no measure {until.measure!r}{instead(until.measure, model.measures)}"
        yield Finding(("replications", "until", "measure"), message, until.measure)
