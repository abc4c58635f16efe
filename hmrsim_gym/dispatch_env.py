"""The Gymnasium environment: one agent assigns orders to all robots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from hmrsim_gym.episodes import Episodes
from hmrsim_gym.observations import Observation, observation_space
from hmrsim_gym.setting import SEEDS, Setting

if TYPE_CHECKING:
    from hmrsim.simulation.demand import Order
    from hmrsim.trials.model import AnyWorld
    from hmrsim_gym.dispatching import Dispatching


class DispatchEnv(gymnasium.Env[Observation, int]):
    """Dispatch the orders of a world to its robots; each step is one decision, however long the time to the next.

    Action *i* gives the robot that decides, ``info["robot"]``, the order in row *i* of the observation. The last action
    makes it wait until an order arrives or becomes free, or another robot becomes idle. A masked action does the same.
    The reward is minus the cost of the orders since the previous step: see `hmrsim_gym.episodes`.

    An episode is truncated at the horizon. It is terminated when all orders have ended and no more will arrive.

    Args:
        world: The world; it needs a demand.
        changes: Changes to the world, by path, as with ``--overlay``.
        robots: The robots that serve orders; all that can pick items up and have no script if left out.
        horizon: Simulated seconds after which an episode is truncated.
        orders: The maximum number of orders that a robot can choose from.
        charge_below: The share of its battery below which an idle robot goes to a charger.
        render_mode: ``ansi`` for a text, or None.

    Raises:
        WorldError: The world is invalid; it has all errors.
        ValueError: An argument is out of range, or there is nothing to dispatch.
    """

    # Decisions have no rate, but gymnasium's checker requires one.
    metadata: dict[str, Any] = {"render_modes": ["ansi"], "render_fps": 1}  # noqa: RUF012 - as gymnasium declares it

    def __init__(
        self,
        world: AnyWorld = "warehouse_orders",
        *,
        changes: Mapping[str, Any] | None = None,
        robots: Sequence[str] | None = None,
        horizon: float = 1800.0,
        orders: int = 8,
        charge_below: float = 0.25,
        render_mode: str | None = None,
    ) -> None:
        setting = Setting.of(
            world, changes=changes, robots=robots, horizon=horizon, orders=orders, charge_below=charge_below
        )
        self.render_mode = render_mode
        self.observation_space = observation_space(orders)  # type: ignore[assignment]  # of a dict of any arrays
        self.action_space = spaces.Discrete(orders + 1)  # type: ignore[assignment]  # of numpy's integers
        self._episodes = Episodes(setting, render_mode)
        self._robot = setting.robots[0]
        self._choices: list[Order] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, up to its first decision.

        *seed* is that of the world; without it, the environment's random numbers choose one. *options* are ignored.
        """
        super().reset(seed=seed, options=options)
        return self._observed(self._episodes.begin(int(self.np_random.integers(SEEDS)) if seed is None else seed))

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Apply the decision for the robot that decides, and let time pass until the next decision.

        Raises:
            ResetNeeded: There is no episode, or it is over.
        """
        run = self._episodes.run
        if run is None or run.over:
            raise ResetNeeded("the episode is over, or none has begun; call reset first")
        number = int(action)
        if 0 <= number < len(self._choices):
            run.assign(self._robot, self._choices[number])
        else:
            run.wait(self._robot)
        reward = self._episodes.run_on(run)
        observation, info = self._observed(run)
        return observation, reward, run.ended, run.over and not run.ended, info

    def render(self) -> str | None:
        """Return the time, the state of each robot and the orders that are free; None without a render mode."""
        return self._episodes.render()

    def close(self) -> None:
        """End the current episode, if there is one."""
        self._episodes.end()

    def _observed(self, run: Dispatching) -> tuple[Observation, dict[str, Any]]:
        observer, asking = self._episodes.observer, run.asking
        self._robot = asking[0] if asking else self._robot
        self._choices = observer.choices(run, self._robot) if asking and not run.over else []
        observation = observer.observe(run, self._robot, self._choices)
        totals = run.demand.totals
        return observation, {
            "action_mask": observation["action_mask"],
            "robot": self._robot,
            "orders": [order.name for order in self._choices],
            "now": run.now,
            "placed": totals.placed,
            "delivered": totals.delivered,
            "late": totals.late,
        }
