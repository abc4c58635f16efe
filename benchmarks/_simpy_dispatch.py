"""A minimal environment for dispatching in pure simpy: orders and robots, without lanes, traffic, goals or faults."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import gymnasium
import numpy as np
import simpy

from hmrsim.geometry import distance
from hmrsim_gym.observations import FAR, Observation, OrderFeature, mask, observation_space

if TYPE_CHECKING:
    from hmrsim.geometry import Point

_ROWS: Final = 8
_MINUTE: Final = 60.0
_HANDLING: Final = 5.0
"""Seconds to pick up or to place an item."""
_SPEED: Final = 1.0


class Job(NamedTuple):
    """An order to deliver an item.

    Attributes:
        at: When it arrives, in seconds.
        source: Where its item lies.
        target: Where it is delivered.
    """

    at: float
    source: Point
    target: Point


class SimpyDispatch(gymnasium.Env[Observation, int]):
    """Robots that drive straight to the items of orders, with the steps and the observations of `DispatchEnv`."""

    def __init__(self, starts: Sequence[Point], horizon: float) -> None:
        self.observation_space = observation_space(_ROWS)  # type: ignore[assignment]  # of a dict of any arrays
        self.action_space = gymnasium.spaces.Discrete(_ROWS + 1)  # type: ignore[assignment]  # of numpy's integers
        self._starts, self._horizon = starts, horizon
        self._jobs: Sequence[Job] = ()

    def give(self, jobs: Sequence[Job]) -> None:
        """Set the orders of the next episode."""
        self._jobs = jobs

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, up to its first decision."""
        super().reset(seed=seed, options=options)
        self._env = simpy.Environment()
        self._points = [*self._starts]
        self._idle = [*range(len(self._starts))]
        self._free: list[Job] = []
        self._env.process(self._arrivals())
        return self._run_on(), {}

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Give an order to the robot that decides, and let time pass until the next decision."""
        before = self._env.now
        self._env.process(self._serve(self._idle.pop(0), self._free.pop(action)))
        observation = self._run_on()
        reward = -(self._env.now - before) * len(self._free)
        return observation, reward, False, self._env.now >= self._horizon, {}

    def _run_on(self) -> Observation:
        env = self._env
        while not (self._idle and self._free) and env.peek() < self._horizon:
            env.step()
        if not (self._idle and self._free):
            env.run(self._horizon)
        return self._observed()

    def _observed(self) -> Observation:
        choices, now = self._free[:_ROWS] if self._idle else [], self._env.now
        here, *others = [self._points[robot] for robot in self._idle or [0]]
        orders = np.zeros((_ROWS, len(OrderFeature)), np.float32)
        for row, job in enumerate(choices):
            approach = _minutes(distance(here, job.source))
            rival = min([_minutes(distance(other, job.source)) for other in others], default=FAR)
            trip, age = _minutes(distance(job.source, job.target)), _minutes(now - job.at)
            orders[row] = [1.0, approach, trip, age, FAR, 0.0, rival - approach]
        return {
            "robot": np.array([*here, 1.0], np.float32),
            "orders": orders,
            "fleet": np.array([now / self._horizon, len(self._free), 0.0, len(self._idle)], np.float32),
            "action_mask": mask(_ROWS, len(choices)),
        }

    def _arrivals(self) -> Generator[simpy.Event]:
        for job in self._jobs:
            yield self._env.timeout(job.at - self._env.now)
            self._free.append(job)

    def _serve(self, robot: int, job: Job) -> Generator[simpy.Event]:
        timeout = self._env.timeout
        yield timeout(distance(self._points[robot], job.source) / _SPEED)
        yield timeout(_HANDLING)
        yield timeout(distance(job.source, job.target) / _SPEED)
        yield timeout(_HANDLING)
        self._points[robot] = job.target
        self._idle.append(robot)


def _minutes(seconds: float) -> float:
    return min(seconds / _SPEED / _MINUTE, FAR)
