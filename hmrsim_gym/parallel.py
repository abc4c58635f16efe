"""The environment of PettingZoo: each robot is an agent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv

from hmrsim_gym.cost import Cost
from hmrsim_gym.dispatching import Dispatching
from hmrsim_gym.features import Observation, observation_space
from hmrsim_gym.observing import Observer
from hmrsim_gym.rendering import rendered
from hmrsim_gym.setting import SEEDS, AnyWorld, Setting

if TYPE_CHECKING:
    from hmrsim.simulation.orders import Order


class ParallelDispatch(ParallelEnv[str, Observation, int]):  # type: ignore[misc]  # without types
    """Robots choose orders themselves, each as an agent; `parallel_env` makes it.

    A step goes to the next time at which any robot asks. The others have a mask that allows only to wait, the last
    action. Where two choose one order, the robot that the world names first gets it, and the other one waits. All have
    the same reward, which is that of ``hmrsim/Dispatch-v0``.

    Attributes:
        possible_agents: The robots, in the world's order.
        agents: Likewise; none when an episode is over.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "hmrsim_dispatch_v0", "render_modes": ["ansi"]}

    def __init__(self, setting: Setting, render_mode: str | None = None) -> None:
        self.render_mode = render_mode
        self.possible_agents = [*setting.robots]
        self.agents: list[str] = []
        self._setting = setting
        self._observer = Observer(setting)
        self._random = np.random.default_rng()
        self.observation_spaces = {robot: observation_space(setting.orders) for robot in setting.robots}
        self.action_spaces = {robot: spaces.Discrete(setting.orders + 1) for robot in setting.robots}
        self._run: Dispatching | None = None
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

        Args:
            seed: The seed of the world; without one it is chosen by the environment's random numbers.
            options: None are known.
        """
        self.close()
        if seed is not None:
            self._random = np.random.default_rng(seed)
        run = self._run = Dispatching(self._setting, int(self._random.integers(SEEDS)) if seed is None else seed)
        self._cost = Cost(run.demand)
        run.run_on()
        self._cost.up_to(run.now)
        self.agents = [*self.possible_agents]
        return self._observed(run)

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Tell the robots that ask what to do, and go on to the next decision.

        Raises:
            ValueError: There is no episode, or it is over.
        """
        run, agents = self._run, self.agents
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
        run.run_on()
        reward, ended, over = -self._cost.up_to(run.now), run.ended, run.over
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
        """Return the time, what robots do and which orders are free; None without a render mode."""
        if self.render_mode is None or self._run is None:
            return None
        return rendered(self._setting, self._run)

    def state(self) -> Any:
        """Return the observations of all agents, one after another.

        Raises:
            ValueError: There is no episode.
        """
        if self._run is None:
            raise ValueError("none has begun; call reset first")
        seen, _ = self._observed(self._run)
        return np.concatenate([part.ravel() for each in seen.values() for part in each.values()])

    def close(self) -> None:
        """End the episode."""
        run, self._run = self._run, None
        if run is not None:
            run.close()

    def _observed(self, run: Dispatching) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        asking = [] if run.over else run.asking
        self._choices = {robot: self._observer.choices(run, robot) for robot in asking}
        seen = {
            robot: self._observer.observe(run, robot, self._choices.get(robot, ())) for robot in self.possible_agents
        }
        infos = {
            robot: {
                "action_mask": each["action_mask"],
                "orders": [order.name for order in self._choices.get(robot, ())],
                "now": run.now,
            }
            for robot, each in seen.items()
        }
        return seen, infos


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
        WorldError: Something is wrong with the world; it has all errors.
        ValueError: An argument is out of range, or there is nothing to dispatch.
    """
    if render_mode not in {None, "ansi"}:
        raise ValueError(f"render_mode must be None or 'ansi', got {render_mode!r}")
    setting = Setting.of(
        world, changes=changes, robots=robots, horizon=horizon, orders=orders, charge_below=charge_below
    )
    return ParallelDispatch(setting, render_mode)
