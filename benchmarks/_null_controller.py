"""A controller in lockstep that has next to nothing to decide: a Zenoh session, JSON, and the next waypoint."""

from __future__ import annotations

import json
import random
from typing import TYPE_CHECKING, Any

from benchmarks._wire import BARE, ask

if TYPE_CHECKING:
    import zenoh

    from hmrsim.world.model import World

_NAME = "null"
_TIME = "hmrsim/_world/time"


class NullController:
    """Sends each robot to a random waypoint, lets time move until a result comes, and sends that robot on.

    Args:
        session: An open session with the simulator, which no other participant may be awaited by.
        world: What is simulated.
        seed: Of the choice of waypoints.
        quantum: Simulated seconds after which it looks for results; 0 to be woken by each.

    Attributes:
        now: The simulated time.
        round_trips: Requests that were answered.
    """

    def __init__(self, session: zenoh.Session, world: World, seed: int = 1, quantum: float = 0.0) -> None:
        self._session = session
        self._chance = random.Random(seed)
        self._quantum = quantum
        self._goals = [{"pose": {"pose": {"position": {"x": x, "y": y}}}} for x, y in world.points.values()]
        self._idle = list(world.robots)
        joined = self._ask("join", {"name": _NAME})
        self._epoch, self.now = joined["epoch"], joined["now"]
        self.round_trips = 0

    def go_on(self, round_trips: int) -> None:
        """Let time move so often."""
        for _ in range(round_trips):
            self._advance()

    def pretend(self, round_trips: int) -> None:
        """Ask a bare query as often, with as many bytes, and write and read as much JSON as for the last advance."""
        for _ in range(round_trips):
            request = json.dumps(self._request()).encode()
            ask(self._session, BARE, request.ljust((len(request) + len(self._reply)) // 2))
            json.loads(self._reply)

    def _request(self) -> dict[str, Any]:
        commands = [
            {"robot": robot, "action": "navigate_to_pose", "goal": self._chance.choice(self._goals)}
            for robot in self._idle
        ]
        request: dict[str, Any] = {"participant": _NAME, "epoch": self._epoch, "commands": commands}
        if self._quantum:
            request |= {"until": self.now + self._quantum, "report": ["result"]}
        else:
            request["wake"] = ["result"]
        return request

    def _advance(self) -> None:
        granted = self._ask("advance", self._request())
        self._idle = [event["robot"] for event in granted["events"]]
        self._epoch, self.now = granted["epoch"], granted["now"]
        self.round_trips += 1

    def _ask(self, what: str, request: dict[str, Any]) -> dict[str, Any]:
        self._reply = ask(self._session, f"{_TIME}/{what}", json.dumps(request).encode())
        answer: dict[str, Any] = json.loads(self._reply)
        return answer
