"""Services that list the available worlds, return the current one and load another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import dotted, instead, shown
from hmrsim.errors import Problem, WorldError
from hmrsim.interfaces.simulation_interfaces import (
    GetAvailableWorlds,
    GetCurrentWorld,
    LoadWorld,
    Resource,
    Result,
    SimulatorFeatures,
    WorldResource,
)
from hmrsim.services import OK, RequestFailed, Service
from hmrsim.simulation.reset import load
from hmrsim.world.files import AS_IT_IS, shipped_maps
from hmrsim.world.formats.native import FORMAT
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


def _resource_of(world: World) -> WorldResource:
    """Return a loaded world as text, because its file may be on another machine."""
    description = f"{len(world.robots)} robots, {len(world.items)} items, {len(world.waypoints)} waypoints"
    return WorldResource(
        name=world.name, world_resource=Resource(resource_string=to_json(world)), description=description
    )


def _get_available_worlds(_simulator: Simulator, request: GetAvailableWorlds.Request) -> GetAvailableWorlds.Response:
    if request.filter.tags:
        raise RequestFailed("worlds have no tags here", Result.RESULT_FEATURE_UNSUPPORTED)
    result = OK
    if request.additional_sources:
        sources = ", ".join(request.additional_sources)
        why = f"unknown sources: {sources}; files are loaded by their path, with --allow-files"
        if not request.continue_on_error:
            raise RequestFailed(why, Result.RESULT_NOT_FOUND)
        result = Result(result=Result.RESULT_OK, error_message=why)
    worlds = [WorldResource(name=name, world_resource=Resource(uri=name)) for name in shipped_maps()]
    return GetAvailableWorlds.Response(result=result, worlds=worlds)


def _get_current_world(simulator: Simulator, _request: GetCurrentWorld.Request) -> GetCurrentWorld.Response:
    return GetCurrentWorld.Response(result=OK, world=_resource_of(simulator.world))


def _resolve_world(simulator: Simulator, request: LoadWorld.Request) -> LoadWorld.Request:
    """Return the request with the text of the world in it."""
    if not request.uri and not request.resource_string:
        why = "neither uri nor resource_string is given; expected the name of a shipped world, a file, or its text"
        raise RequestFailed(why, _Response.NO_RESOURCE)
    try:
        world = (
            load_world(_source(simulator, request.uri)).world
            if request.uri
            else _read(request.resource_string, check_pairs)
        )
    except WorldError as error:
        missing = any(problem.message.startswith("no such file") for problem in error.problems)
        code = Result.RESULT_NOT_FOUND if missing else _Response.RESOURCE_PARSE_ERROR
        # Clients must not learn the folder's path.
        text = str(error).replace(f"{simulator.allow_files}/", "") if simulator.allow_files else str(error)
        raise RequestFailed(text, code) from None
    return LoadWorld.Request(resource_string=to_json(world))


def _source(simulator: Simulator, uri: str) -> str | Path:
    """Return the shipped world or the file that a client names.

    Raises:
        RequestFailed: Clients may not load it, whether it exists or not.
    """
    worlds = shipped_maps()
    if uri in worlds:
        return uri
    name, folder = uri.removeprefix("file://"), simulator.allow_files
    if folder is None:
        raise RequestFailed(
            f"no shipped world {shown(uri)}{instead(uri, worlds)}; files can be loaded only of a simulator that was "
            "started with --allow-files DIR",
            Result.RESULT_NOT_FOUND,
        )
    try:
        path = (folder / name).resolve()
    except (OSError, ValueError, RuntimeError):
        path = folder.parent
    # As of Python 3.13 a link to itself is no error and stays a link.
    if not path.is_relative_to(folder) or path == folder or path.is_symlink():
        raise RequestFailed(
            f"{shown(uri)} is neither a shipped world{instead(uri, worlds)} nor a file of the folder of --allow-files",
            Result.RESULT_NOT_FOUND,
        )
    return path


def _read(text: str, first: Callable[[World], Iterable[Finding]] = lambda _world: ()) -> World:
    """Return the world that a text describes; *first* runs before all other checks.

    Raises:
        WorldError: The text does not describe a valid world.
    """
    document = FORMAT.read(text, _SOURCE, AS_IT_IS)
    errors = [
        Problem(_SOURCE, dotted(finding.path), finding.message, finding.line)
        for finding in document.findings
        if finding.severity == "error"
    ]
    if "include" in document.data:
        errors.append(Problem(_SOURCE, "include", "a text can't include files; give the world's file as uri"))
    if errors:
        raise WorldError(errors)
    return world_of(document.data, _SOURCE, first=first)


def _load_world(simulator: Simulator, request: LoadWorld.Request) -> LoadWorld.Response:
    try:
        # Read again, as in a replay, so that both run the same world or reject it.
        world = _read(request.resource_string)
    except WorldError as error:
        # An overlay of a few lines may generate a world with more values than a text may have.
        why = f"the world that comes of it {error.problems[0].message}"
        raise RequestFailed(why, _Response.RESOURCE_PARSE_ERROR) from None
    load(simulator, world)
    return _Response(result=OK, world=_resource_of(simulator.world))


SERVICES = (
    Service(GetAvailableWorlds, _get_available_worlds, features=(SimulatorFeatures.AVAILABLE_WORLDS,)),
    Service(GetCurrentWorld, _get_current_world, features=(SimulatorFeatures.WORLD_INFO_GETTING,)),
    Service(
        LoadWorld,
        _load_world,
        changes_world=True,
        resolve=_resolve_world,
        features=(SimulatorFeatures.WORLD_LOADING, SimulatorFeatures.WORLD_RESOURCE_STRING),
        example={"uri": "scenario1"},
    ),
)
