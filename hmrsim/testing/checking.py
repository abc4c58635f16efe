"""Fault search in unit tests: `check` searches within a budget, `schedules` is a Hypothesis strategy."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from hmrsim.fault_search.campaign import Campaign, Options, limited, no_search
from hmrsim.fault_search.candidates import Candidates, Timeline
from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.reading import check_at, file_of
from hmrsim.fault_search.results_folder import ResultsFolder
from hmrsim.fault_search.run import run_case
from hmrsim.fault_search.schedule import Case
from hmrsim.fault_search.story import story_of
from hmrsim.trials.batches import Serial

if TYPE_CHECKING:
    from hypothesis import strategies as st

    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.schedule import Schedule
    from hmrsim.fault_search.summary import Summary

_PLACE: Final = "hmrsim.testing.check"
_PLACE_OF_SCHEDULES: Final = "hmrsim.testing.schedules"
"""The functions that errors name instead of a file."""

Test = TypeVar("Test", bound=Callable[..., object])


def check(  # noqa: PLR0913 - the options of the command
    world: str | Path | Mapping[str, Any],
    properties: str | Mapping[str, Any] | None = None,
    *,
    tree: str | None = None,
    python: str | None = None,
    command: str | Sequence[str] | None = None,
    robots: Sequence[str] | None = None,
    nodes: Sequence[str] = (),
    budget: str | float = "20s",
    runs: int | None = None,
    seed: int = 0,
    space: Mapping[str, Any] | None = None,
    output: str | Path | None = None,
) -> Callable[[Callable[..., object]], Callable[[], None]]:
    """Return a decorator that makes a test of a controller: it fails if a schedule of faults breaks the controller.

    ::

        @check("hospital", "properties.yaml", tree="my_robots.trees:mission", budget="30s")
        def test_the_mission_survives_faults():
            \"\"\"Whatever goes wrong, the medicine arrives or the mission says that it does not.\"\"\"

    The decorated function is called with the summary of the search, if it takes an argument, and may be empty.

    Args:
        world: The name of a shipped world, the path of a file, or plain values.
        properties: The properties that have to hold in addition to the built-in ones: the path of a file, or plain
            values.
        tree: The controller, if it is a behavior tree: ``MODULE:FUNCTION``, or the path of an XML file.
        python: The controller, if it is a function that takes a client: ``MODULE:FUNCTION``.
        command: The controller, if it is a program.
        robots: The robots that run the tree; all robots if left out.
        nodes: Modules with further nodes for a tree in XML, as with ``--nodes``.
        budget: The wall time of the search.
        runs: The maximum number of runs, with which the test is the same on each machine, if the budget is enough.
        seed: The seed of the search.
        space: The injections, as ``space`` in the file of a check.
        output: The folder of the results; None for none.
    """

    def decorate(function: Callable[..., object]) -> Callable[[], None]:
        def test() -> None:
            chosen = None if robots is None else list(robots)
            given = {"tree": tree, "python": python, "command": command, "robots": chosen}
            controller = given | ({"nodes": list(nodes)} if nodes else {})
            spec = {
                "world": dict(world) if isinstance(world, Mapping) else str(world),
                "controller": {name: value for name, value in controller.items() if value is not None},
                "properties": dict(properties) if isinstance(properties, Mapping) else properties,
                "budget": {"time": budget, "runs": runs},
                "space": dict(space or {}),
                "seed": seed,
            }
            summary = searched(check_at(file_of(spec, _PLACE), Path.cwd(), _PLACE), output)
            if _arguments(function):
                function(summary)
            else:
                function()
            if summary.findings:
                raise AssertionError(_message(summary))

        test.__name__, test.__doc__, test.__module__ = function.__name__, function.__doc__, function.__module__
        test.__qualname__ = function.__qualname__
        return test

    return decorate


def searched(check: Check, output: str | Path | None = None) -> Summary:
    """Return the summary of a search within this process.

    Raises:
        ValueError: The controller can't be run.
    """
    results = ResultsFolder(Path(output)) if output is not None else None
    files: dict[int, str] = {}
    began = time.monotonic()
    with Evaluator(check, Serial, 1) as evaluator:
        nominal = evaluator.outcomes([Case()])[0]
        if why := no_search(nominal):
            raise ValueError(why)
        check = limited(check, nominal)
        evaluator.take(check, nominal)
        options = Options(
            on_finding=lambda found: (
                files.update({len(files) + 1: str(results.keep(check, found))}) if results else None
            )
        )
        summary = Campaign(check, evaluator, nominal, options, began).run()
    summary.files.update(files)
    if results is not None:
        results.finish(check, summary, evaluator.covered)
    return summary


def _arguments(function: Callable[..., object]) -> int:
    return function.__code__.co_argcount


def _message(summary: Summary) -> str:
    stories = "\n\n".join("\n".join(story_of(finding)) for finding in summary.findings)
    files = "".join(f"\nhmrsim check --repro {file}" for file in summary.files.values())
    return f"{len(summary.findings)} failures in {summary.tried.runs} runs\n\n{stories}{files}"


def schedules(
    world: str | Path | Mapping[str, Any], *, tree: str, space: Mapping[str, Any] | None = None
) -> st.SearchStrategy[Schedule]:
    """Return a Hypothesis strategy for schedules of injections into runs of a tree in a world.

    Schedules shrink to fewer injections.

    The tree is run once without faults, to find the moments at which injections can begin.

    ::

        @given(schedule=schedules("hospital", tree="my_robots.trees:mission"))
        def test_the_medicine_is_somewhere(schedule):
            with simulation("hospital", tree="my_robots.trees:mission", schedule=schedule) as run:
                run.to_the_end()
                assert run.where("medicine")

    Args:
        world: The name of a shipped world, the path of a file, or plain values.
        tree: The tree: ``MODULE:FUNCTION``, or the path of an XML file.
        space: The injections, as ``space`` in the file of a check; disturbances are not supported.

    Raises:
        CheckError: The world, the tree or the space is invalid; it has all errors.
    """
    from hypothesis import strategies as st  # noqa: PLC0415 - `check` works without Hypothesis

    spec = {"families": ("faults", "changes"), **(space or {})}
    source = dict(world) if isinstance(world, Mapping) else str(world)
    file = file_of({"world": source, "controller": {"tree": tree}, "space": spec}, _PLACE_OF_SCHEDULES)
    check = check_at(file, Path.cwd(), _PLACE_OF_SCHEDULES)
    nominal = run_case(check, Case())
    candidates = Candidates(check.world, check.file.space, nominal.moments, dict(nominal.draws))
    timeline = Timeline(nominal.moments)
    at_moments = (candidate.singles_in(timeline) for candidate in candidates.entries)
    possible = [[single.injection for single in singles] for singles in at_moments if singles]
    one = st.sampled_from(possible).flatmap(st.sampled_from)
    most = check.file.space.at_most
    return st.lists(one, max_size=most, unique_by=lambda injection: injection.key).map(tuple)
