"""The reader of files of checks and failures, which reports all errors at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from hmrsim.diagnostics import Finding, in_order, instead, meant
from hmrsim.documents.document import Document, no_line, read_document
from hmrsim.documents.valid_parts import Lost, valid_parts
from hmrsim.errors import CheckError, HmrsimError, Problem, PropertyError, WorldError
from hmrsim.fault_search.candidates import expanded
from hmrsim.fault_search.check import Check, CheckFile, Failed, ReproFile, Space
from hmrsim.fault_search.kinds import CHANGES, DISTURBANCES
from hmrsim.fault_search.schedule import DISTURBANCE, FAULT, Case, Schedule, read_injections
from hmrsim.faults import registry as faults
from hmrsim.properties import Properties, check_properties
from hmrsim.properties.model.file import read_valid_properties, valid_properties
from hmrsim.trials.controllers import controller_of
from hmrsim.trials.disturbances import Disturbance
from hmrsim.trials.model import Controller, source_of
from hmrsim.world_checks.faults import check_faults, check_pattern, there_in

if TYPE_CHECKING:
    from hmrsim.world.model import World

M = TypeVar("M", bound=CheckFile)

COMMAND_LINE: Final = "command line"

DEFAULT_LIMIT: Final = 3600.0
"""The limit of the run without faults in simulated seconds, if a check sets none."""

_STAND_INS: Final[Mapping[tuple[str, ...], Any]] = {("world",): "", ("controller",): {"python": ""}}
"""Values for a missing or invalid world and controller, so that the rest of the file is checked."""


@dataclass(frozen=True)
class Repro:
    """A failure that a search found.

    Attributes:
        trace: SHA-256 of the trace of the run that found it; empty if unknown.
    """

    check: Check
    case: Case
    failure: Failed
    trace: str


class _Valid(NamedTuple):
    """The valid parts of the file of a check, and the errors of the others."""

    model: CheckFile
    findings: Sequence[Finding] = ()
    lost: Lost = Lost()


def read_check(path: str | Path) -> Check:
    """Return the check of a file.

    Raises:
        CheckError: The file is invalid; it has all errors.
    """
    document = _read(path)
    folder = Path(path).absolute().parent
    return _checked(document, _valid(document), folder, folder)


def file_of(values: dict[str, Any], place: str = COMMAND_LINE) -> CheckFile:
    """Return the values of a command line, or a test, as the file of a check; *place* is for errors.

    Raises:
        CheckError: The file is invalid; it has all errors.
    """
    return _model(Document(place, values, CheckError), CheckFile)


def check_at(file: CheckFile, folder: Path, place: str = COMMAND_LINE) -> Check:
    """Return a check with files in a folder.

    Raises:
        CheckError: The file is invalid; it has all errors.
    """
    return _checked(Document(place, {}, CheckError), _Valid(file), folder, folder)


def read_repro(path: str | Path, folder: Path | None = None) -> Repro:
    """Return the failure in a file.

    The controller's files are in *folder*, by default the one that the file names, or the current one.

    Raises:
        CheckError: The file is invalid; it has all errors.
    """
    document = _read(path)
    if "repro" not in document.data:
        message = "is not the file of a failure; expected one of the folder failures/ among the results of a search"
        raise CheckError([Problem(document.file, "", message)])
    model = _model(document, ReproFile)
    home = Path(path).absolute().parent
    where = folder or _folder(model, home)
    schedule, flaws = read_injections(model.schedule)
    valid = _Valid(model, [flaw.within("schedule") for flaw in flaws])
    hint = "" if folder else "; --folder DIR says where the controller's files are"

    def unrunnable(check: Check) -> Iterator[Finding]:
        return iter(()) if flaws else _unrunnable(check, schedule)

    check = _checked(document, valid, home, where, also=unrunnable, hint=hint)
    return Repro(check, Case(schedule), model.failure, model.trace)


def _unrunnable(check: Check, schedule: Schedule) -> Iterator[Finding]:
    """Yield the reasons why a schedule is impossible in the world of a check."""
    if why := check.runnable(Case(schedule)):
        yield Finding(("schedule",), why)
        return
    world = check.world_of(Case(schedule))
    faults = [i for i, thing in enumerate(schedule) if thing.family == FAULT]
    before = len(world.faults) - len(faults)
    for flaw in check_faults(world, Lost()):
        number = flaw.path[1]
        if isinstance(number, int) and number >= before:
            yield replace(flaw, path=("schedule", faults[number - before], *flaw.path[2:]))
    there = there_in(world)
    for i, thing in enumerate(schedule):
        if thing.family == DISTURBANCE:
            for flaw in check_pattern(Disturbance.model_validate(dict(thing.spec)).when, there):
                yield flaw.within("schedule", i, "when")


def _folder(model: ReproFile, home: Path) -> Path:
    """Return the folder of the controller's files: the first one that has the file it names."""
    name = (model.controller.tree or model.controller.python or "").partition(":")[0]
    folders = ((home / model.folder).resolve(), Path.cwd(), home)
    return next((each for each in folders if (each / name).is_file()), folders[0])


def _read(path: str | Path) -> Document:
    return read_document(path, CheckError, "a mapping with world, controller and properties")


def _model(document: Document, model: type[M]) -> M:
    return document.validated(model)


