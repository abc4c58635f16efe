"""A minimal environment for dispatching in pure simpy: orders and robots, without lanes, traffic, goals or faults."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import gymnasium
import numpy as np
import simpy

from hmrsim.geometry import distance

if TYPE_CHECKING:
    from hmrsim.geometry import Point

_ROWS: Final = 8
_HANDLING: Final = 5.0
"""Seconds to pick up or to place an item."""
_SPEED: Final = 1.0


class Job(NamedTuple):
    """An order.

    Attributes:
        at: When it arrives, in seconds.
        source: Where its item lies.
        target: Where it is delivered.
    """

    at: float
    source: Point
    target: Point


class SimpyDispatch(gymnasium.Env[Any, int]):
    """Robots that drive straight to the items of orders, one decision a step, as in `hmrsim_gym.DispatchEnv`."""

    def __init__(self, starts: Sequence[Point], horizon: float) -> None:
        self.observation_space = gymnasium.spaces.Box(0.0, np.inf, (_ROWS, 2), np.float32)
        self.action_space = gymnasium.spaces.Discrete(_ROWS)  # type: ignore[assignment]  # of numpy's integers
        self._starts, self._horizon = starts, horizon
        self._jobs: Sequence[Job] = ()

    def give(self, jobs: Sequence[Job]) -> None:
        """Set the orders of the next episode."""
        self._jobs = jobs

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, up to its first decision."""
        super().reset(seed=seed, options=options)
        self._env = simpy.Environment()
        self._points = [*self._starts]
        self._idle = [*range(len(self._starts))]
        self._free: list[Job] = []
        self._late = 0.0
        self._env.process(self._arrivals())
        return self._run_on(), {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Give an order to the robot that decides, and let time pass until the next decision."""
        before = self._env.now
        self._env.process(self._serve(self._idle.pop(0), self._free.pop(action)))
        observation = self._run_on()
        reward = -(self._env.now - before) * len(self._free)
        return observation, reward, False, self._env.now >= self._horizon, {}

    def _run_on(self) -> Any:
        env = self._env
        while not (self._idle and self._free) and env.peek() < self._horizon:
            env.step()
        observation = np.zeros((_ROWS, 2), np.float32)
        if not (self._idle and self._free):
            env.run(self._horizon)
            return observation
        here = self._points[self._idle[0]]
        for row, job in enumerate(self._free[:_ROWS]):
            observation[row] = distance(here, job.source), env.now - job.at
        return observation

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
