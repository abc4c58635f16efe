"""The description of a served simulation: ``_world/info``, the other latched topics of the world, and the sessions."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Final

import zenoh
from pydantic_core import to_json

import hmrsim
from hmrsim.errors import printable
from hmrsim.protocol.goal import WORLD
from hmrsim.services import registry as all_services
from hmrsim.simulation.snapshot import scene
from hmrsim.world.route_graph import to_geojson
from hmrsim.world_checks import world_hash
from hmrsim.world_checks.resolved import shown
from hmrsim_zenoh.server.decode_time import SERVICE_TYPES
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import dump

if TYPE_CHECKING:
    from hmrsim.protocol.time import TimeState
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing
    from hmrsim.world.model import World
    from hmrsim_zenoh.wire.access_control import AccessControl

_TYPES = {
    "info": encoding.INFO,
    "route_graph": encoding.ROUTE_GRAPH,
    "demand": encoding.DEMAND,
    "scene": encoding.SCENE,
    "view": encoding.VIEW,
}


class Description:
    """Describes a simulation; long descriptions are cached until `forget`.

    Args:
        time: Returns what knows the clock and its rate.
        sessions: The connected sessions, if the simulator is secured.

    Attributes:
        policy: The access control that the session enforces; None if it has none.
        hurries: Returns whether simulated time may run faster than wall time.
    """

    def __init__(
        self,
        simulator: Simulator,
        time: Callable[[], TimeState | Pacing],
        run_id: str = "",
        sessions: Sessions | None = None,
        *,
        hurries: Callable[[], bool] = lambda: True,
    ) -> None:
        self.hurries = hurries
        self.policy = sessions.policy if sessions else None
        self._sessions = sessions
        self._simulator = simulator
        self._run_id = run_id
        self._time = time
        self._info: dict[str, Any] | None = None
        self._route_graph: bytes | None = None
        self._view: tuple[World | None, bytes] = (None, b"")

    @cached_property
    def plans_externally(self) -> bool:
        """Return whether a robot drives the paths of an external planner."""
        return any(robot.planner == "external" for robot in self._simulator.robots.values())

    def forget(self) -> None:
        """Drop all cached descriptions, as the world has changed."""
        self._info = self._route_graph = None
        self.__dict__.pop("plans_externally", None)

    @property
    def serves(self) -> dict[str, list[str]]:
        """The names of the actions of each robot."""
        actions_of = self._simulator.dispatcher.servers.actions_of
        return {name: actions_of(name) for name in self._simulator.robots}

    @property
    def aliases(self) -> Mapping[str, str]:
        """The aliases of actions in this world."""
        return self._simulator.world.remap

    @property
    def latched(self) -> dict[str, tuple[str, Callable[[], bytes]]]:
        """The latched topics: the encoding, and a function that returns the payload."""
        makers = {
            "info": self.info,
            "route_graph": self.route_graph,
            "demand": self.demand,
            "scene": self.scene,
            "view": self.view,
        }
        found: dict[str, tuple[str, Callable[[], bytes]]] = {
            topic: (_TYPES[topic], maker) for topic, maker in makers.items()
        }
        return found if self._sessions is None else {**found, "sessions": (self._sessions.mime, self._sessions.payload)}

    def info(self) -> bytes:
        """Return the handshake."""
        self._info = self._info or self._described()
        return dump({**self._info, **self._present()})

    def info_values(self) -> dict[str, Any]:
        """Return the handshake as plain values, which the caller may modify."""
        return {**self._described(), **self._present()}

    def route_graph(self) -> bytes:
        """Return the lanes that are open to the robots."""
        if self._route_graph is None:
            graph = to_geojson(self._simulator.world, closed=self._simulator.graph.closed, lifts=True)
            self._route_graph = json.dumps(graph).encode()
        return self._route_graph

    def demand(self) -> bytes:
        """Return the open orders, and how many there were."""
        return to_json(self._simulator.demand.as_dict())

    def scene(self) -> bytes:
        """Return the current scene."""
        # Ten times as fast as json, which matters with a thousand robots.
        return to_json(scene(self._simulator))

    def view(self) -> bytes:
        """Return the static data for viewers: the world with its defaults, and forms."""
        world = self._simulator.world
        if self._view[0] is not world:
            self._view = world, to_json(shown(world))
        return self._view[1]

    def _present(self) -> dict[str, Any]:
        time = self._time()
        present = self._simulator.plans.present
        return {"clock": time.clock, "real_time_factor": time.real_time_factor, "planner_present": present}

    def _described(self) -> dict[str, Any]:
        simulator, actions_of = self._simulator, self._simulator.dispatcher.servers.actions_of
        world = simulator.world
        return {
            "contract": hmrsim.CONTRACT,
            "hmrsim": hmrsim.__version__,
            "run_id": self._run_id,
            "world": {"name": world.name, "hash": world_hash(world), "units": world.units},
            "robots": [
                {
                    "name": name,
                    "type": robot.type,
                    "components": list(robot.components),
                    "actions": actions_of(name),
                    "planner": robot.planner,
                    "tags": list(robot.tags),
                }
                for name, robot in simulator.robots.items()
            ],
            "places": [{"name": name, "tags": list(place.tags)} for name, place in world.places.items()],
            "actions": actions_of(WORLD),
            "aliases": dict(world.remap),
            "services": [{"name": name, "type": type_} for name, type_ in _service_types().items()],
        }


@cache
def _service_types() -> dict[str, str]:
    types = {name: encoding.ros_type(mime) for name, mime in _TYPES.items()}
    types |= SERVICE_TYPES
    types |= {name: service.ros_type for name, service in all_services().items()}
    return {f"{WORLD}/{name}": type_ for name, type_ in types.items()}


_MAX_LOGGED: Final = 100
"""The number of names without rights that are logged, each once."""

_log = logging.getLogger(__name__)


class Sessions:
    """Follows the connections and logs clients without rights: Zenoh accepts them, but drops their messages.

    Attributes:
        policy: The access control that the session enforces.
    """

    mime: Final = f"{encoding.JSON};hmrsim/Sessions"

    def __init__(self, session: zenoh.Session, policy: AccessControl) -> None:
        self.policy = policy
        self._names: dict[str, str] = {}
        self._logged: set[str] = set()
        handler = zenoh.handlers.Callback(self._on_event, indirect=False)
        self._listener = session.info.declare_link_events_listener(handler, history=True)

    def payload(self) -> bytes:
        """Return the name on the certificate of each session."""
        return dump({"sessions": [{"session": zid, "name": name} for zid, name in sorted(self._names.copy().items())]})

    def _on_event(self, event: zenoh.LinkEvent) -> None:
        """Process a connection that came or went; called in Zenoh's thread."""
        zid, name = str(event.link.zid), event.link.auth_identifier or ""
        if event.kind == zenoh.SampleKind.DELETE:
            self._names.pop(zid, None)
            return
        self._names[zid] = name
        if name not in self.policy.rules and name not in self._logged and len(self._logged) < _MAX_LOGGED:
            self._logged.add(name)
            _log.warning("%r is denied everything: it is revoked, or no member of the policy", printable(name))
