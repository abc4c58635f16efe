"""Replace the world by another; the simulation is then stopped, at time 0."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import dotted, instead, shown
from hmrsim.errors import Problem, WorldError
from hmrsim.interfaces.simulation_interfaces import LoadWorld, Result, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._results import OK, failed
from hmrsim.services._worlds import resource_of
from hmrsim.simulation.reset import load
from hmrsim.world.formats.native import FORMAT
from hmrsim.world.options import AS_IT_IS
from hmrsim.world.shipped import shipped_maps
from hmrsim.world.writing import to_json
from hmrsim.world_checks.loading import load_world, world_of
from hmrsim.world_checks.pairs import check_pairs

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from hmrsim.diagnostics import Finding
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

_SOURCE: Final = "resource_string"
_Response = LoadWorld.Response


def _recorded(simulator: Simulator, request: LoadWorld.Request) -> LoadWorld.Request | LoadWorld.Response:
    """Return the request with the world itself in it, or at once the response with the world's problems."""
    if not request.uri and not request.resource_string:
        why = "neither uri nor resource_string is given; expected the name of a shipped world, a file, or its text"
        return _Response(result=failed(why, _Response.NO_RESOURCE))
    try:
        world = load_world(_source(simulator, request.uri)).world if request.uri else _sent(request.resource_string)
    except PermissionError as error:
        return _Response(result=failed(str(error), Result.RESULT_NOT_FOUND))
    except WorldError as error:
        missing = any(problem.message.startswith("no such file") for problem in error.problems)
        code = Result.RESULT_NOT_FOUND if missing else _Response.RESOURCE_PARSE_ERROR
        # Where the folder is, is no client's business.
        text = str(error).replace(f"{simulator.allow_files}/", "") if simulator.allow_files else str(error)
        return _Response(result=failed(text, code))
    return LoadWorld.Request(resource_string=to_json(world))


def _source(simulator: Simulator, uri: str) -> str | Path:
    """Return the shipped world or the file that a client names.

    Raises:
        PermissionError: It is no file that clients may load, whether there is one or not.
    """
    worlds = shipped_maps()
    if uri in worlds:
        return uri
    name, folder = uri.removeprefix("file://"), simulator.allow_files
    if folder is None:
        raise PermissionError(
            f"no shipped world {shown(uri)}{instead(uri, worlds)}; files can be loaded only of a simulator that was "
            "started with --allow-files DIR"
        )
    try:
        path = (folder / name).resolve()
    except (OSError, ValueError, RuntimeError):
        path = folder.parent
    # From Python 3.13 on, a link that leads to itself is no error and stays a link.
    if not path.is_relative_to(folder) or path == folder or path.is_symlink():
        raise PermissionError(
            f"{shown(uri)} is neither a shipped world{instead(uri, worlds)} nor a file of the folder of --allow-files"
        )
    return path


def _sent(text: str) -> World:
    """Return the world that a text of a client describes.

    Raises:
        WorldError: It does not describe a valid world, or one that is too large to be sent.
    """
    return _read(text, check_pairs)


def _read(text: str, first: Callable[[World], Iterable[Finding]] = lambda _world: ()) -> World:
    """Return the world that a text describes; what *first* checks precedes all other checks.

    Raises:
        WorldError: It does not describe a valid world.
    """
    document = FORMAT.read(text, _SOURCE, AS_IT_IS)
    errors = [
        Problem(_SOURCE, dotted(found.path), found.message, found.line)
        for found in document.findings
        if found.severity == "error"
    ]
    if "include" in document.data:
        errors.append(Problem(_SOURCE, "include", "a text can't include files; give the world's file as uri"))
    if errors:
        raise WorldError(errors)
    return world_of(document.data, _SOURCE, first=first)


def _serve(simulator: Simulator, request: LoadWorld.Request) -> LoadWorld.Response:
    try:
        # Read again, as a replay does, so that both run the same world or refuse it.
        world = _read(request.resource_string)
    except WorldError as error:
        # Written out, what an overlay makes of a few lines may have more values than are read.
        why = f"the world that comes of it {error.problems[0].message}"
        return _Response(result=failed(why, _Response.RESOURCE_PARSE_ERROR))
    load(simulator, world)
    return _Response(result=OK, world=resource_of(simulator.world))


SERVICE = Service(
    name="load_world",
    request=LoadWorld.Request,
    response=LoadWorld.Response,
    serve=_serve,
    changes_world=True,
    recorded=_recorded,
    features=(SimulatorFeatures.WORLD_LOADING, SimulatorFeatures.WORLD_RESOURCE_STRING),
    example={"uri": "scenario1"},
)