def _valid(document: Document) -> _Valid:
    valid = valid_parts(document.data, CheckFile, stand_ins=_STAND_INS)
    if valid.value is None:
        document.raise_for(valid.findings)
        raise AssertionError
    return _Valid(valid.value, valid.findings, valid.lost)


def _checked(
    document: Document,
    valid: _Valid,
    home: Path,
    folder: Path,
    *,
    also: Callable[[Check], Iterator[Finding]] = lambda _check: iter(()),
    hint: str = "",
) -> Check:
    """Return a check, after all checks that need no run.

    Args:
        document: The file.
        valid: Its valid parts; the errors of the others are raised together with those of these.
        home: The folder of the files of the world and the properties.
        folder: The folder of the controller's files.
        also: Yields further flaws of the check.
        hint: The suggested fix if there is no such controller.
    """
    model, invalid, lost = valid
    findings = [*invalid, *_of_kinds(model.space)]
    problems: list[Problem] = []
    properties = Properties()
    try:
        properties, flaws = _properties(model, home, document)
        problems += flaws
    except PropertyError as error:
        problems += error.problems
    source = None if isinstance(model.world, dict) else source_of(model.world, home)
    # Workers don't need source positions.
    plain = properties.located(document.file, no_line)
    limit = model.limits.simulated or DEFAULT_LIMIT
    check = Check(document.file, folder, model, source, plain, limit, line=document.line)
    world = None
    try:
        world = None if lost.touches("world", "overlay") else check.world
    except WorldError as error:
        problems += error.problems
    if world is not None:
        found = _of_properties(document, model, properties, world)
        problems += [problem for problem in found if problem.severity == "error"]
        check = replace(check, warnings=tuple(problem for problem in found if problem.severity != "error"))
        findings += _of_spare(model.space, world)
        findings += _of_further(check)
        findings += () if lost.touches("controller") else _of_robots(model.controller, world)
        findings += also(check)
    if model.controller.in_process and not lost.touches("controller"):
        try:
            controller_of(model.controller, {}, folder)
        except (HmrsimError, ValueError) as error:
            # A tree has a line for each of its errors.
            findings += [Finding(("controller",), f"{line}{hint}") for line in str(error).splitlines()]
    errors = [each for each in findings if each.severity == "error"]
    problems += document.problems([*document.findings, *errors])
    if problems:
        raise CheckError(in_order(problems, document.file))
    return check


def _of_properties(document: Document, model: CheckFile, properties: Properties, world: World) -> list[Problem]:
    """Return the problems of properties in a world, with their file and lines."""
    found = check_properties(properties, world)
    if isinstance(model.properties, str):
        return properties.problems(found)
    return document.problems([each.within("properties") for each in found])


def _properties(model: CheckFile, home: Path, document: Document) -> tuple[Properties, list[Problem]]:
    """Return the valid properties of a check, and the errors of the others."""
    if isinstance(model.properties, str):
        properties, findings = read_valid_properties(home / model.properties)
        return properties, properties.problems(findings)
    properties, findings = valid_properties(Document(document.file, model.properties or {}, PropertyError))
    return properties, document.problems(each.within("properties") for each in findings)


def _of_kinds(space: Space) -> Iterator[Finding]:
    kinds = [*faults(), *CHANGES, *DISTURBANCES]
    for key, names in (("only", space.only or ()), ("without", space.without), ("also", space.also)):
        for i, name in enumerate(names):
            if name not in kinds:
                yield Finding(("space", key, i), _no_kind(name, kinds), name)
    for name in space.weights:
        if name not in kinds:
            yield Finding(("space", "weights", name), _no_kind(name, kinds), name)


def _of_spare(space: Space, world: World) -> Iterator[Finding]:
    known = [*world.robots, *world.doors, *world.docks, *world.items, *world.lifts]
    for i, name in enumerate(space.spare):
        if name not in known:
            yield Finding(("space", "spare", i), f"nothing is called {name!r}{instead(name, known)}", name)


def _no_kind(name: str, kinds: Sequence[str]) -> str:
    """Return that there is no such kind: with the one that was probably meant, or all of them."""
    similar = meant(name, kinds)
    return f"no kind {name!r}; " + (f"did you mean {similar!r}?" if similar else f"there are {', '.join(kinds)}")


def _of_further(check: Check) -> Iterator[Finding]:
    """Yield the flaws of custom injections, each once per template."""
    for i, template in enumerate(check.file.space.further):
        known: list[str] = []
        for each in expanded(template, [*check.world.robots]):
            injections, flaws = read_injections([each])
            for flaw in [*flaws, *_unrunnable(check, injections)]:
                # The path begins with the place of the injection in its list.
                path = flaw.path[2:] if flaw.path[:1] == ("schedule",) else flaw.path[1:]
                if flaw.message not in known:
                    known.append(flaw.message)
                    yield Finding(("space", "further", i, *path), flaw.message, flaw.value)


def _of_robots(controller: Controller, world: World) -> Iterator[Finding]:
    """Yield the reasons why a tree has no robots."""
    for i, name in enumerate(controller.robots or ()):
        if name not in world.robots:
            yield Finding(("controller", "robots", i), f"no robot {name!r}{instead(name, [*world.robots])}", name)
    if controller.tree is not None and not world.robots:
        yield Finding(("controller",), "the world has no robot for a tree; add one, or check a function or a command")
