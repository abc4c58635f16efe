"""The PettingZoo environment: each robot is an agent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv

from hmrsim_gym.episodes import Episodes
from hmrsim_gym.observations import Observation, observation_space
from hmrsim_gym.setting import SEEDS, Setting

if TYPE_CHECKING:
    from hmrsim.simulation.demand import Order
    from hmrsim.trials.model import AnyWorld
    from hmrsim_gym.dispatching import Dispatching


class ParallelDispatch(ParallelEnv[str, Observation, int]):  # type: ignore[misc]  # without types
    """Each robot chooses its own orders, as an agent; create the environment with `parallel_env`.

    A step ends at the next time at which a robot has to decide. The masks of the other robots allow only to wait, the
    last action. If two robots choose the same order, the one that the world names first gets it, and the other waits.
    All agents get the same reward, that of ``hmrsim/Dispatch-v0``.

    Attributes:
        possible_agents: The robots, in the world's order.
        agents: The robots of the current episode, in the same order; empty when it is over.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "hmrsim_dispatch_v0", "render_modes": ["ansi"]}

    def __init__(self, setting: Setting, render_mode: str | None = None) -> None:
        self.render_mode = render_mode
        self.possible_agents = [*setting.robots]
        self.agents: list[str] = []
        self._episodes = Episodes(setting, render_mode)
        self._random = np.random.default_rng()
        self.observation_spaces = {robot: observation_space(setting.orders) for robot in setting.robots}
        self.action_spaces = {robot: spaces.Discrete(setting.orders + 1) for robot in setting.robots}
        self._choices: dict[str, list[Order]] = {}

    def observation_space(self, agent: str) -> spaces.Dict:
        """Return the space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """Return the space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(
        self,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - PettingZoo's
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode, up to its first decision.

        *seed* is that of the world; without it, the environment's random numbers choose one. *options* are ignored.
        """
        if seed is not None:
            self._random = np.random.default_rng(seed)
        run = self._episodes.begin(int(self._random.integers(SEEDS)) if seed is None else seed)
        self.agents = [*self.possible_agents]
        return self._observed(run)

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Apply the decisions of the robots, and let time pass until the next decision.

        Raises:
            ValueError: There is no episode, or it is over.
        """
        run, agents = self._episodes.run, self.agents
        if run is None or not agents:
            raise ValueError("the episode is over, or none has begun; call reset first")
        taken: list[str] = []
        for robot, choices in self._choices.items():
            number = int(actions.get(robot, len(choices)))
            if 0 <= number < len(choices) and choices[number].name not in taken:
                taken.append(choices[number].name)
                run.assign(robot, choices[number])
            else:
                run.wait(robot)
        reward, ended, over = self._episodes.run_on(run), run.ended, run.over
        observations, infos = self._observed(run)
        if over:
            self.agents = []
        return (
            observations,
            dict.fromkeys(agents, reward),
            dict.fromkeys(agents, ended),
            dict.fromkeys(agents, over and not ended),
            infos,
        )

    def render(self) -> str | None:
        """Return the time, the state of each robot and the orders that are free; None without a render mode."""
        return self._episodes.render()

    def state(self) -> Any:
        """Return the observations of all agents as one array.

        Raises:
            ValueError: There is no episode.
        """
        run = self._episodes.run
        if run is None:
            raise ValueError("none has begun; call reset first")
        observations, _ = self._observed(run)
        return np.concatenate([part.ravel() for parts in observations.values() for part in parts.values()])

    def close(self) -> None:
        """End the current episode, if there is one."""
        self._episodes.end()

    def _observed(self, run: Dispatching) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        observer, asking = self._episodes.observer, [] if run.over else run.asking
        self._choices = {robot: observer.choices(run, robot) for robot in asking}
        observations = {
            robot: observer.observe(run, robot, self._choices.get(robot, ())) for robot in self.possible_agents
        }
        infos = {
            robot: {
                "action_mask": observation["action_mask"],
                "orders": [order.name for order in self._choices.get(robot, ())],
                "now": run.now,
            }
            for robot, observation in observations.items()
        }
        return observations, infos


def parallel_env(
    world: AnyWorld = "warehouse_orders",
    *,
    changes: Mapping[str, Any] | None = None,
    robots: Sequence[str] | None = None,
    horizon: float = 1800.0,
    orders: int = 8,
    charge_below: float = 0.25,
    render_mode: str | None = None,
) -> ParallelDispatch:
    """Return an environment in which each robot is an agent; the arguments are those of `DispatchEnv`.

    Raises:
        WorldError: The world is invalid; it has all errors.
        ValueError: An argument is out of range, or there is nothing to dispatch.
    """
    setting = Setting.of(
        world, changes=changes, robots=robots, horizon=horizon, orders=orders, charge_below=charge_below
    )
    return ParallelDispatch(setting, render_mode)
