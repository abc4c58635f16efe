"""The places of the world by name, queried from the simulator upon first use."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.simulation_interfaces import GetNamedPoses
from hmrsim_zenoh.wire.envelopes import plain, read_often

if TYPE_CHECKING:
    from hmrsim.interfaces.geometry_msgs import Pose
    from hmrsim_zenoh.client.client import Client


class NamedPlaces:
    """Named poses: waypoints, places, docks."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._known: Mapping[str, Pose] | None = None

    def pose(self, name: str) -> PoseStamped:
        """Return the pose of a place.

        Raises:
            ValueError: There is no such place.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError: The simulator does not answer.
        """
        known = self._places()
        if name not in known:
            raise ValueError(f"no place {shown(name)}{instead(name, sorted(known))}")
        return PoseStamped(pose=known[name])

    def _places(self) -> Mapping[str, Pose]:
        if self._known is None:
            key = self._client.keys.world("get_named_poses")
            answer = self._client.get(key, payload=json.dumps({}).encode())
            response: GetNamedPoses.Response = read_often(plain(GetNamedPoses.Response), answer)
            self._known = {named.name: named.pose for named in response.poses}
        return self._known
