"""The controller under test: a tree or a function in this process, or a command."""

from __future__ import annotations

import asyncio
import inspect
import shlex
import sys
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import lru_cache, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.loading.named_functions import NamedFunction, find_function
from bt_controller.loading.trees import Plan as TreePlan
from bt_controller.loading.trees import load
from bt_controller.running.runner import run_tree
from bt_controller.running.snapshot import Node, nodes_with_ports
from hmrsim.program.users_code import described
from hmrsim.timing.pacing import Watchers, unwatched
from hmrsim.trials.command import CommandTrial
from hmrsim.trials.local import LocalTrial
from hmrsim.world.overlays.expressions import names_used_in, substituted
from hmrsim_zenoh.client.aio import AsyncClient
from hmrsim_zenoh.errors import SimulatorGone

if TYPE_CHECKING:
    from pathlib import Path

    from bt_controller.coverage import TreeCoverage
    from bt_controller.running.mission import Mission
    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.trials.disturbances import Disturber
    from hmrsim.trials.model import Controller
    from hmrsim.trials.trial import Player, Trial
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.client.client import Client

OnTick = Callable[[str, float | None, Sequence[Node]], object]
"""Takes a robot, the simulated time in seconds, and the nodes of its tree after a tick."""

_NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})


def parameters_of(treatment: Controller, names: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a controller, with the values of *names* in their expressions.

    Raises:
        ValueError: An expression has no value.
    """
    return {key: substituted(value, names) for key, value in treatment.set.items()}


def trial_of(  # noqa: PLR0913 - the controller, its world and its observers
    loaded: LoadedWorld,
    settings: RunSettings,
    treatment: Controller,
    folder: Path,
    *,
    names: Mapping[str, Any] = _NOTHING,
    variables: Mapping[str, str] = _NOTHING,
    coverage: TreeCoverage | None = None,
    sinks: Sequence[Sink] = (),
    watchers: Watchers = unwatched,
    disturber: Disturber | None = None,
    on_tick: OnTick | None = None,
) -> Trial:
    """Return a trial of a controller.

    Args:
        loaded: The world.
        settings: The seed and others; the clock is lockstep, whatever they say.
        treatment: The controller.
        folder: The folder of the controller's files, in which commands are started.
        names: The values for its expressions.
        variables: Environment variables of a command, in addition to its parameters.
        coverage: Counts the statuses of a tree's nodes, if given.
        sinks: Further sinks of events.
        watchers: Make further sinks from the simulator and its pacing.
        disturber: Disturbs the controller; one of *watchers* connects it.
        on_tick: Called after each tick of a tree, if given.

    Raises:
        TreeError: There is no such tree or function, or it is invalid.
        ValueError: A command is empty, or an expression has no value.
    """
    if treatment.in_process:
        player = controller_of(treatment, names, folder, coverage=coverage, on_tick=on_tick)
        name = treatment.participant
        return LocalTrial(
            loaded.world, settings, player, name=name, sinks=sinks, watchers=watchers, disturber=disturber
        )
    parameters = {key: str(value) for key, value in parameters_of(treatment, names).items()}
    words, own = words_of(treatment, names), {**parameters, **variables}
    return CommandTrial(loaded, settings, words, folder, own, sinks=sinks, watchers=watchers, disturber=disturber)


def controller_of(
    treatment: Controller,
    names: Mapping[str, Any],
    folder: Path,
    *,
    coverage: TreeCoverage | None = None,
    on_tick: OnTick | None = None,
) -> Player:
    """Return a controller that runs in this process, with the arguments of `trial_of`.

    Raises:
        TreeError: There is no such tree or function, or it is invalid.
        ValueError: An expression has no value.
    """
    parameters = parameters_of(treatment, names)
    known = {**names, **parameters}
    if treatment.tree is not None:
        values = tuple((key, _text(value)) for key, value in parameters.items())
        plan = _tree(str(substituted(treatment.tree, known)), treatment.tree_id, treatment.nodes, values, folder)
        show = None if on_tick is None else partial(_show, on_tick)
        return lambda client, robots: (
            run_tree(client, plan, treatment.robots or robots, show=show, coverage=coverage).succeeded
        )
    if treatment.python is None:
        raise AssertionError
    said = names_used_in(treatment.python)
    further = {key: value for key, value in parameters.items() if key not in said}
    found = _function(str(substituted(treatment.python, known)), folder).called_with(further)
    if inspect.iscoroutinefunction(found.function):
        return lambda client, _robots: asyncio.run(play_async(client, found.applied)) is not False
    return lambda client, _robots: found.applied(client) is not False


def _show(on_tick: OnTick, mission: Mission, now: float | None) -> None:
    on_tick(mission.robot, now, nodes_with_ports(mission.root))


def words_of(treatment: Controller, names: Mapping[str, Any]) -> list[str]:
    """Return the command of a treatment, with the values of *names* in its expressions.

    Raises:
        ValueError: It is empty, or an expression has no value.
    """
    command = treatment.command
    parts = shlex.split(command) if isinstance(command, str) else list(command or ())
    known = {**names, **parameters_of(treatment, names)}
    words = [str(substituted(part, known)) for part in parts]
    if not words:
        raise ValueError("the command is empty")
    return words


async def play_async(client: Client, function: Callable[[AsyncClient], Awaitable[Any]]) -> Any:
    """Run a coroutine function with a client for asyncio.

    If the run ends first, the error has a note for each task that failed without being awaited.
    """
    died: list[str] = []

    def note(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        if isinstance(context.get("future"), asyncio.Task) and (error := context.get("exception")) is not None:
            died.append(f"a task of the controller had died of {described(error)}")
        loop.default_exception_handler(context)

    asyncio.get_running_loop().set_exception_handler(note)
    async with AsyncClient(client) as robots:
        try:
            return await function(robots)
        except SimulatorGone as gone:
            for each in died:
                gone.add_note(each)
            raise


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


@lru_cache(maxsize=256)
def _tree(
    name: str, tree_id: str | None, nodes: tuple[str, ...], values: tuple[tuple[str, str], ...], folder: Path
) -> TreePlan:
    _add_to_path(folder)
    return load(_located(name, folder), tree=tree_id, nodes=nodes, values=dict(values))


@lru_cache(maxsize=256)
def _function(name: str, folder: Path) -> NamedFunction:
    _add_to_path(folder)
    return find_function(_located(name, folder))


def _located(name: str, folder: Path) -> str:
    """Return the name of a tree or function, with the path of its file if it is in a folder."""
    home, colon, rest = name.partition(":")
    path = folder / home
    return f"{path}{colon}{rest}" if home.endswith((".py", ".xml")) and path.is_file() else name


def _add_to_path(folder: Path) -> None:
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
