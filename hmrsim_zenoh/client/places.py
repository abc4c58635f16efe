"""The places of the world by name, queried from the simulator upon first use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.geometry_msgs import PoseStamped

if TYPE_CHECKING:
    from hmrsim.interfaces.geometry_msgs import Pose
    from hmrsim.interfaces.simulation_interfaces import GetNamedPoses


_STAMPED: Final = PoseStamped()


class NamedPlaces:
    """Named poses: waypoints, places, docks.

    Args:
        ask: Asks ``get_named_poses`` for all, and returns the response.
    """

    def __init__(self, ask: Callable[[], GetNamedPoses.Response]) -> None:
        self._ask = ask
        self._known: Mapping[str, Pose] | None = None
        self._stamped: dict[str, PoseStamped] = {}

    def pose(self, name: str) -> PoseStamped:
        """Return the pose of a place.

        Raises:
            ValueError: There is no such place.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError: The simulator does not answer.
        """
        found = self._stamped.get(name)
        if found is None:
            known = self.load()
            if name not in known:
                raise ValueError(f"no place {shown(name)}{instead(name, sorted(known))}")
            # A copy is not validated again.
            found = self._stamped[name] = _STAMPED.model_copy(update={"pose": known[name]})
        return found

    def load(self) -> Mapping[str, Pose]:
        """Return the poses by name; the first time they are asked for.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError: The simulator does not answer.
        """
        if self._known is None:
            self._known = {named.name: named.pose for named in self._ask().poses}
        return self._known
