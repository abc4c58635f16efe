"""Replace the world by another; the simulation is then stopped, at time 0."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import dotted
from hmrsim.errors import Problem, WorldError
from hmrsim.interfaces.simulation_interfaces import LoadWorld, Result, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._results import OK, failed
from hmrsim.services._worlds import resource_of
from hmrsim.simulation.reset import load
from hmrsim.world.formats.native import FORMAT
from hmrsim.world.options import AS_IT_IS
from hmrsim.world.writing import to_json
from hmrsim.world_checks.loading import load_world, world_of

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

_SOURCE: Final = "resource_string"
_Response = LoadWorld.Response


def _recorded(_simulator: Simulator, request: LoadWorld.Request) -> LoadWorld.Request | LoadWorld.Response:
    """Return the request with the world itself in it, or at once the response with the world's problems."""
    if not request.uri and not request.resource_string:
        why = "neither uri nor resource_string is given; expected a file, the name of a shipped world, or its text"
        return _Response(result=failed(why, _Response.NO_RESOURCE))
    try:
        world = load_world(request.uri.removeprefix("file://")).world if request.uri else _read(request.resource_string)
    except WorldError as error:
        missing = any(problem.message.startswith("no such file") for problem in error.problems)
        code = Result.RESULT_NOT_FOUND if missing else _Response.RESOURCE_PARSE_ERROR
        return _Response(result=failed(str(error), code))
    return LoadWorld.Request(resource_string=to_json(world))


def _read(text: str) -> World:
    """Return the world that a text describes.

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
    return world_of(document.data, _SOURCE)


def _serve(simulator: Simulator, request: LoadWorld.Request) -> LoadWorld.Response:
    load(simulator, _read(request.resource_string))
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
