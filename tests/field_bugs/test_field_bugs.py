"""The bugs and their fixes do what they are for where nothing goes wrong, and hold the properties of their checks."""

import asyncio
import importlib.util
import inspect
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

from hmrsim.properties import check_trace, properties_of
from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, Client

FOLDER = Path(__file__).parent
BUGS = sorted(path.parent.name for path in FOLDER.glob("*/check.yaml"))


@pytest.mark.parametrize("version", ["buggy", "fixed"])
@pytest.mark.parametrize("bug", BUGS)
def test_without_faults_the_mission_is_done(bug: str, version: str) -> None:
    check = yaml.safe_load((FOLDER / bug / "check.yaml").read_text())
    [(kind, controller)] = check["controller"].items()
    controller = controller.replace("buggy", version).removeprefix("python ")

    trace = _RUNS[kind](FOLDER / bug, controller)

    verdicts = check_trace(lambda: trace, properties_of(check["properties"])).monitor.verdicts()
    assert {verdict.state for verdict in verdicts if verdict.property in check["properties"]["properties"]} == {"holds"}
    assert [verdict.text for verdict in verdicts if verdict.state == "violated"] == []


def _run_tree(folder: Path, tree: str) -> list[str]:
    """Run a behavior tree, and return its trace."""
    with simulation(folder / "world.yaml", tree=str(folder / tree)) as run:
        run.to_the_end()
        run.check_succeeded()
        return _lines(run.trace)


def _run_function(folder: Path, function: str) -> list[str]:
    """Run a function that is given a client, and return the trace."""
    file, _, name = function.partition(":")
    return _run_client(folder, getattr(_load(folder / file), name))


def _run_program(folder: Path, file: str) -> list[str]:
    """Run the function that a program calls with its client, and return the trace."""
    return _run_client(folder, _load(folder / file).main)


_RUNS: dict[str, Callable[[Path, str], list[str]]] = {
    "tree": _run_tree,
    "python": _run_function,
    "command": _run_program,
}


def _run_client(folder: Path, function: Callable[[Any], Any]) -> list[str]:
    with simulation(folder / "world.yaml") as run:
        if inspect.iscoroutinefunction(function):
            outcome = asyncio.run(_with_asyncio(run.client, function))
        else:
            outcome = function(run.client)
        assert outcome is not False
        return _lines(run.trace)


async def _with_asyncio(client: Client, function: Callable[[AsyncClient], Any]) -> object:
    async with AsyncClient(client) as connection:
        return await function(connection)


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"field_bugs_{path.parent.name}_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _lines(trace: str) -> list[str]:
    return trace.splitlines(keepends=True)
