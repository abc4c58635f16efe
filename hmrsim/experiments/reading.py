"""The reader of an experiment's file, which reports all errors at once."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from hmrsim.diagnostics import Finding, instead
from hmrsim.documents.document import Document, read_document
from hmrsim.documents.valid_parts import Lost, valid_parts
from hmrsim.errors import ExperimentError, Problem, WorldError
from hmrsim.experiments.model import Design, ExperimentFile
from hmrsim.experiments.plan import DesignFlaw, Levels, Plan, scenarios_of
from hmrsim.trials.model import source_of
from hmrsim.world.formats import Document as WorldDocument
from hmrsim.world.merging import Source
from hmrsim.world.overlays.tables import read_rows, read_tables

RESERVED: Final = (
    *("number", "scenario", "treatment", "replication", "seed", "ending", "success", "cause", "at", "wall", "output"),
    *("reported", "fingerprint"),
)
"""The columns of results, whose names factors and measures can't have."""

_LEVELS: Final = "levels"
OF_NAMES: Final = ("tables", "levels", "factors", "design")
"""The keys of a file that the values of expressions depend on."""
_PARAMETERS: Final = "set"
"""The key of a variant that does not belong to its overlay."""
_UNNAMED: Final = "unnamed"
_STAND_INS: Final[Mapping[tuple[str, ...], Any]] = {
    ("name",): _UNNAMED,
    ("world",): "",
    ("treatments",): {_UNNAMED: {"python": ""}},
}
"""Values for missing or invalid ones, so that the rest of the file is checked."""


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
        plan: The experiment without the invalid parts; None if nothing else can be checked.
        problems: The errors, in the order of the lines.
        lost: The invalid parts of the file.
        worlds_known: Whether the worlds do not depend on the invalid parts.
    """

    document: Document
    plan: Plan | None
    problems: list[Problem]
    lost: Lost = Lost()
    worlds_known: bool = False


def read_valid_parts(path: str | Path, variants: Collection[str] = ()) -> Reading:
    """Return the valid parts of an experiment's file, as `read_plan`, so that they can be checked despite errors.

    Raises:
        ExperimentError: The file can't be read, or is not a mapping.
    """
    document = read_document(path, ExperimentError, "a mapping with name, world and treatments")
    valid = valid_parts(document.data, ExperimentFile, stand_ins=_STAND_INS)
    model, lost = valid.value, valid.lost
    findings = [*document.findings, *valid.findings]
    if model is None:
        return Reading(document, None, document.problems(findings))
    folder = Path(path).absolute().parent
    if lost.has(_UNNAMED, "treatments"):
        model = model.model_copy(update={"treatments": {}})
    tables = _tables(model, folder, findings)
    scenarios = () if lost.touches("design", "factors") else _scenarios(model, folder, findings)
    if not scenarios:
        lost = Lost({**lost.names, "factors": None})
        scenarios = [{}]
    findings += _names(model, tables, lost)
    chosen = [name for name in variants if name in model.variants]
    findings += [
        Finding(("variants",), f"there is no variant {name!r}{instead(name, model.variants)}", name)
        for name in variants
        if name not in chosen and not lost.has(name, "variants")
    ]
    known = not lost.touches(*OF_NAMES)
    overlays = [_overlay(document, ("overlay",), known=known)] if model.overlay else []
    overlays += [_overlay(document, ("variants", name), known=known) for name in chosen]
    own = {
        name: _overlay(document, ("treatments", name, "overlay"), known=known)
        for name, treatment in model.treatments.items()
        if treatment.overlay
    }
    world = source_of(model.world, folder)
    model = _with_parameters(model, chosen)
    plan = Plan(Path(path).absolute(), model, scenarios, overlays, tables, world, tuple(chosen), own)
    touched = lost.touches(*OF_NAMES, "world", "overlay") or any(lost.has(name, "variants") for name in variants)
    changes = lost.touches("treatments") and "overlay" in str(document.data.get("treatments"))
    return Reading(document, plan, document.problems(findings), lost, worlds_known=not (touched or changes))


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


def _overlay(document: Document, path: tuple[str, ...], *, known: bool) -> Source:
    """Return the overlay at a path; without the changes that use names, unless these are *known*."""
    data = document.data
    for step in path:
        data = data[step]
    if path[0] == "variants":
        data = {key: value for key, value in data.items() if key != _PARAMETERS}
    if not known:
        data = _without_names(data)
    return Source(document.file, WorldDocument(data, lambda inner: document.line((*path, *inner))))


def _without_names(changes: Mapping[str, Any]) -> dict[str, Any]:
    kept = {key: _without_names(value) if isinstance(value, dict) else value for key, value in changes.items()}
    return {key: value for key, value in kept.items() if "$" not in f"{key} {value}"}


def _tables(model: ExperimentFile, folder: Path, findings: list[Finding]) -> dict[str, Any]:
    named = dict(model.tables)
    if model.levels is not None:
        named[_LEVELS] = model.levels
    tables, _, wrong = read_tables(named, folder)
    findings += [each if each.path == (_LEVELS,) else each.within("tables") for each in wrong]
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


def _names(model: ExperimentFile, tables: Mapping[str, Any], lost: Lost) -> Iterator[Finding]:
    """Yield an error for each ambiguous or unknown name, except those that are *lost*."""
    seen: dict[str, str] = dict.fromkeys(RESERVED, "a column of the results")
    seen |= dict.fromkeys(tables, "a table")
    for key, names in (("factors", model.factors), ("measures", model.measures)):
        for name in names:
            if name in seen:
                message = f"{name!r} is {seen[name]} already; give another name"
                yield Finding((key, name), message, name)
            seen[name] = f"one of the {key}"
    until = model.replications.until
    if until is not None and until.decided and len(model.treatments) == 1 and not lost.touches("treatments"):
        message = "there is one treatment, and nothing to decide; give relative_error"
        yield Finding(("replications", "until", "decided"), message)
    if until is not None and until.measure not in model.measures and not lost.has(until.measure, "measures"):
        message = f"there is no measure {until.measure!r}{instead(until.measure, model.measures)}"
        yield Finding(("replications", "until", "measure"), message, until.measure)
