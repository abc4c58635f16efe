"""The check of an experiment and all that it needs, without running anything."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import Finding, in_order, instead
from hmrsim.errors import ExperimentError, HmrsimError, Problem, WorldError
from hmrsim.events import registry as events
from hmrsim.experiments.endings import BY_REPORT, REPORTED
from hmrsim.experiments.measures import NAMES, Unknown, unknown_parts
from hmrsim.experiments.reading import OF_NAMES, Reading, read_valid_parts
from hmrsim.experiments.statistics.confidence_sequences import FIRST_LOOK
from hmrsim.trials.controllers import controller_of, words_of
from hmrsim.trials.trial import BUILT_IN
from hmrsim.world.overlays.expressions import OverlayFlaw, names_in, names_used_in

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.documents.valid_parts import Lost
    from hmrsim.experiments.model import Ending
    from hmrsim.experiments.plan import Plan
    from hmrsim.world.model import World


def check_file(
    path: str | Path, variants: Collection[str] = (), tell: Callable[[int], None] = lambda _scenario: None
) -> tuple[Plan, list[Problem]]:
    """Return the plan of an experiment's file, as `hmrsim.experiments.reading.read_plan`, and the warnings.

    *tell* is called with the number of each scenario whose world was checked.

    Raises:
        ExperimentError: The experiment is invalid; it has all errors.
    """
    reading = read_valid_parts(path, variants)
    if reading.plan is None:
        raise ExperimentError(reading.problems)
    errors, warnings = _problems(reading, reading.plan, tell)
    errors = [*reading.problems, *errors]
    if errors:
        raise ExperimentError(in_order(errors, str(path)))
    return reading.plan, warnings


def _problems(reading: Reading, plan: Plan, tell: Callable[[int], None]) -> tuple[list[Problem], list[Problem]]:
    """Return the errors and the warnings of an experiment, except of parts that depend on invalid ones."""
    file, lost = reading.document.file, reading.lost
    errors, warnings, worlds = ([], [], []) if lost.touches("world") else _worlds(plan, tell)
    if not reading.worlds_known:
        worlds = []
    endings: list[str] | None = None
    if (broken := lost.names.get("ends", frozenset())) is not None:
        endings = [*plan.file.ends, *sorted(broken)]
    unknown = [] if endings is None else _unknown(plan, endings, worlds)
    findings = [*_measures(plan), *_endings(plan, worlds), *(() if endings is None else _successes(plan, endings))]
    findings += [Finding(("measures", each.measure), each.text) for each in unknown if each.certain]
    findings += _treatments(plan, lost)
    errors += reading.document.problems(findings)
    doubtful = [
        Problem(file, f"measures.{each.measure}", each.text, severity="warning") for each in unknown if not each.certain
    ]
    further = [*_without_success(plan, file), *_without_effect(plan, file), *_too_few(plan, file)]
    return errors, [*warnings, *further, *doubtful]


def _worlds(plan: Plan, tell: Callable[[int], None]) -> tuple[list[Problem], list[Problem], list[World]]:
    """Return the errors and the warnings of the worlds of all scenarios, and the worlds of the first valid scenario."""
    errors: dict[Problem, None] = {}
    warnings: dict[Problem, None] = {}
    first: list[World] = []
    treatments = [name for name in plan.treatments if name in plan.own_overlays]
    if len(treatments) < len(plan.treatments) or not treatments:
        treatments.insert(0, "")
    for scenario, levels in enumerate(plan.scenarios):
        worlds = []
        for treatment in treatments:
            try:
                loaded = plan.world(scenario, treatment)
                warnings |= dict.fromkeys(loaded.warnings)
                worlds.append(loaded.world)
            except WorldError as error:
                names = ", ".join(f"{name}={level}" for name, level in levels.items())
                place = f"scenario {scenario}{f': {names}' if names else ''}"
                place += f", treatment {treatment}" if treatment else ""
                for problem in error.problems:
                    if problem.severity == "error" and not any(_alike(problem, each) for each in errors):
                        errors[replace(problem, message=f"{problem.message} ({place})")] = None
        if len(worlds) == len(treatments):
            first = first or worlds
        tell(scenario)
    return [*errors], [*warnings], first


def _unknown(plan: Plan, endings: Sequence[str], worlds: Sequence[World]) -> list[Unknown]:
    """Return the parts that measures use and that no world has."""
    found = [[*unknown_parts(plan.file, endings, world)] for world in worlds]
    measures = [{each.measure for each in one} for one in found]
    return [each for each in found[0] if all(each.measure in one for one in measures)] if found else []


def _without_success(plan: Plan, path: str) -> Iterator[Problem]:
    """Yield a warning if no ending of the file counts as a success, and the file names no successes."""
    file = plan.file
    if "successes" not in file.model_fields_set and file.ends and not file.ends.keys() & {*file.successes}:
        names = ", ".join(file.ends)
        message = f"a run that ends as {names} is no success; if it should be one, add successes: [{names}]"
        yield Problem(path, "ends", message, severity="warning")


def _without_effect(plan: Plan, path: str) -> Iterator[Problem]:
    """Yield a warning for each factor that nothing uses, so that its levels have no effect."""
    file = plan.file
    treatments = [treatment.model_dump(mode="json") for treatment in file.treatments.values()]
    try:
        variants = [variant.model_dump(mode="json") for variant in file.variants.values()]
        used = names_used_in([file.overlay, variants, treatments])
    except OverlayFlaw:
        # A variant that was not chosen may be invalid.
        return
    for factor in file.factors:
        if factor not in used:
            message = f"nothing asks for ${factor}, so that its levels differ by chance alone; use it in the overlay"
            yield Problem(path, f"factors.{factor}", message, severity="warning")


def _too_few(plan: Plan, path: str) -> Iterator[Problem]:
    """Yield a warning if an experiment that runs until it is decided ends before most measures can be decided."""
    replications, scenarios = plan.file.replications, len(plan.scenarios)
    pairs = replications.max * scenarios
    if replications.until and replications.until.decided and pairs < FIRST_LOOK:
        needed = math.ceil(FIRST_LOOK / scenarios)
        unless = f"unless {replications.until.measure} is 0 or 1"
        message = f"nothing is decided before {FIRST_LOOK} pairs of runs, {unless}; make it {needed} or more"
        yield Problem(path, "replications.max", message, severity="warning")


def _alike(problem: Problem, other: Problem) -> bool:
    """Return whether a problem is the same as one of another scenario."""
    return (problem.file, problem.path, problem.line) == (
        other.file,
        other.path,
        other.line,
    ) and other.message.startswith(problem.message)


def _names_asked_for(value: object) -> frozenset[str]:
    """Return the names that the expressions in a value use; an invalid expression counts as a name."""
    try:
        return names_used_in(value)
    except OverlayFlaw:
        return frozenset({str(value)})


def _treatments(plan: Plan, lost: Lost) -> Iterator[Finding]:
    """Yield the flaws of valid controllers; if names are lost, of those that use none."""
    known = not lost.touches(*OF_NAMES)
    scenarios = [plan.names(scenario) for scenario in range(len(plan.scenarios))] if known else [{}]
    for name, treatment in plan.treatments.items():
        if lost.has(name, "treatments"):
            continue
        if not known and _names_asked_for(treatment.model_dump(mode="json", exclude={"overlay"})):
            continue
        kind = next(kind for kind in ("tree", "python", "command") if getattr(treatment, kind) is not None)
        reasons: dict[str, None] = {}
        for names in scenarios:
            try:
                if treatment.in_process:
                    controller_of(treatment, names, plan.path.parent)
                else:
                    words_of(treatment, names)
            except (HmrsimError, ValueError) as error:
                # A tree has a line for each of its errors.
                reasons.update(dict.fromkeys(str(error).splitlines()))
        for reason in reasons:
            yield Finding(("treatments", name, kind), reason)


def _measures(plan: Plan) -> Iterator[Finding]:
    for name, measure in plan.file.measures.items():
        try:
            unknown = sorted(names_in(measure.value) - {*NAMES})
        except ValueError as error:
            yield Finding(("measures", name), str(error), measure.value)
            continue
        for each in unknown:
            yield Finding(("measures", name), f"there is no {each!r}{instead(each, NAMES)}", measure.value)


def _endings(plan: Plan, worlds: Sequence[World]) -> Iterator[Finding]:
    """Yield the flaws that endings have in all worlds, since each treatment may have its own world."""
    for label, conditions in plan.file.ends.items():
        for i, condition in enumerate(conditions):
            path = ("ends", label, i) if len(conditions) > 1 else ("ends", label)
            found = [dict(_flaws(condition, world)) for world in worlds] or [dict(_flaws(condition, None))]
            for field, message in found[0].items():
                if all(field in each for each in found):
                    yield Finding((*path, field), message)


def _successes(plan: Plan, endings: Sequence[str]) -> Iterator[Finding]:
    """Yield a flaw for each success that no run can have as its ending."""
    if "successes" in plan.file.model_fields_set:
        known = [*endings, *BUILT_IN]
        for place, label in enumerate(plan.file.successes):
            if label not in known:
                what = f"no run ends as {label!r}, as there is no such ending{instead(label, known)}"
                yield Finding(("successes", place), f"{what}; define it under ends, or leave it out", label)


def _flaws(condition: Ending, world: World | None) -> Iterator[tuple[str, str]]:
    if condition.event is not None and condition.event not in events():
        yield "event", f"there is no kind of event {condition.event!r}{instead(condition.event, events())}"
    asking = {name: asked for name in BY_REPORT if (asked := _names_asked_for(getattr(condition, name)))}
    for name, asked in asking.items():
        for each in sorted(asked - {REPORTED}):
            yield name, f"there is no {each!r}; an ending may only ask for what was reported, ${{{REPORTED}.NAME}}"
    if world is None:
        return
    known = condition.model_copy(update=dict.fromkeys(asking))
    places: Mapping[str, Any] = {**world.points, **world.places, **world.docks}
    if known.at is not None and known.at not in places:
        yield "at", f"no waypoint, place or dock {known.at!r}{instead(known.at, places)}"
    if known.robot is not None and known.robot not in world.robots:
        yield "robot", f"no robot {known.robot!r}{instead(known.robot, world.robots)}"
    items = {*world.items, *(spec.item or spec.name for spec in world.demand)}
    if known.item is not None and not items & {known.item, known.item.rpartition("_")[0]}:
        yield "item", f"no item {known.item!r}{instead(known.item, world.items)}"
    if condition.orders is not None and not world.demand and condition.count is None:
        yield "orders", "the world has no demand; say how many orders have to be delivered: count"
