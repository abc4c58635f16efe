"""Hypothesis strategies for schedules of faults, for those who want to write properties in Python."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hypothesis import strategies as st

from hmrsim.fault_search.file.reading import check_at, file_of
from hmrsim.fault_search.running.single import run_case
from hmrsim.fault_search.schedules.case import Case
from hmrsim.fault_search.space.menu import Menu, Timeline

if TYPE_CHECKING:
    from hmrsim.fault_search.schedules.thing import Schedule

_PLACE: Final = "hmrsim.testing.schedules"
"""What errors speak of."""


def schedules(
    world: str | Path | Mapping[str, Any], *, tree: str, space: Mapping[str, Any] | None = None
) -> st.SearchStrategy[Schedule]:
    """Return a strategy for schedules of what can happen while a tree is run in a world; it shrinks to fewer things.

    The tree is run once without faults, to know at which moments things can begin.

    ::

        @given(schedule=schedules("hospital", tree="my_robots.trees:mission"))
        def test_the_medicine_is_somewhere(schedule):
            with simulation("hospital", tree="my_robots.trees:mission", schedule=schedule) as run:
                run.to_the_end()
                assert run.where("medicine")

    Args:
        world: The name of a shipped world, the path of a file, or what a file says, in plain values.
        tree: The tree: ``MODULE:FUNCTION``, or the path of an XML file.
        space: What can happen, as the file of a check says under ``space``; disturbances do not.

    Raises:
        CheckError: Something is wrong with the world, the tree or the space; it has all errors.
    """
    said = {"families": ("faults", "changes"), **(space or {})}
    source = dict(world) if isinstance(world, Mapping) else str(world)
    file = file_of({"world": source, "controller": {"tree": tree}, "space": said}, _PLACE)
    check = check_at(file, Path.cwd(), _PLACE)
    nominal = run_case(check, Case())
    menu = Menu(check.world, check.file.space, nominal.moments, dict(nominal.draws))
    timeline = Timeline(nominal.moments)
    possible = [things for entry in menu.entries if (things := entry.things_in(timeline))]
    one = st.sampled_from(possible).flatmap(st.sampled_from)
    most = check.file.space.at_most
    return st.lists(one, max_size=most, unique_by=lambda thing: thing.key).map(tuple)
