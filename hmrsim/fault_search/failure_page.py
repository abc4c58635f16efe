"""The page of a failing run, with the run beside it that passes without one element of its schedule."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from linecache import getline
from typing import TYPE_CHECKING, Final

from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.fault_search.check import ReproFile
from hmrsim.fault_search.reducer import left_out
from hmrsim.fault_search.run import Wanted, run_case
from hmrsim.fault_search.story import passes
from hmrsim.fault_search.summary import by_begin
from hmrsim.report.html import in_seconds
from hmrsim.run_page import Cause, Heading, RunLog, ShownRun, page_of
from hmrsim.run_page.omissions import goal_text
from hmrsim.trials.trial import TIMEOUT

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.run import Outcome
    from hmrsim.fault_search.schedule import Case, Injection

_LONGEST_TITLE: Final = 120
"""The maximum number of characters of a title that has its details in it."""
_PLACE: Final = re.compile(r"([^\s()]+\.py):(\d+)")


def run_logged(check: Check, case: Case, wanted: Wanted) -> tuple[Outcome, RunLog]:
    """Run a case; return its outcome and its log."""
    log = RunLog()
    wanted = replace(wanted, further=log.watchers(wanted.further), on_tick=log.note_tick)
    return run_case(check, case, wanted), log


def failure_page(check: Check, case: Case, outcome: Outcome, log: RunLog) -> str:
    """Return the page of a run that has failed.

    Beside it is the run without the last element of its schedule that passes; each of these takes a further run.
    """
    failure = outcome.failure
    schedule, order = case.schedule, by_begin(case.schedule, outcome)
    without: dict[int, str] = {}
    twin: ShownRun | None = None
    for i in reversed(order):
        smaller = case.with_schedule(tuple(each for j, each in enumerate(schedule) if j != i))
        found, beside = run_logged(check, smaller, Wanted())
        without[i] = passes(found)
        if found.failure is None and beside.watched:
            what = schedule[i].describe() if len(schedule) > 1 else "the fault"
            twin = ShownRun("Passing run", beside, f"without {what}, {_ending(found)}", found.at)
            break
    texts = [f"{each.describe()}{_hit(each, began, log)}" for each, began in zip(schedule, outcome.began, strict=True)]
    causes = [Cause(texts[i], outcome.began[i], without.get(i, "")) for i in order]
    text = next((each.text for each in outcome.violations if (each.property, each.reason) == failure), "")
    # The first one is the title of the page.
    violations = [
        (each.at / 1e9, each.property if each.text == text else f"{each.property}: {each.text}")
        for each in outcome.violations
    ]
    stopped = outcome.ending in ("stopped", TIMEOUT)
    failing = ShownRun("Failing run", log, _ending(outcome), outcome.at, violations, text, stopped)
    title, further = title_of(text) if failure else ("No property is violated", "")
    kind = f"Failing run of {check.name}{f': violates {failure.property}' if failure else ''}"
    lacks = check.file.left_out if isinstance(check.file, ReproFile) else ""
    if case.definition is not None:
        lacks = left_out(check.definition, case.definition)
    note = f"The world is reduced to what this failure needs. The search has left out {lacks}." if lacks else ""
    alone = "" if twin else "No run passes without one of them, so there is no passing run beside it."
    if not case.schedule:
        alone = "The run fails without any fault, so there is no passing run beside it."
    heading = Heading(kind, title, further, alone, note, [*code_in(text)])
    return page_of(heading, causes, (failing, twin) if twin else (failing,))


def _hit(injection: Injection, began: float | None, log: RunLog) -> str:
    """Return the first goal that a fault aborts; it may be a later one than that at which the fault begins."""
    accepted: dict[str, GoalAccepted] = {}
    for each in log.happenings if began is not None else ():
        event, at = each.event, in_seconds(each.at)
        if isinstance(event, GoalAccepted):
            accepted[event.goal_id] = event
        elif isinstance(event, GoalStatusChanged) and at >= (began or 0.0):
            goal = accepted.get(event.goal_id)
            if goal is not None and (event.robot, event.cause) == (injection.subject, injection.kind):
                return f"; this hits {goal_text(log, goal)}, at {at:.3f} s"
    return ""


def title_of(text: str) -> tuple[str, str]:
    """Return the title of a page that says what happened, and the details of a long text, which come below it."""
    title, further = text, ""
    if len(text) > _LONGEST_TITLE:
        title, _, further = text.partition(": ")
    # Other texts may begin with a name.
    return f"T{title[1:]}" if title.startswith("the ") else title, further


def code_in(text: str) -> Iterator[tuple[str, str]]:
    """Yield each place in a text, such as ``mission.py:12``, with its line if the file can be read now."""
    for place in dict.fromkeys(_PLACE.findall(text)):
        if source := getline(place[0], int(place[1])).strip():
            yield f"{place[0]}:{place[1]}", source


def _ending(outcome: Outcome) -> str:
    violated = dict.fromkeys(failure.property for failure in outcome.failures)
    what = f"violates {', '.join(violated)} and " if violated else ""
    # The search stops a run that can no longer succeed.
    ends = "is stopped there" if outcome.ending == "stopped" and violated else f"ends as {outcome.ending}"
    return f"{what}{ends} at {outcome.at:.1f} s"
